/* Spherical harmonics: orthonormal, rotated, and with the signs that are published. */
#include <math.h>

#include "cmocka_test.h"
#include "core/harmonics.h"
#include "core/quadrature.h"
#include "core/vec.h"

enum { ORDER = AIR_SH_ORDER_MAX, COUNT = AIR_SH_COUNT_MAX, NODES = 12, TURNS = 24 };

static void direction(double z, double phi, double out[3])
{
    const double s = sqrt(1.0 - z * z);
    out[0] = s * cos(phi);
    out[1] = s * sin(phi);
    out[2] = z;
}

/* Products of two are polynomials of degree 20 in z, trigonometric of degree 20 in phi: exact by 12
 * nodes and 24 angles but for rounding. */
static void they_are_orthonormal(void **state)
{
    static double gram[COUNT][COUNT];
    double x[NODES], w[NODES], y[COUNT], dir[3];
    (void)state;
    air_gauss_legendre(NODES, x, w);
    for (int i = 0; i < NODES * TURNS; i++) {
        direction(x[i / TURNS], 2.0 * AIR_PI * (i % TURNS) / TURNS, dir);
        air_sh_evaluate(ORDER, dir, y);
        for (int a = 0; a < COUNT; a++) {
            for (int b = 0; b < COUNT; b++) {
                gram[a][b] += w[i / TURNS] * 2.0 * AIR_PI / TURNS * y[a] * y[b];
            }
        }
    }
    for (int a = 0; a < COUNT; a++) {
        for (int b = 0; b < COUNT; b++) {
            assert_true(fabs(gram[a][b] - (a == b)) < 1e-13);
        }
    }
}

/* The sum over m of y_lm(a) y_lm(b) is (2l+1)/(4 pi) P_l(a.b). */
static void the_addition_theorem_holds(void **state)
{
    double a[3], b[3], y[COUNT], z[COUNT], p[ORDER];
    (void)state;
    for (int i = 0; i < 100; i++) {
        direction(cos(0.03 + 3.0 * i / 100.0), 0.7 * i, a);
        direction(cos(3.1 - 0.031 * i), 1.9 * i + 1.0, b);
        air_sh_evaluate(ORDER, a, y);
        air_sh_evaluate(ORDER, b, z);
        air_legendre(ORDER, a[0] * b[0] + a[1] * b[1] + a[2] * b[2], p);
        for (int l = 0; l < ORDER; l++) {
            double sum = 0.0;
            for (int m = -l; m <= l; m++) {
                sum += y[l * l + l + m] * z[l * l + l + m];
            }
            assert_true(fabs(sum - (2 * l + 1) / (4.0 * AIR_PI) * p[l]) < 1e-13);
        }
    }
}

/* The powers of P_10 sum to some 1100 in size, and each step of the recurrence rounds. */
static void powers_of_legendre_polynomials_sum_to_them(void **state)
{
    (void)state;
    for (int order = 1; order <= ORDER; order++) {
        double powers[ORDER * ORDER], p[ORDER];
        air_legendre_powers(order, powers);
        for (double x = -1.0; x <= 1.0; x += 0.125) {
            air_legendre(order, x, p);
            for (int l = 0; l < order; l++) {
                double sum = 0.0;
                for (int n = order - 1; n >= 0; n--) {
                    sum = sum * x + powers[l * order + n];
                }
                assert_true(fabs(sum - p[l]) < 1e-12);
            }
        }
    }
}

/* The published vector: y_lm at (2, 3, 6)/7. Positive coordinates give positive bands 0 and 1:
 * without Condon and Shortley's phase. By the formulae of harmonics.h with exact rationals. */
static void signs_and_order_are_the_published_ones(void **state)
{
    const double dir[3] = {2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0};
    const double k1 = sqrt(3.0 / (4.0 * AIR_PI)), k2 = sqrt(15.0 / (4.0 * AIR_PI));
    const double expected[9] = {sqrt(1.0 / (4.0 * AIR_PI)),
                                k1 * 3.0 / 7.0,
                                k1 * 6.0 / 7.0,
                                k1 * 2.0 / 7.0,
                                k2 * 6.0 / 49.0,
                                k2 * 18.0 / 49.0,
                                sqrt(5.0 / (16.0 * AIR_PI)) * (3.0 * 36.0 / 49.0 - 1.0),
                                k2 * 12.0 / 49.0,
                                0.5 * k2 * (4.0 - 9.0) / 49.0};
    const float dir_float[3] = {(float)dir[0], (float)dir[1], (float)dir[2]};
    double y[COUNT];
    float fast[9];
    (void)state;
    air_sh_evaluate(ORDER, dir, y);
    air_sh_evaluate_3(dir_float, fast);
    for (int i = 0; i < 9; i++) {
        assert_true(fabs(y[i] - expected[i]) < 1e-15);
        assert_true(fabs(fast[i] - expected[i]) < 2e-7); /* float has 6e-8 of numbers below 1 */
    }
    /* y_3,3 = sqrt(35/(32 pi)) x (x^2 - 3 y^2), y_3,-3 = sqrt(35/(32 pi)) y (3 x^2 - y^2) */
    assert_true(fabs(y[15] - sqrt(35.0 / (32.0 * AIR_PI)) * 2.0 * (4.0 - 27.0) / 343.0) < 1e-15);
    assert_true(fabs(y[9] - sqrt(35.0 / (32.0 * AIR_PI)) * 3.0 * (12.0 - 9.0) / 343.0) < 1e-15);
    for (int l = 0; l < 4; l++) {
        print_message("y_%d at (2, 3, 6)/7:", l);
        for (int m = -l; m <= l; m++) {
            print_message(" %.9f", y[l * l + l + m]);
        }
        print_message("\n");
    }
}

static void coefficients_know_their_band(void **state)
{
    (void)state;
    for (int l = 0; l < 3; l++) {
        for (int m = -l; m <= l; m++) {
            assert_int_equal(air_sh_band_3(l * l + l + m), l);
        }
    }
}

/* max(0, mu)^n y_l(mu) is a polynomial on [0, 1] for whole n. */
static void powers_of_the_cosine_are_their_integrals(void **state)
{
    double x[NODES], w[NODES], y[ORDER], found[ORDER];
    (void)state;
    air_gauss_legendre(NODES, x, w);
    for (int n = 0; n <= 13; n++) {
        double sum[ORDER] = {0.0};
        for (int i = 0; i < NODES; i++) {
            const double mu = 0.5 * (1.0 + x[i]);
            air_zh_evaluate(ORDER, mu, y);
            for (int l = 0; l < ORDER; l++) {
                sum[l] += AIR_PI * w[i] * pow(mu, n) * y[l];
            }
        }
        air_zh_cosine_power(ORDER, n, found);
        for (int l = 0; l < ORDER; l++) {
            assert_true(fabs(found[l] - sum[l]) < 1e-14);
        }
    }
    air_zh_clamped_cosine(ORDER, found);
    assert_true(fabs(found[0] - 0.5 * sqrt(AIR_PI)) < 1e-15);
    assert_true(fabs(found[1] - sqrt(AIR_PI / 3.0)) < 1e-15);
    for (int l = 3; l < ORDER; l += 2) {
        assert_true(found[l] == 0.0);
    }
}

/* Turned zonal functions have the values of the unturned, and their product's integral is the
 * product of coefficients. */
static void zonal_functions_turn_and_multiply(void **state)
{
    double g[ORDER], h[ORDER], g_sh[COUNT], h_sh[COUNT], y[COUNT], zonal[ORDER], a[3], b[3], w[3];
    (void)state;
    for (int l = 0; l < ORDER; l++) {
        g[l] = cos(1.3 * l + 0.2);
        h[l] = sin(0.9 * l + 0.4);
    }
    direction(0.3, 0.8, a);
    direction(-0.55, 2.9, b);
    direction(0.9, -1.4, w);
    air_zh_rotate(ORDER, g, a, g_sh);
    air_zh_rotate(ORDER, h, b, h_sh);
    air_sh_evaluate(ORDER, w, y);
    air_zh_evaluate(ORDER, a[0] * w[0] + a[1] * w[1] + a[2] * w[2], zonal);
    double value = 0.0, expected = 0.0, product = 0.0;
    for (int i = 0; i < COUNT; i++) {
        value += g_sh[i] * y[i];
        product += g_sh[i] * h_sh[i]; /* the integral, as the basis is orthonormal */
    }
    for (int l = 0; l < ORDER; l++) {
        expected += g[l] * zonal[l];
    }
    assert_true(fabs(value - expected) < 1e-13);
    const double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    assert_true(fabs(product - air_zh_product(ORDER, g, h, cosine)) < 1e-13);
}

static void poles_are_finite(void **state)
{
    const double poles[2][3] = {{0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}};
    double y[COUNT];
    (void)state;
    for (int i = 0; i < 2; i++) {
        air_sh_evaluate(ORDER, poles[i], y);
        for (int l = 0; l < ORDER; l++) {
            for (int m = -l; m <= l; m++) {
                const double zonal = sqrt((2 * l + 1) / (4.0 * AIR_PI)) * (i * l % 2 ? -1.0 : 1.0);
                assert_true(fabs(y[l * l + l + m] - (m == 0 ? zonal : 0.0)) < 1e-14);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(they_are_orthonormal),
        cmocka_unit_test(the_addition_theorem_holds),
        cmocka_unit_test(powers_of_legendre_polynomials_sum_to_them),
        cmocka_unit_test(signs_and_order_are_the_published_ones),
        cmocka_unit_test(coefficients_know_their_band),
        cmocka_unit_test(powers_of_the_cosine_are_their_integrals),
        cmocka_unit_test(zonal_functions_turn_and_multiply),
        cmocka_unit_test(poles_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
