/* The chi-square helper of the other tests. */
#include "chi_square.h"

#include "cmocka_test.h"
#include "core/random.h"

static void gamma_q_matches_its_closed_forms(void **state)
{
    (void)state;
    for (double x = 0.01; x < 60.0; x *= 1.37) {
        /* Q(1/2, x) = erfc(sqrt x); Q(n, x) = exp(-x) sum_{k<n} x^k / k!  [DLMF, 7.11.2 and 8.4.10]
         */
        assert_true(fabs(gamma_q(0.5, x) / erfc(sqrt(x)) - 1.0) < 1e-11);
        double term = exp(-x), sum = term;
        for (int n = 1; n <= 40; ++n) {
            assert_true(fabs(gamma_q(n, x) / sum - 1.0) < 1e-11);
            term *= x / n;
            sum += term;
        }
    }
    assert_true(gamma_q(3.0, 0.0) == 1.0);
}

enum { BINS = 20, DRAWS = 2000, TRIALS = 2000 };

/* p-value of DRAWS draws into BINS equal bins, bin 0 being `bias` times as likely as the others. */
static double trial(air_rng *rng, double bias)
{
    double observed[BINS] = {0}, expected[BINS];
    const double share = bias / (bias + BINS - 1);
    for (int i = 0; i < BINS; ++i) {
        expected[i] = (double)DRAWS / BINS;
    }
    for (int i = 0; i < DRAWS; ++i) {
        const double u = air_rng_float(rng);
        const double rest = (u - share) / (1.0 - share);
        observed[u < share ? 0 : 1 + (int)(rest * (BINS - 1))] += 1.0;
    }
    size_t dof = 0;
    const double p = chi_square_p(observed, expected, BINS, &dof);
    assert_int_equal(dof, BINS - 1);
    return p;
}

static void p_values_of_the_right_distribution_are_uniform(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(1, 2);
    int below[4] = {0};
    for (int i = 0; i < TRIALS; ++i) {
        const double p = trial(&rng, 1.0);
        below[0] += p < 0.01;
        below[1] += p < 0.1;
        below[2] += p < 0.5;
        below[3] += p < 0.9;
    }
    const double level[4] = {0.01, 0.1, 0.5, 0.9};
    for (int i = 0; i < 4; ++i) {
        /* Four standard deviations of a binomial count. */
        const double deviation = sqrt(TRIALS * level[i] * (1.0 - level[i]));
        assert_true(fabs(below[i] - TRIALS * level[i]) < 4.0 * deviation);
    }
}

static void a_wrong_distribution_is_found(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(3, 4);
    /* A bin of 100 expected that gets 180 is 8 deviations off. */
    assert_true(trial(&rng, 1.8) < 1e-4);
    const double observed[2] = {1.0, 99.0}, nothing[2] = {0.0, 100.0};
    assert_true(chi_square_p(observed, nothing, 2, NULL) == 0.0);
}

static void small_bins_are_pooled(void **state)
{
    (void)state;
    const double expected[] = {1, 1, 1, 1, 1, 50, 4, 1, 50, 2};
    const double observed[] = {0, 3, 0, 2, 0, 50, 0, 5, 52, 0};
    size_t dof = 0;
    /* Pools of 5, 50, 5 and 50 + 2: all but nothing deviates. */
    assert_true(fabs(chi_square_p(observed, expected, 10, &dof) - 1.0) < 1e-12);
    assert_int_equal(dof, 3);
    assert_true(chi_square_p(observed, expected, 1, &dof) == 1.0);
    assert_int_equal(dof, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gamma_q_matches_its_closed_forms),
        cmocka_unit_test(p_values_of_the_right_distribution_are_uniform),
        cmocka_unit_test(a_wrong_distribution_is_found),
        cmocka_unit_test(small_bins_are_pooled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
