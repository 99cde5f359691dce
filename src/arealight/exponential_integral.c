/* exponential_integral.c: E2 by its series for small arguments and its continued fraction. */
#include "arealight/exponential_integral.h"

#include <math.h>

/* [Abramowitz1964, 5.1.12], n = 2. At 1 the sum is 0.15 and its largest term 1, and the 17th one is
 * below 2e-16 of it. */
static double by_series(double x)
{
    const double euler_gamma = 0.57721566490153286061;
    double sum = 0.0, power = -x; /* (-x)^m / m! */
    for (int m = 2; m <= 18; m++) {
        power *= -x / m;
        sum += power / (m - 1);
    }
    return x > 0.0 ? (1.0 - sum) + x * (log(x) - (1.0 - euler_gamma)) : 1.0;
}

/* [Abramowitz1964, 5.1.22] in its even form, E_n = exp(-x)/(x + n - 1 n/(x + n + 2 - 2 (n + 1)/(x +
 * n + 4 - ...))), from its tail on. After k terms the relative error is about exp(-4 sqrt(k x)). */
static double by_fraction(double x)
{
    const int terms = (int)(90.0 / x) + 8;
    double denominator = x + 2.0 + 2.0 * terms;
    for (int k = terms; k >= 1; k--) {
        denominator = x + 2.0 * k - (double)k * (k + 1) / denominator;
    }
    return exp(-x) / denominator;
}

double air_exponential_integral_2(double x)
{
    if (!(x < 750.0)) {
        return 0.0; /* exp(-x) is */
    }
    return x <= 1.0 ? by_series(x) : by_fraction(x);
}
