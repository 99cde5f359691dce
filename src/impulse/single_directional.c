/* single_directional.c: one event, directional light into a half space: (D1), and slabs: (D2). */
#include <math.h>

#include "core/vec.h"
#include "impulse/single.h"

/* h of (D1): the integral of exp(-t q) over the ray in the medium, t from 0 to the boundary at
 * tau/mu, where q = (1 - mu)/... is per unit of depth along the ray. */
static double lit_length(double tau, double mu)
{
    const double x = 1.0 - mu;
    if (mu <= 0.0) {
        return 1.0 / x;
    }
    return x > 0.0 ? -expm1(-tau * x / mu) / x : tau;
}

void impulse_directional_scaled(const impulse_quality *quality, double tau, const double *g,
                                int g_count, int order, double *out, int stride)
{
    graded_list mu = {.count = 0};
    double y[AIR_IMPULSE_ORDER];
    int peak = 6;
    for (int i = 0; i < g_count; i++) {
        /* the peak's width in mu is the square of that in the angle */
        peak = 2 * impulse_peak_levels(g[i], 3) > peak ? 2 * impulse_peak_levels(g[i], 3) : peak;
        for (int l = 0; l < order; l++) {
            out[i * stride + l] = 0.0;
        }
    }
    graded_both(&mu, &quality->rule, 0.0, 1.0, quality->levels, peak);
    graded_both(&mu, &quality->rule, -1.0, 0.0, peak, 2);
    for (int j = 0; j < mu.count; j++) {
        const double lit = 2.0 * AIR_PI * mu.w[j] * lit_length(tau, mu.x[j]);
        air_zh_evaluate(order, mu.x[j], y);
        for (int i = 0; i < g_count; i++) {
            const double weight = lit * impulse_phase(g[i], mu.x[j]);
            for (int l = 0; l < order; l++) {
                out[i * stride + l] += weight * y[l];
            }
        }
    }
}

void air_impulse_directional(double tau, double g, int order, double *out_zh)
{
    const impulse_quality quality = impulse_quality_fine();
    impulse_directional_scaled(&quality, tau, &g, 1, order, out_zh, order);
    for (int l = 0; l < order; l++) {
        out_zh[l] *= exp(-tau);
    }
}

/* ---- slabs ---- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* L_1 / alpha for optical depth tau_h below the boundary, to the optical distance end. */
static double slab_radiance(double g, const double l[3], const double n[3], double tau_h,
                            const double w[3], double end)
{
    const double l_n = dot(l, n), w_n = dot(w, n), cosine = dot(w, l);
    const double q = 1.0 - w_n / l_n;
    const double s = double_min(end, w_n > 0.0 ? tau_h / w_n : INFINITY);
    if (!(l_n > 0.0)) {
        return 0.0;
    }
    const double lit = fabs(q) * double_min(s, 1e3) < 1e-12 ? s : -expm1(-s * q) / q;
    return impulse_phase(g, cosine) * exp(-tau_h / l_n) * lit;
}

double air_impulse_slab_ray(double sigma_s, double sigma_t, double g, const double l[3],
                            const double n[3], double h, const double w[3], double t_end)
{
    return sigma_s / sigma_t * slab_radiance(g, l, n, sigma_t * h, w, sigma_t * t_end);
}

/* Polar coordinates about the boundary's normal: radiance is not smooth across w.n = 0, and steep
 * on its upper side. The receiver's clamped cosine cuts circles: each is integrated between the
 * cuts.
 */
static double circle(double g, const double l[3], const double n[3], double tau_h,
                     const double r[3], double w_n, const double s[3], const double t[3],
                     const graded_rule *rule)
{
    const double sine = sqrt(double_max(0.0, 1.0 - w_n * w_n));
    const double a = w_n * dot(r, n), b = sine * hypot(dot(r, s), dot(r, t));
    if (a <= -b) {
        return 0.0;
    }
    const double half = a >= b ? AIR_PI : acos(-a / b);
    const double middle = atan2(dot(r, t), dot(r, s));
    enum { PIECES = 6 };
    double sum = 0.0;
    for (int piece = 0; piece < PIECES; piece++) {
        for (int i = 0; i < rule->nodes; i++) {
            const double phi = middle + half * (2.0 * (piece + rule->x[i]) / PIECES - 1.0);
            double w[3];
            for (int k = 0; k < 3; k++) {
                w[k] = w_n * n[k] + sine * (cos(phi) * s[k] + sin(phi) * t[k]);
            }
            sum += rule->w[i] * double_max(0.0, dot(w, r)) *
                   slab_radiance(g, l, n, tau_h, w, INFINITY);
        }
    }
    return sum * 2.0 * half / PIECES;
}

double air_impulse_slab_irradiance(double alpha, double g, const double l[3], const double n[3],
                                   double tau_h, const double r[3])
{
    const graded_rule rule = graded_rule_make(12);
    const double l_n = dot(l, n), across = sqrt(double_max(0.0, 1.0 - l_n * l_n));
    const double cut = dot(r, n); /* circles at +-sqrt(1 - cut^2) touch the receiver's horizon */
    double s[3], t[3], sum = 0.0;
    for (int k = 0; k < 3; k++) {
        s[k] = across > 1e-9 ? (l[k] - l_n * n[k]) / across : (fabs(n[0]) < 0.5) == (k == 0);
    }
    const double along = dot(s, n);
    for (int k = 0; k < 3; k++) {
        s[k] -= along * n[k];
    }
    const double length = sqrt(dot(s, s));
    for (int k = 0; k < 3; k++) {
        s[k] /= length;
    }
    for (int k = 0; k < 3; k++) {
        t[k] = n[(k + 1) % 3] * s[(k + 2) % 3] - n[(k + 2) % 3] * s[(k + 1) % 3];
    }
    const double touch = sqrt(double_max(0.0, 1.0 - cut * cut));
    const double ends[5] = {-1.0, -touch, 0.0, touch, 1.0};
    for (int piece = 0; piece < 4; piece++) {
        graded_list z = {.count = 0};
        if (ends[piece + 1] - ends[piece] < 1e-12) {
            continue;
        }
        graded_both(&z, &rule, ends[piece], ends[piece + 1], 12, 12);
        for (int i = 0; i < z.count; i++) {
            sum += z.w[i] * circle(g, l, n, tau_h, r, z.x[i], s, t, &rule);
        }
    }
    return alpha * sum;
}
