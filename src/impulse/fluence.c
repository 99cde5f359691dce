/* fluence.c: (M1), on a contour through the saddle instead of round the cut.
 *
 * Phi_k(r) = 2/(pi r) Im of the integral of s A(s)^(k+1) exp(-s r), A = atanh(s)/s, along any way
 * from a point 0 < s0 < 1 of the real axis, where all is real, through the upper half plane to
 * infinity. Round the cut s > 1 the powers of A's logarithm cancel: for k = 10 five digits are
 * lost, for k = 20 all. Where |s A^(k+1) exp(-s r)| is least along the axis it falls off across it,
 * and next to nothing cancels: k = 20 keeps 12 digits (tests/test_impulse_fluence.c). */
#include "impulse/fluence.h"

#include <math.h>

#include "core/vec.h"
#include "impulse/graded.h"

typedef struct complex_number {
    double re, im;
} complex_number;

static complex_number times(complex_number a, complex_number b)
{
    return (complex_number){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static complex_number over(complex_number a, complex_number b)
{
    const double square = b.re * b.re + b.im * b.im;
    return (complex_number){(a.re * b.re + a.im * b.im) / square,
                            (a.im * b.re - a.re * b.im) / square};
}

/* atanh(s)/s off the cut; toward_one is 1 - s, which may be known better. */
static complex_number a_of(complex_number s, complex_number toward_one)
{
    const complex_number ratio = over((complex_number){1.0 + s.re, s.im}, toward_one);
    const complex_number half_log = {0.25 * log(ratio.re * ratio.re + ratio.im * ratio.im),
                                     0.5 * atan2(ratio.im, ratio.re)};
    return over(half_log, s);
}

/* 1 - s0: where s A^(k+1) exp(-s r) is least, by golden section in log(1 - s). */
static double saddle(int k, double r)
{
    const double golden = 0.6180339887498949;
    double a = log(1e-12), b = log(0.95);
    for (int i = 0; i < 40; i++) {
        double value[2];
        const double x[2] = {b - golden * (b - a), a + golden * (b - a)};
        for (int j = 0; j < 2; j++) {
            const double s = 1.0 - exp(x[j]);
            const double atanh_s = 0.5 * (log(1.0 + s) - x[j]);
            value[j] = log(s) + (k + 1) * log(atanh_s / s) - s * r;
        }
        if (value[0] < value[1]) {
            b = x[1];
        } else {
            a = x[0];
        }
    }
    return exp(0.5 * (a + b));
}

static void fluences_at_saddle(double gap, int k_max, double r, double *out)
{
    const graded_rule rule = graded_rule_make(14);
    const double root = sqrt(0.5), end = 60.0 / (r * root);
    double from = 0.0, width = 0.5 * gap;
    for (int k = 0; k <= k_max; k++) {
        out[k] = 0.0;
    }
    while (from < end) {
        for (int i = 0; i < rule.nodes; i++) {
            const double t = root * (from + width * rule.x[i]);
            const complex_number s = {1.0 - gap + t, t}, a = a_of(s, (complex_number){gap - t, -t});
            /* exp(-(s - 1) r) ds */
            const double size = width * rule.w[i] * exp((gap - t) * r);
            const complex_number turn = {size * cos(t * r), -size * sin(t * r)};
            complex_number term = times(times(turn, (complex_number){root, root}), s);
            for (int k = 0; k <= k_max; k++) {
                term = times(term, a);
                out[k] += term.im;
            }
        }
        from += width;
        width = double_min(2.0 * width, 4.0 / r);
    }
    for (int k = 0; k <= k_max; k++) {
        out[k] *= 2.0 / (AIR_PI * r);
    }
}

void impulse_fluences_scaled(int k_max, double r, double *out)
{
    fluences_at_saddle(saddle(k_max / 2, r), k_max, r, out);
}

double air_impulse_point_fluence(int k, double r)
{
    double fluences[AIR_IMPULSE_BOUNCES_MAX + 1];
    if (k <= 0) {
        return exp(-r) / (r * r);
    }
    fluences_at_saddle(saddle(k, r), k, r, fluences);
    return exp(-r) * fluences[k];
}

/* ---- all orders ---- */

/* 1 - kappa for alpha atanh(kappa)/kappa = 1; 1 for alpha = 1. By bisection in ln(1 - kappa). */
static double diffusion_gap(double alpha)
{
    double a = -2.0 / alpha - 1.0, b = 0.0; /* 1 - kappa is near 2 exp(-2 kappa/alpha) */
    for (int i = 0; i < 200 && b - a > 1e-16 * fabs(a); i++) {
        const double x = 0.5 * (a + b), kappa = -expm1(x);
        if (0.5 * alpha * (log(1.0 + kappa) - x) > kappa) {
            a = x;
        } else {
            b = x;
        }
    }
    return exp(0.5 * (a + b));
}

double impulse_diffusion_rate(double alpha) { return 1.0 - diffusion_gap(alpha); }

/* 2 kappa exp(-kappa r)/(r alpha^2 A'(kappa)), A' = (1/(1 - kappa^2) - A)/kappa, A = 1/alpha. Near
 * alpha = 1, A' = 2 kappa/3 + 4 kappa^3/5 + ... */
static double diffusion_pole(double alpha, double r)
{
    const double gap = diffusion_gap(alpha), kappa = 1.0 - gap;
    if (alpha > 1.0 - 1e-7) {
        return 3.0 * exp(-sqrt(3.0 * (1.0 - alpha)) * r) / r;
    }
    const double slope =
        kappa < 0.02 ? kappa * (2.0 / 3.0 + kappa * kappa * (0.8 + kappa * kappa * 6.0 / 7.0))
                     : (1.0 / (gap * (1.0 + kappa)) - 1.0 / alpha) / kappa;
    return 2.0 * kappa * exp(-kappa * r) / (r * alpha * alpha * slope);
}

/* Round the cut, halved towards s = 1: there is no high power to cancel. */
static double all_orders(double alpha, double r)
{
    const graded_rule rule = graded_rule_make(10);
    double sum = 0.0, from = 0x1p-120;
    while (from * r < 50.0) {
        const double width = double_min(from, 4.0 / r);
        for (int i = 0; i < rule.nodes; i++) {
            const double e = from + width * rule.x[i], s = 1.0 + e;
            const complex_number a = {0.5 * log((e + 2.0) / e) / s, 0.5 * AIR_PI / s};
            const complex_number rest = {1.0 - alpha * a.re, -alpha * a.im};
            sum += width * rule.w[i] * s * over(a, rest).im * exp(-e * r);
        }
        from += width;
    }
    return 2.0 / (AIR_PI * r) * sum * exp(-r) + diffusion_pole(alpha, r);
}

double air_impulse_point_fluence_rest(int after, double alpha, double r)
{
    double known[AIR_IMPULSE_BOUNCES_MAX + 1], sum = 0.0, power = 1.0;
    const int last = after < AIR_IMPULSE_BOUNCES_MAX ? after : AIR_IMPULSE_BOUNCES_MAX;
    impulse_fluences_scaled(last, r, known);
    for (int k = 0; k <= last; k++, power *= alpha) {
        sum += power * (k == 0 ? 1.0 / (r * r) : known[k]);
    }
    return double_max(0.0, all_orders(alpha, r) - exp(-r) * sum);
}

/* ---- curves ---- */

static const double curve_first = 1e-5, curve_step = 0.09;

double impulse_curve_distance(int i) { return curve_first * exp(curve_step * i); }

impulse_curve_place impulse_curve_find(double r)
{
    impulse_curve_place place;
    const double x = log(r / curve_first) / curve_step;
    const double first = floor(x) - (CURVE_TAPS / 2 - 1);
    place.first = (int)double_min(double_max(first, 0.0), CURVE_POINTS - CURVE_TAPS);
    for (int i = 0; i < CURVE_TAPS; i++) {
        double weight = 1.0;
        for (int j = 0; j < CURVE_TAPS; j++) {
            weight *= i == j ? 1.0 : (x - place.first - j) / (i - j);
        }
        place.weights[i] = weight;
    }
    return place;
}
