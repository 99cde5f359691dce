/* probability.c: incomplete beta and gamma functions by their series and continued fractions
 * [DLMF]. */
#include "image/probability.h"

#include <math.h>
#include <stdbool.h>

#include "core/vec.h"

static const double tiny = 1e-300; /* stands for 0 in a continued fraction's denominator */

static double away_from_zero(double x) { return fabs(x) < tiny ? tiny : x; }

/* A continued fraction by the modified Lentz method; numerators and denominators come in turn. True
 * when it has settled. */
typedef struct lentz {
    double value, c, d;
} lentz;

static bool lentz_step(lentz *state, double numerator, double denominator)
{
    state->d = 1.0 / away_from_zero(denominator + numerator * state->d);
    state->c = away_from_zero(denominator + numerator / state->c);
    const double factor = state->c * state->d;
    state->value *= factor;
    return fabs(factor - 1.0) < 1e-15;
}

/* log of Gamma(a + 1/2) / (Gamma(a) Gamma(1/2)) = 1/B(a, 1/2). */
static double log_inverse_beta_half(double a)
{
    if (a < 1000.0) {
        return lgamma(a + 0.5) - lgamma(a) - 0.5 * log(AIR_PI);
    }
    /* The difference would cancel; the series' next term is -21/(32768 a^4), below 1e-15
     * [DLMF, 5.11.13]. */
    const double series =
        1.0 - 1.0 / (8.0 * a) + 1.0 / (128.0 * a * a) + 5.0 / (1024.0 * a * a * a);
    return 0.5 * log(a / AIR_PI) + log(series);
}

/* I_x(a, b) where x < (a + 1)/(a + b + 2), in which the fraction converges fast [DLMF, 8.17.22].
 * log_front is the logarithm of x^a (1 - x)^b / B(a, b). */
static double beta_fraction(double x, double log_front, double a, double b)
{
    lentz state = {1.0, 1.0, 0.0};
    state.d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    state.value = state.d;
    /* Steps needed grow as sqrt(max(a, b)). */
    const double limit = 1000.0 + 10.0 * sqrt(fmax(a, b));
    for (double m = 1.0; m < limit; m += 1.0) {
        const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        (void)lentz_step(&state, even, 1.0);
        if (lentz_step(&state, odd, 1.0)) {
            break;
        }
    }
    return exp(log_front) / a * state.value;
}

double air_student_two_sided(double t, double nu)
{
    /* Beyond, p differs from the normal distribution's by about t^4/(4 nu) of itself. */
    if (nu > 1e10) {
        return erfc(fabs(t) * sqrt(0.5));
    }
    if (t == 0.0) {
        return 1.0;
    }
    if (isinf(t)) {
        return 0.0;
    }
    /* P = I_x(nu/2, 1/2) with x = nu/(nu + t^2) [DLMF, 8.17; Abramowitz1964, 26.7.1]. */
    const double ratio = t * t / nu;
    const double log_x = -log1p(ratio);
    const double log_rest = log(ratio) + log_x;
    const double x = 1.0 / (1.0 + ratio);
    const double a = 0.5 * nu;
    const double b = 0.5;
    const double log_front = a * log_x + b * log_rest + log_inverse_beta_half(a);
    if (x < (a + 1.0) / (a + b + 2.0)) {
        return beta_fraction(x, log_front, a, b);
    }
    return 1.0 - beta_fraction(ratio * x, log_front, b, a);
}

double air_chi_square_upper(double x, double n)
{
    const double a = 0.5 * n;
    const double y = 0.5 * x;
    if (y <= 0.0) {
        return 1.0;
    }
    if (isinf(y)) {
        return 0.0;
    }
    const double front = exp(a * log(y) - y - lgamma(a));
    const double limit = 1000.0 + 20.0 * sqrt(a);
    if (y < a + 1.0) { /* 1 - P(a, y) by its series [DLMF, 8.7.1] */
        double term = 1.0 / a;
        double sum = term;
        for (double k = 1.0; k < limit && term > 1e-17 * sum; k += 1.0) {
            term *= y / (a + k);
            sum += term;
        }
        return fmax(1.0 - front * sum, 0.0);
    }
    /* Q(a, y) by its continued fraction [DLMF, 8.9.2] */
    double b = y + 1.0 - a;
    lentz state = {1.0 / away_from_zero(b), 1.0 / tiny, 1.0 / away_from_zero(b)};
    for (double k = 1.0; k < limit; k += 1.0) {
        b += 2.0;
        if (lentz_step(&state, -k * (k - a), b)) {
            break;
        }
    }
    return front * state.value;
}

double air_normal_two_sided_score(double p)
{
    const double log_p = log(fmin(fmax(p, tiny), 1.0));
    /* Newton's method on log P(|Z| >= z), which is concave and at most -z^2/2: from that bound on,
     * steps go down to the root without passing it. */
    double z = sqrt(-2.0 * log_p);
    double step = 1.0;
    for (int i = 0; i < 100 && step > 1e-15 * z; i++) {
        const double tail = erfc(z * sqrt(0.5));
        const double slope = -sqrt(2.0 / AIR_PI) * exp(-0.5 * z * z) / tail;
        step = (log(tail) - log_p) / slope;
        z = fmax(z - step, 0.0);
    }
    return z;
}

double air_sidak(double p, double n) { return p >= 1.0 ? 1.0 : -expm1(n * log1p(-p)); }
