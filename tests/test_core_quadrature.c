/* Gauss-Legendre. */
#include "core/quadrature.h"

#include <math.h>

#include "cmocka_test.h"

enum { MOST = 200 };

static void polynomials_up_to_degree_2n_minus_1_are_exact(void **state)
{
    (void)state;
    double x[MOST], w[MOST];
    for (size_t n = 1; n <= MOST; n = n < 32 ? n + 1 : n * 5 / 4) {
        air_gauss_legendre(n, x, w);
        for (size_t degree = 0; degree <= 2 * n - 1; ++degree) {
            double sum = 0.0;
            for (size_t i = 0; i < n; ++i) {
                sum += w[i] * pow(x[i], (double)degree);
            }
            const double exact = degree % 2 == 0 ? 2.0 / ((double)degree + 1.0) : 0.0;
            /* Nodes are good to 2^-53; x^degree multiplies that by its degree, the weights sum
             * to 2. */
            assert_true(fabs(sum - exact) < 0x1p-52 * (8.0 + (double)degree));
        }
    }
}

static void degree_2n_is_not_exact(void **state)
{
    (void)state;
    double x[8], w[8];
    for (size_t n = 1; n <= 8; ++n) {
        air_gauss_legendre(n, x, w);
        double sum = 0.0;
        for (size_t i = 0; i < n; ++i) {
            sum += w[i] * pow(x[i], 2.0 * (double)n);
        }
        assert_true(fabs(sum - 2.0 / (2.0 * (double)n + 1.0)) > 1e-6);
    }
}

static void nodes_rise_are_symmetric_and_weights_positive(void **state)
{
    (void)state;
    double x[MOST], w[MOST];
    for (size_t n = 1; n <= MOST; ++n) {
        air_gauss_legendre(n, x, w);
        for (size_t i = 0; i < n; ++i) {
            assert_true(x[i] > (i > 0 ? x[i - 1] : -1.0) && x[i] < 1.0);
            assert_true(x[i] == -x[n - 1 - i] && w[i] == w[n - 1 - i] && w[i] > 0.0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polynomials_up_to_degree_2n_minus_1_are_exact),
        cmocka_unit_test(degree_2n_is_not_exact),
        cmocka_unit_test(nodes_rise_are_symmetric_and_weights_positive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
