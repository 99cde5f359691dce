/* multiple_directional.c: two or more events in a half space lit from infinity.
 *
 * By depth alone: c_l of order k is half the integral of Phi_(k-1)(t) K_l(tau - t) dt, K_l(x) the
 * integral of y_l(mu) exp(-x/mu)/mu over 0 < mu < 1, odd bands turned in sign for t > tau. Powers
 * of mu give exponential integrals. */
#include <math.h>

#include "core/harmonics.h"
#include "core/vec.h"
#include "impulse/multiple.h"

/* ---- exponential integrals ---- */

/* E_1(x), x > 0: the series below 1, Lentz's continued fraction above. */
static double exponential_integral_1(double x)
{
    const double euler = 0.57721566490153286061;
    if (x < 1.0) {
        double sum = -euler - log(x), term = 1.0;
        for (int n = 1; n < 30; n++) {
            term *= -x / n;
            sum -= term / n;
        }
        return sum;
    }
    double b = x + 1.0, c = 1e300, d = 1.0 / b, h = d;
    for (int n = 1; n < 200; n++) {
        const double a = -(double)n * n;
        b += 2.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        h *= c * d;
        if (fabs(c * d - 1.0) < 1e-15) {
            break;
        }
    }
    return h * exp(-x);
}

/* Coefficients of the zonal harmonics in powers of mu. */
typedef struct zonal_powers {
    int order;
    double at[AIR_IMPULSE_ORDER * AIR_IMPULSE_ORDER]; /* mu^n of y_l at l * order + n */
} zonal_powers;

static zonal_powers zonal_powers_make(int order)
{
    zonal_powers p = {.order = order};
    air_legendre_powers(order, p.at);
    for (int l = 0; l < order; l++) {
        for (int n = 0; n <= l; n++) {
            p.at[l * order + n] *= sqrt((2 * l + 1) / (4.0 * AIR_PI));
        }
    }
    return p;
}

static void depth_kernel(const zonal_powers *powers, double x, double *out)
{
    double e[AIR_IMPULSE_ORDER]; /* E_(n+1) */
    const double fall = exp(-x);
    e[0] = exponential_integral_1(x);
    for (int n = 1; n < powers->order; n++) {
        e[n] = (fall - x * e[n - 1]) / n;
    }
    for (int l = 0; l < powers->order; l++) {
        out[l] = 0.0;
        for (int n = l % 2; n <= l; n += 2) {
            out[l] += powers->at[l * powers->order + n] * e[n];
        }
    }
}

/* ---- fluences by depth ---- */

static const double half_end = 40.0;
enum { HALF_FINE = 14 }; /* panels below 1 */

static void make_edges(double *edges)
{
    edges[0] = 0.0;
    for (int i = 1; i <= HALF_FINE; i++) {
        edges[i] = ldexp(1.0, i - HALF_FINE);
    }
    for (int i = HALF_FINE + 1; i <= HALF_PANELS; i++) {
        const double share = (double)(i - HALF_FINE) / (HALF_PANELS - HALF_FINE);
        edges[i] = 1.0 + (half_end - 1.0) * share;
    }
}

static int panel_of(const double *edges, double t)
{
    int low = 0, high = HALF_PANELS;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (t < edges[middle]) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return low;
}

/* Weights of the panel's nodes in the value at t. */
static int interpolation(const double *edges, const graded_rule *rule, double t, double *weights)
{
    const int panel = panel_of(edges, t);
    const double x = (t - edges[panel]) / (edges[panel + 1] - edges[panel]);
    for (int i = 0; i < HALF_NODES; i++) {
        weights[i] = 1.0;
        for (int j = 0; j < HALF_NODES; j++) {
            weights[i] *= i == j ? 1.0 : (x - rule->x[j]) / (rule->x[i] - rule->x[j]);
        }
    }
    return panel * HALF_NODES;
}

/* Depths that give something at tau: halved towards the boundary and towards tau. */
static void depths(const graded_rule *rule, double tau, graded_list *out)
{
    out->count = 0;
    graded_both(out, rule, 0.0, tau, 12, 14);
    graded_towards(out, rule, tau, half_end, 18);
}

void impulse_half_space_solve(int k_max, impulse_half_space *out, double *matrix)
{
    const graded_rule nodes = graded_rule_make(HALF_NODES), rule = graded_rule_make(8);
    const zonal_powers powers = zonal_powers_make(1);
    graded_list t;
    double weights[HALF_NODES], kernel[AIR_IMPULSE_ORDER];
    out->k_max = k_max;
    make_edges(out->edges);
    for (int i = 0; i < HALF_COUNT; i++) {
        const int panel = i / HALF_NODES;
        const double width = out->edges[panel + 1] - out->edges[panel];
        const double tau = out->edges[panel] + width * nodes.x[i % HALF_NODES];
        double *const row = matrix + (size_t)i * HALF_COUNT;
        out->fluence[0][i] = exp(-tau);
        for (int j = 0; j < HALF_COUNT; j++) {
            row[j] = 0.0;
        }
        depths(&rule, tau, &t);
        for (int q = 0; q < t.count; q++) {
            const int first = interpolation(out->edges, &nodes, t.x[q], weights);
            depth_kernel(&powers, fabs(tau - t.x[q]), kernel);
            for (int j = 0; j < HALF_NODES; j++) {
                row[first + j] += 0.5 * t.w[q] * sqrt(4.0 * AIR_PI) * kernel[0] * weights[j];
            }
        }
    }
    for (int k = 1; k <= k_max; k++) {
        for (int i = 0; i < HALF_COUNT; i++) {
            out->fluence[k][i] = 0.0;
            for (int j = 0; j < HALF_COUNT; j++) {
                out->fluence[k][i] +=
                    matrix[(size_t)i * HALF_COUNT + (size_t)j] * out->fluence[k - 1][j];
            }
        }
    }
}

void impulse_directional_multiple(const impulse_half_space *self, double tau, int k_min, int k_max,
                                  int order, double *out, int stride)
{
    const graded_rule nodes = graded_rule_make(HALF_NODES), rule = graded_rule_make(8);
    const zonal_powers powers = zonal_powers_make(order);
    graded_list t;
    double weights[HALF_NODES], kernel[AIR_IMPULSE_ORDER];
    for (int k = k_min; k <= k_max; k++) {
        for (int l = 0; l < order; l++) {
            out[k * stride + l] = 0.0;
        }
    }
    depths(&rule, tau, &t);
    for (int q = 0; q < t.count; q++) {
        const int first = interpolation(self->edges, &nodes, t.x[q], weights);
        depth_kernel(&powers, fabs(tau - t.x[q]), kernel);
        for (int k = k_min; k <= k_max; k++) {
            double fluence = 0.0;
            for (int j = 0; j < HALF_NODES; j++) {
                fluence += weights[j] * self->fluence[k - 1][first + j];
            }
            fluence *= 0.5 * t.w[q] * exp(tau);
            for (int l = 0; l < order; l++) {
                const double sign = l % 2 == 1 && t.x[q] > tau ? -1.0 : 1.0;
                out[k * stride + l] += sign * fluence * kernel[l];
            }
        }
    }
}
