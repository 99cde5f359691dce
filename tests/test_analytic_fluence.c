/* The closed forms of tests/analytic_fluence.h against published values and against themselves. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analytic_fluence.h"

static void assert_close(double value, double expected, double relative)
{
    if (!(fabs(value - expected) <= relative * fabs(expected)))
        fail_msg("%.15g instead of %.15g", value, expected);
}

/* Printed with ten decimals: half a unit of the last one is below 1e-9 of every value. */
static void bounces_have_the_published_values(void **state)
{
    (void)state;
    static const double published[10] = {0.4340201594, 0.3748869316, 0.2921008367, 0.2211006277,
                                         0.1679986578, 0.1299531010, 0.1028119366, 0.0831953467,
                                         0.0687277080, 0.0578178369};
    for (int k = 1; k <= 10; ++k)
        assert_close(fluence_of_bounce(k, 1.0, 0.0, 1.0), published[k - 1], 1e-9);
}

/* Printed with five digits. */
static void totals_without_absorption_have_the_published_values(void **state)
{
    (void)state;
    assert_close(fluence_of_all_bounces(1.0, 0.0, 0.1), 116.54, 5e-5);
    assert_close(fluence_of_all_bounces(1.0, 0.0, 1.0), 3.2800, 5e-5);
    assert_close(fluence_of_all_bounces(1.0, 0.0, 4.0), 0.75062, 1e-5);
}

static void unscattered_light_follows_beer_lambert_and_the_inverse_square(void **state)
{
    (void)state;
    for (double d = 0.05; d < 30.0; d *= 2.0)
        assert_close(fluence_of_bounce(0, 0.2, 0.1, d), exp(-0.3 * d) / (d * d), 1e-11);
}

/* albedo 0.1: what is left after 12 bounces is below 0.1^12 of the source, and the bounces that are
 * good to less than 1e-10 are weighted by less than 0.1^9. */
static void bounces_add_up_to_the_total(void **state)
{
    (void)state;
    for (double d = 0.3; d < 8.0; d *= 3.0) {
        double sum = 0.0;
        for (int k = 0; k <= 12; ++k)
            sum += fluence_of_bounce(k, 0.1, 0.9, d);
        assert_close(sum, fluence_of_all_bounces(0.1, 0.9, d), 1e-9);
    }
}

static void lengths_scale_with_the_mean_free_path(void **state)
{
    (void)state;
    for (int k = 0; k < 5; ++k)
        assert_close(fluence_of_bounce(k, 0.9, 0.3, 2.0) * 9.0,
                     fluence_of_bounce(k, 2.7, 0.9, 2.0 / 3.0), 1e-12);
}

/* All power ends up absorbed: Int sigma_a Phi 4 pi d^2 dd = 4 pi. Midpoint rule in d (d^2 Phi is
 * smooth: it tends to 1 at 0), error about h^2; the tail beyond 60 mean free paths is e^(-kappa 60)
 * < 1e-8 for albedo 0.8 (kappa = 0.71). */
static void everything_emitted_is_absorbed(void **state)
{
    (void)state;
    const double h = 0.02, sigma_a = 0.2;
    double absorbed = 0.0;
    for (double d = 0.5 * h; d < 60.0; d += h)
        absorbed += sigma_a * fluence_of_all_bounces(0.8, sigma_a, d) * d * d * h;
    assert_close(absorbed, 1.0, 4e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounces_have_the_published_values),
        cmocka_unit_test(totals_without_absorption_have_the_published_values),
        cmocka_unit_test(unscattered_light_follows_beer_lambert_and_the_inverse_square),
        cmocka_unit_test(bounces_add_up_to_the_total),
        cmocka_unit_test(lengths_scale_with_the_mean_free_path),
        cmocka_unit_test(everything_emitted_is_absorbed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
