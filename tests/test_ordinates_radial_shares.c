/* Closed forms of the lobes, held against quadrature and against each other. */
#include "ordinates/radial_shares.h"

#include "cmocka_test.h"
#include "core/quadrature.h"

enum { NODES = 200 };

/* Integral over [from, to] of 2 pi f_hg(mu) mu^power; a <= 0.9. */
static double moment(double a, double from, double to, int power)
{
    double x[NODES], w[NODES], sum = 0.0;
    air_gauss_legendre(NODES, x, w);
    for (int i = 0; i < NODES; i++) {
        const double mu = 0.5 * (from + to) + 0.5 * (to - from) * x[i];
        sum +=
            0.5 * (to - from) * w[i] * 2.0 * AIR_PI * radial_lobe(a, mu) * (power == 0 ? 1.0 : mu);
    }
    return sum;
}

static void shares_and_means_are_the_integrals(void **state)
{
    const double c = sqrt(0.5);
    (void)state;
    for (int i = -90; i <= 90; i++) {
        const double a = 0.01 * i;
        const radial_shares r = radial_shares_of(a);
        /* Gauss at 200 nodes, a <= 0.9: exact to rounding, which the peak, up to 190, amplifies. */
        const double tolerance = 1e-13;
        assert_true(fabs(r.front - moment(a, c, 1.0, 0)) < tolerance);
        assert_true(fabs(r.side - moment(a, -c, c, 0)) < tolerance);
        assert_true(fabs(r.back - moment(a, -1.0, -c, 0)) < tolerance);
        assert_true(fabs(r.front_mean - moment(a, c, 1.0, 1)) < tolerance);
        assert_true(fabs(r.side_mean - moment(a, -c, c, 1)) < tolerance);
        assert_true(fabs(r.back_mean - moment(a, -1.0, -c, 1)) < tolerance);
        assert_true(fabs(radial_path_fit(a) - r.path) < 2e-5);
    }
}

static void nothing_is_singular_and_all_sums_hold(void **state)
{
    static const double edges[] = {0.0, 1e-300, 1e-160, 1e-9, -1e-9, 0.999999999999, 1.0, -1.0};
    (void)state;
    for (size_t i = 0; i < sizeof edges / sizeof *edges; i++) {
        const radial_shares r = radial_shares_of(edges[i]);
        assert_true(fabs(r.front + r.side + r.back - 1.0) < 1e-15);
        assert_true(fabs(r.front_mean + r.side_mean + r.back_mean - edges[i]) < 1e-15);
        assert_true(r.front >= 0.0 && r.side >= 0.0 && r.back >= 0.0);
        assert_true(fabs(edges[i] * r.path - (r.front - r.back)) < 1e-15);
        assert_true(fabs(r.path - radial_path(edges[i])) < 1e-15);
        assert_true(fabs(radial_path_fit(edges[i]) - r.path) < 2e-5);
    }
    assert_true(fabs(radial_path(0.0) - 0.75) < 1e-15 && fabs(radial_path(1.0) - 1.0) < 1e-15);
    const radial_shares beam = radial_shares_of(1.0);
    assert_true(fabs(beam.front - 1.0) < 1e-15 && beam.side == 0.0);
}

static void shares_below_a_cosine_are_the_integral(void **state)
{
    (void)state;
    for (int i = -9; i <= 9; i++) {
        for (int j = -9; j <= 9; j++) {
            const double a = 0.1 * i, cosine = 0.1 * j;
            assert_true(fabs(radial_lobe_below(a, cosine) - moment(a, -1.0, cosine, 0)) < 1e-13);
        }
        assert_true(fabs(radial_lobe_below(0.1 * i, 1.0) - 1.0) < 1e-14);
    }
}

static void the_exponential_has_its_stated_error(void **state)
{
    double error = 0.0;
    (void)state;
    for (double x = 1e-8; x < 700.0; x *= 1.001) {
        error = double_max(error, fabs(radial_exp(x) / exp(-x) - 1.0));
    }
    assert_true(error < 3e-10);
    assert_true(radial_exp(0.0) == 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_and_means_are_the_integrals),
        cmocka_unit_test(nothing_is_singular_and_all_sums_hold),
        cmocka_unit_test(shares_below_a_cosine_are_the_integral),
        cmocka_unit_test(the_exponential_has_its_stated_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
