/* chi_square.h: does a histogram come from the distribution it should? For tests of samplers. */
#ifndef AIR_TESTS_CHI_SQUARE_H
#define AIR_TESTS_CHI_SQUARE_H

#include <float.h>
#include <math.h>
#include <stddef.h>

/* The regularised upper incomplete gamma function Q(a, x), a > 0, x >= 0: the series of P below x =
 * a + 1, the continued fraction of Q (modified Lentz) above [DLMF, 8.7.1 and 8.9.2]. Relative error
 * about 1e-13. */
static inline double gamma_q(double a, double x)
{
    if (x <= 0.0) {
        return 1.0;
    }
    const double scale = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double n = a + 1.0; term > sum * DBL_EPSILON; n += 1.0) {
            term *= x / n;
            sum += term;
        }
        return 1.0 - scale * sum;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, fraction = d;
    for (double n = 1.0; n < 100000.0; n += 1.0) {
        const double numerator = n * (a - n);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= c * d;
        if (fabs(c * d - 1.0) < 4.0 * DBL_EPSILON) {
            break;
        }
    }
    return scale * fraction;
}

/* Pearson's test: the probability that counts drawn from `expected` deviate at least as far as
 * `observed` do. Both are counts with the same sum. Bins that expect fewer than 5 are pooled with
 * those after them (the last pool joins the one before), as the chi-square limit demands. *out_dof
 * (may be NULL) is the number of pools - 1. Returns 0 if something was observed where nothing is
 * expected, 1 if there is only one pool. */
static inline double chi_square_p(const double *observed, const double *expected, size_t bins,
                                  size_t *out_dof)
{
    double statistic = 0.0, last_o = 0.0, last_e = 0.0, pool_o = 0.0, pool_e = 0.0;
    size_t pools = 0;
    for (size_t i = 0; i < bins; ++i) {
        if (expected[i] <= 0.0 && observed[i] > 0.0) {
            return 0.0;
        }
        pool_o += observed[i];
        pool_e += expected[i];
        if (pool_e >= 5.0) {
            if (pools > 0) {
                statistic += (last_o - last_e) * (last_o - last_e) / last_e;
            }
            last_o = pool_o;
            last_e = pool_e;
            pool_o = pool_e = 0.0;
            ++pools;
        }
    }
    last_o += pool_o;
    last_e += pool_e;
    if (last_e > 0.0) {
        statistic += (last_o - last_e) * (last_o - last_e) / last_e;
    }
    const size_t dof = pools > 1 ? pools - 1 : 0;
    if (out_dof != NULL) {
        *out_dof = dof;
    }
    return dof > 0 ? gamma_q(0.5 * (double)dof, 0.5 * statistic) : 1.0;
}

#endif
