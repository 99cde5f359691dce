/* Tail probabilities, and whether the Z-test accepts what is unbiased and rejects what is not. */
#include "chi_square.h"
#include "image/probability.h"
#include "image_fixture.h"

/* ---- probabilities ---- */

static bool near(double value, double expected, double relative)
{
    return fabs(value - expected) <= relative * fabs(expected);
}

static void student_has_its_closed_forms(void **state)
{
    (void)state;
    for (double t = 1e-6; t < 1e6; t *= 1.7) {
        /* One degree of freedom (Cauchy), two, and four; far tails from the complementary forms. */
        const double one = atan2(1.0, t) * 2.0 / 3.14159265358979323846;
        const double root = sqrt(2.0 + t * t);
        const double two = 2.0 / (root * (root + t));
        const double s = t / sqrt(4.0 + t * t);
        assert_true(near(air_student_two_sided(t, 1.0), one, 1e-12));
        assert_true(near(air_student_two_sided(-t, 2.0), two, 1e-12));
        if (t < 10.0) { /* 1 - s (3 - s^2)/2 loses digits beyond */
            assert_true(near(air_student_two_sided(t, 4.0), 1.0 - s * (1.5 - 0.5 * s * s), 1e-11));
        }
    }
    assert_true(air_student_two_sided(0.0, 5.0) == 1.0);
    assert_true(air_student_two_sided(INFINITY, 5.0) == 0.0);
}

static void student_has_the_tabulated_quantiles(void **state)
{
    (void)state;
    /* [Abramowitz1964, table 26.10], given to three decimals: half a unit moves p by up to 0.5e-3
     * times the density, which relative to p is at most 0.0005 * 3. */
    const struct {
        double nu, t, p;
    } cases[] = {{15.0, 2.131, 0.05},  {15.0, 2.947, 0.01},  {15.0, 4.073, 0.001},
                 {30.0, 2.042, 0.05},  {30.0, 2.750, 0.01},  {120.0, 1.980, 0.05},
                 {120.0, 2.617, 0.01}, {3.0, 12.924, 0.001}, {7.0, 3.499, 0.01}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        assert_true(near(air_student_two_sided(cases[i].t, cases[i].nu), cases[i].p, 0.0015));
    }
}

static void student_approaches_the_normal_distribution(void **state)
{
    (void)state;
    for (double t = 0.0; t < 6.0; t += 0.25) {
        const double normal = erfc(t * sqrt(0.5));
        /* The first correction is of relative order (t^4 + t^2)/(4 nu) and less than 2 (t^4 +
         * t^2)/nu in all. */
        const double size = 2.0 * (pow(t, 4.0) + t * t);
        assert_true(near(air_student_two_sided(t, 1e6), normal, size / 1e6 + 1e-9));
        assert_true(near(air_student_two_sided(t, 9e9), normal, size / 9e9 + 1e-6));
        assert_true(air_student_two_sided(t, INFINITY) == normal);
    }
}

static void chi_square_has_its_closed_forms(void **state)
{
    (void)state;
    for (double x = 1e-3; x < 600.0; x *= 1.3) {
        assert_true(near(air_chi_square_upper(x, 1.0), erfc(sqrt(0.5 * x)), 1e-11));
        assert_true(near(air_chi_square_upper(x, 2.0), exp(-0.5 * x), 1e-12));
        assert_true(near(air_chi_square_upper(x, 4.0), exp(-0.5 * x) * (1.0 + 0.5 * x), 1e-11));
        assert_true(fabs(air_chi_square_upper(x, 100.0) - gamma_q(50.0, 0.5 * x)) < 1e-12);
    }
    assert_true(air_chi_square_upper(0.0, 3.0) == 1.0);
    /* Large n: Wilson and Hilferty's normal approximation, good to a few 1e-4 there. */
    const double n = 3e5;
    const double c = 2.0 / (9.0 * n);
    for (double z = -3.0; z <= 3.0; z += 0.5) {
        const double x = n * pow(1.0 - c + z * sqrt(c), 3.0);
        assert_true(fabs(air_chi_square_upper(x, n) - 0.5 * erfc(z * sqrt(0.5))) < 1e-4);
    }
}

static void normal_scores_invert_the_normal_tail(void **state)
{
    (void)state;
    for (double z = 1e-8; z < 37.0; z *= 1.1) {
        const double p = erfc(z * sqrt(0.5));
        /* p near 1 is known to 1e-16, which is that much over 0.8 in z. */
        assert_true(fabs(air_normal_two_sided_score(p) - z) <= 1e-12 * z + 2e-16);
    }
    assert_true(air_normal_two_sided_score(1.0) == 0.0);
    assert_true(air_normal_two_sided_score(0.0) > 37.0 && air_normal_two_sided_score(0.0) < 38.0);
}

static void sidak_is_the_chance_of_the_smallest_of_many(void **state)
{
    (void)state;
    assert_true(near(air_sidak(0.1, 2.0), 0.19, 1e-12));
    assert_true(near(air_sidak(1e-20, 1e6), 1e-14, 1e-6));
    assert_true(air_sidak(1.0, 5.0) == 1.0 && air_sidak(0.0, 5.0) == 0.0);
}

/* ---- images ---- */

enum { SIDE = 32, REPLICATES = 16 };

/* Two independent normal numbers [Box1958]. */
static void normal_pair(image_fixture *self, double out[2])
{
    const double radius = sqrt(-2.0 * log(1.0 - image_fixture_random(self)));
    const double angle = 2.0 * 3.14159265358979323846 * image_fixture_random(self);
    out[0] = radius * cos(angle);
    out[1] = radius * sin(angle);
}

/* Means of replicates with deviation sigma of the mean, and the estimated variances of these means.
 */
static void simulate(image_fixture *self, double mean, double sigma, air_image *image,
                     air_image *variance)
{
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        double sum = 0.0;
        double squares = 0.0;
        for (size_t r = 0; r < REPLICATES; r += 2) {
            double pair[2];
            normal_pair(self, pair);
            for (size_t k = 0; k < 2; k++) {
                const double value = sigma * sqrt((double)REPLICATES) * pair[k];
                sum += value;
                squares += value * value;
            }
        }
        const double average = sum / REPLICATES;
        air_image_plane(image, 0)[i] = (float)(mean + average);
        air_image_plane(variance, 0)[i] =
            (float)((squares - sum * average) / (REPLICATES * (REPLICATES - 1)));
    }
}

typedef struct trials {
    double mean_rejected, sidak_rejected, chi_square_rejected; /* shares at level 1 % */
    double beyond_95;
} trials;

enum { TRIALS = 200 };

static trials run_trials(image_fixture *self, double mean, double sigma, size_t block, bool both)
{
    static const char *const grey[1] = {"Y"};
    air_image *a = image_make(self, SIDE, SIDE, 1, grey);
    air_image *b = image_make(self, SIDE, SIDE, 1, grey);
    air_image *variance_a = image_make(self, SIDE, SIDE, 1, grey);
    air_image *variance_b = image_make(self, SIDE, SIDE, 1, grey);
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        air_image_plane(b, 0)[i] = 1.0f;
    }
    trials result = {0};
    for (int t = 0; t < TRIALS; t++) {
        air_ztest test;
        simulate(self, mean, sigma, a, variance_a);
        if (both) {
            simulate(self, 1.0, 0.5 * sigma, b, variance_b);
        }
        assert_int_equal(air_image_ztest(self->context, a, b, variance_a, both ? variance_b : NULL,
                                         block, REPLICATES - 1, &test),
                         AIR_OK);
        result.mean_rejected += (test.mean_p < 0.01) / (double)TRIALS;
        result.sidak_rejected += (test.sidak_p < 0.01) / (double)TRIALS;
        result.chi_square_rejected += (test.chi_square_p < 0.01) / (double)TRIALS;
        result.beyond_95 += test.fraction_beyond_95 / (double)TRIALS;
    }
    air_image_destroy(variance_b);
    air_image_destroy(variance_a);
    air_image_destroy(b);
    air_image_destroy(a);
    return result;
}

/* Four standard errors above a share p of so many trials. */
static double above(double p) { return p + 4.0 * sqrt(p * (1.0 - p) / TRIALS); }
static double below(double p) { return p - 4.0 * sqrt(p * (1.0 - p) / TRIALS); }

static void unbiased_noise_is_accepted_at_the_stated_level(void **state)
{
    /* With 15 degrees of freedom per pixel the tests of single pixels are exact. */
    const trials exact = run_trials(*state, 1.0, 0.08, 1, false);
    assert_true(exact.mean_rejected <= above(0.01));
    assert_true(exact.sidak_rejected <= above(0.01));
    assert_true(exact.chi_square_rejected <= above(0.01));
    /* 5 % of TRIALS * 1024 independent pixels; four standard errors. */
    assert_true(fabs(exact.beyond_95 - 0.05) < 4.0 * sqrt(0.05 * 0.95 / (TRIALS * SIDE * SIDE)));
}

static void unbiased_noise_in_both_images_and_blocks_is_accepted(void **state)
{
    /* Welch's degrees of freedom are an approximation: the share beyond 95 % may be off by a tenth
     * of itself. */
    const trials blocks = run_trials(*state, 1.0, 0.08, 4, true);
    assert_true(blocks.mean_rejected <= above(0.01));
    assert_true(blocks.sidak_rejected <= above(0.015));
    assert_true(blocks.chi_square_rejected <= above(0.015));
    assert_true(fabs(blocks.beyond_95 - 0.05) <
                0.005 + 4.0 * sqrt(0.05 * 0.95 / (TRIALS * SIDE * SIDE / 16)));
}

static void a_bias_of_one_percent_is_rejected_at_the_stated_power(void **state)
{
    /* The mean of N = 1024 pixels with deviation 0.08 each has a standard error of 0.0025, so a
     * bias of 0.01 shifts z by 4. Level 1 % with a Sidak correction over three (here equal)
     * channels means |z| > 2.935: the power is Phi(4 - 2.935) = 0.857. The degrees of freedom,
     * about 15 * 1024 / (1 + 2/15), change the quantile by 0.001. */
    const trials biased = run_trials(*state, 1.01, 0.08, 1, false);
    assert_true(biased.mean_rejected > below(0.857) && biased.mean_rejected < above(0.857));
    /* The squares of 1024 pixel scores, shifted by 1/8 each, sum to 1040 with a deviation of 46;
     * the 99.67 % point is 1152: power below 4 %. */
    assert_true(biased.chi_square_rejected < above(0.04));
}

static void blocks_find_a_bias_that_pixels_hide(void **state)
{
    /* Blocks of 16 x 16 have a deviation of 0.08/16 = 0.005: four scores shifted by 2, whose
     * squares sum to 20 on average with a deviation of sqrt(2 (4 + 2 * 16)) = 8.5, against
     * the 99.67 % point of chi-square with 4, 15.8: power about Phi((20 - 15.8)/8.5) = 0.69, give
     * or take 0.05 for the normal approximation. */
    const trials blocks = run_trials(*state, 1.01, 0.08, 16, false);
    assert_true(blocks.chi_square_rejected > below(0.69) - 0.05);
}

static void single_outliers_move_the_smallest_p(void **state)
{
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, SIDE, SIDE);
    air_image *b = image_make_rgb(self, SIDE, SIDE);
    air_image *variance = image_make_rgb(self, SIDE, SIDE);
    image_fill(variance, 0.01f, 0.01f, 0.01f);
    air_image_plane(a, 1)[77] = 1.5f; /* t = 15 */
    air_ztest test;
    assert_int_equal(air_image_ztest(self->context, a, b, variance, NULL, 1, 15, &test), AIR_OK);
    assert_int_equal(test.test_count, 3 * SIDE * SIDE);
    assert_true(near(test.min_p, air_student_two_sided(15.0, 15.0), 1e-5)); /* 0.01f, 1.5f */
    assert_true(near(test.sidak_p, air_sidak(test.min_p, 3.0 * SIDE * SIDE), 1e-12));
    assert_true(near(test.mean_z, 1.5 / sqrt(0.01 * SIDE * SIDE), 1e-6));
    assert_true(near(test.fraction_beyond_95, 1.0 / (3.0 * SIDE * SIDE), 1e-12));
    air_image_destroy(variance);
    air_image_destroy(b);
    air_image_destroy(a);
}

static void the_variance_layer_of_an_image_is_preferred(void **state)
{
    static const char *const names[6] = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
    image_fixture *self = *state;
    air_image *a = image_make(self, 2, 2, 6, names);
    air_image *b = image_make_rgb(self, 2, 2);
    for (size_t c = 0; c < 6; c++) {
        for (size_t i = 0; i < 4; i++) {
            air_image_plane(a, c)[i] = c < 3 ? 1.0f : 0.25f;
        }
    }
    air_ztest test;
    assert_int_equal(air_image_ztest(self->context, a, b, a, NULL, 1, 7, &test), AIR_OK);
    assert_true(near(test.min_p, air_student_two_sided(2.0, 7.0), 1e-12));
    air_image_destroy(b);
    air_image_destroy(a);
}

static void pixels_without_variance_are_counted_not_tested(void **state)
{
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 4, 4);
    air_image *b = image_make_rgb(self, 4, 4);
    air_image *variance = image_make_rgb(self, 4, 4);
    image_fill(a, 1.0f, 1.0f, 1.0f);
    image_fill(b, 1.0f, 1.0f, 1.00001f); /* rounding */
    air_image_plane(b, 0)[3] = 0.0f;
    air_ztest test;
    assert_int_equal(air_image_ztest(self->context, a, b, variance, NULL, 1, 15, &test), AIR_OK);
    assert_int_equal(test.test_count, 0);
    assert_int_equal(test.differing_without_variance, 1);
    assert_true(test.min_p == 1.0 && test.sidak_p == 1.0 && test.mean_p == 1.0 &&
                test.chi_square_p == 1.0 && test.mean_z == 0.0 && test.fraction_beyond_95 == 0.0);
    air_image_destroy(variance);
    air_image_destroy(b);
    air_image_destroy(a);
}

static void incomplete_or_impossible_input_is_refused(void **state)
{
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 4, 4);
    air_image *wide = image_make_rgb(self, 5, 4);
    air_image *variance = image_make_rgb(self, 4, 4);
    air_ztest test;
    assert_int_equal(air_image_ztest(self->context, a, a, NULL, NULL, 1, 15, &test),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_image_ztest(self->context, a, a, variance, NULL, 0, 15, &test),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_image_ztest(self->context, a, a, variance, NULL, 1, 0, &test),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_image_ztest(self->context, a, wide, variance, NULL, 1, 15, &test),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_image_ztest(self->context, a, a, NULL, wide, 1, 15, &test),
                     AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(self->context), "variance of B"));
    air_image_plane(variance, 1)[9] = -1e-9f;
    assert_int_equal(air_image_ztest(self->context, a, a, variance, NULL, 1, 15, &test),
                     AIR_ERROR_FORMAT);
    assert_non_null(strstr(air_context_last_error(self->context), "(1,2)"));
    air_image_plane(variance, 1)[9] = NAN;
    assert_int_equal(air_image_ztest(self->context, a, a, variance, NULL, 1, 15, &test),
                     AIR_ERROR_FORMAT);
    air_image_destroy(variance);
    air_image_destroy(wide);
    air_image_destroy(a);
}

#define WITH_FIXTURE(test)                                                                         \
    cmocka_unit_test_setup_teardown(test, image_fixture_start, image_fixture_finish)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(student_has_its_closed_forms),
        cmocka_unit_test(student_has_the_tabulated_quantiles),
        cmocka_unit_test(student_approaches_the_normal_distribution),
        cmocka_unit_test(chi_square_has_its_closed_forms),
        cmocka_unit_test(normal_scores_invert_the_normal_tail),
        cmocka_unit_test(sidak_is_the_chance_of_the_smallest_of_many),
        WITH_FIXTURE(unbiased_noise_is_accepted_at_the_stated_level),
        WITH_FIXTURE(unbiased_noise_in_both_images_and_blocks_is_accepted),
        WITH_FIXTURE(a_bias_of_one_percent_is_rejected_at_the_stated_power),
        WITH_FIXTURE(blocks_find_a_bias_that_pixels_hide),
        WITH_FIXTURE(single_outliers_move_the_smallest_p),
        WITH_FIXTURE(the_variance_layer_of_an_image_is_preferred),
        WITH_FIXTURE(pixels_without_variance_are_counted_not_tested),
        WITH_FIXTURE(incomplete_or_impossible_input_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
