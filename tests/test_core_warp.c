/* Maps from the unit square. */
#include "core/warp.h"

#include "chi_square.h"
#include "cmocka_test.h"
#include "core/random.h"

enum { ROWS = 16, COLUMNS = 16, BINS = ROWS * COLUMNS, DRAWS = 200000 };

/* A right sampler fails at one seed in a thousand; the seeds are fixed. */
static const double least_p = 1e-3;

static int bin_of(double fraction, int count)
{
    const int bin = (int)(fraction * count);
    return bin < 0 ? 0 : bin < count ? bin : count - 1;
}

static int turn_of(air_vec3 v)
{
    const double turn = atan2((double)v.y, (double)v.x) / (2.0 * AIR_PI);
    return bin_of(turn < 0.0 ? turn + 1.0 : turn, COLUMNS);
}

static void disk_samples_are_uniform(void **state)
{
    (void)state;
    double observed[BINS] = {0}, expected[BINS];
    air_rng rng = air_rng_from_keys(1, 1);
    for (int i = 0; i < DRAWS; ++i) {
        const air_vec3 p = sample_disk_concentric(air_rng_float(&rng), air_rng_float(&rng));
        const double r2 = (double)p.x * (double)p.x + (double)p.y * (double)p.y;
        assert_true(r2 <= 1.0 + 1e-6 && p.z == 0.0f);
        observed[bin_of(r2, ROWS) * COLUMNS + turn_of(p)] += 1.0;
    }
    for (int i = 0; i < BINS; ++i) {
        /* Rings of equal r^2 have area pi / ROWS. */
        expected[i] = DRAWS * (double)sample_disk_concentric_pdf() * AIR_PI / BINS;
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > least_p);
    assert_true(vec3_is_zero(sample_disk_concentric(0.5f, 0.5f)));
}

static void hemisphere_samples_follow_the_cosine(void **state)
{
    (void)state;
    double observed[BINS] = {0}, expected[BINS];
    air_rng rng = air_rng_from_keys(2, 1);
    for (int i = 0; i < DRAWS; ++i) {
        const air_vec3 d = sample_cosine_hemisphere(air_rng_float(&rng), air_rng_float(&rng));
        assert_true(d.z >= 0.0f && fabsf(vec3_length(d) - 1.0f) < 1e-6f);
        observed[bin_of((double)d.z, ROWS) * COLUMNS + turn_of(d)] += 1.0;
    }
    for (int row = 0; row < ROWS; ++row) {
        for (int column = 0; column < COLUMNS; ++column) {
            /* The density is linear in cos: the value in the middle times the solid angle is exact.
             */
            const float middle = ((float)row + 0.5f) / ROWS;
            expected[row * COLUMNS + column] =
                DRAWS * (double)sample_cosine_hemisphere_pdf(middle) * 2.0 * AIR_PI / BINS;
        }
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > least_p);
    assert_true(sample_cosine_hemisphere_pdf(-0.5f) == 0.0f);
}

static void sphere_samples_are_uniform(void **state)
{
    (void)state;
    double observed[BINS] = {0}, expected[BINS];
    air_rng rng = air_rng_from_keys(3, 1);
    for (int i = 0; i < DRAWS; ++i) {
        const air_vec3 d = sample_sphere(air_rng_float(&rng), air_rng_float(&rng));
        assert_true(fabsf(vec3_length(d) - 1.0f) < 1e-6f);
        observed[bin_of(0.5 + 0.5 * (double)d.z, ROWS) * COLUMNS + turn_of(d)] += 1.0;
    }
    for (int i = 0; i < BINS; ++i) {
        expected[i] = DRAWS * (double)sample_sphere_pdf() * 4.0 * AIR_PI / BINS;
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > least_p);
}

static void triangle_samples_are_uniform(void **state)
{
    (void)state;
    double observed[BINS] = {0}, expected[BINS];
    air_rng rng = air_rng_from_keys(4, 1);
    for (int i = 0; i < DRAWS; ++i) {
        float b1 = -1.0f, b2 = -1.0f;
        sample_triangle(air_rng_float(&rng), air_rng_float(&rng), &b1, &b2);
        assert_true(b1 >= 0.0f && b2 >= 0.0f && b1 + b2 <= 1.0f);
        observed[bin_of((double)b1, ROWS) * COLUMNS + bin_of((double)b2, COLUMNS)] += 1.0;
    }
    for (int row = 0; row < ROWS; ++row) {
        for (int column = 0; column < COLUMNS; ++column) {
            /* Cells of the square: whole below the diagonal, halved on it. */
            const double part = row + column < ROWS - 1    ? 1.0
                                : row + column == ROWS - 1 ? 0.5
                                                           : 0.0;
            expected[row * COLUMNS + column] =
                DRAWS * (double)sample_triangle_pdf(0.5f) * part / BINS;
        }
    }
    assert_true(chi_square_p(observed, expected, BINS, NULL) > least_p);
}

static void cone_samples_are_uniform_however_narrow(void **state)
{
    (void)state;
    /* A whole sphere, a wide cone, the sun's disk, and one of 1e-5 rad. */
    const float openings[] = {2.0f, 0.5f, 1.08e-5f, 5e-11f};
    for (uint32_t k = 0; k < 4; ++k) {
        double observed[BINS] = {0}, expected[BINS];
        air_rng rng = air_rng_from_keys(5, k);
        for (int i = 0; i < DRAWS; ++i) {
            const air_vec3 d = sample_cone(air_rng_float(&rng), air_rng_float(&rng), openings[k]);
            assert_true(fabsf(vec3_length(d) - 1.0f) < 1e-6f);
            /* 1 - cos, from the sine where the cosine has lost it. */
            const double s2 = (double)d.x * (double)d.x + (double)d.y * (double)d.y;
            const double h =
                d.z < 0.5f ? 1.0 - (double)d.z : s2 / (1.0 + sqrt(fmax(0.0, 1.0 - s2)));
            observed[bin_of(h / (double)openings[k], ROWS) * COLUMNS + turn_of(d)] += 1.0;
        }
        for (int i = 0; i < BINS; ++i) {
            expected[i] = DRAWS * (double)sample_cone_pdf(openings[k]) * 2.0 * AIR_PI *
                          (double)openings[k] / BINS;
        }
        assert_true(chi_square_p(observed, expected, BINS, NULL) > least_p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(disk_samples_are_uniform),
        cmocka_unit_test(hemisphere_samples_follow_the_cosine),
        cmocka_unit_test(sphere_samples_are_uniform),
        cmocka_unit_test(triangle_samples_are_uniform),
        cmocka_unit_test(cone_samples_are_uniform_however_narrow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
