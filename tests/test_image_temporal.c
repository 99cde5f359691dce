/* The temporal metric on sequences whose changes can be computed by hand. */
#include "airlight/temporal.h"

#include "image_fixture.h"

static bool near(double value, double expected)
{
    return fabs(value - expected) <= 1e-12 * fabs(expected);
}

/* One pixel of grey at each frame. */
static void add_grey(image_fixture *self, air_temporal *temporal, float a, float b)
{
    air_image *image_a = image_make_rgb(self, 1, 1);
    air_image *image_b = image_make_rgb(self, 1, 1);
    image_fill(image_a, a, a, a);
    image_fill(image_b, b, b, b);
    assert_int_equal(air_temporal_add(temporal, image_a, image_b), AIR_OK);
    air_image_destroy(image_a);
    air_image_destroy(image_b);
}

static air_temporal *start(image_fixture *self)
{
    air_temporal *temporal = NULL;
    assert_int_equal(air_temporal_create(self->context, &temporal), AIR_OK);
    return temporal;
}

static air_temporal_metrics measure(const air_temporal *temporal, const uint8_t *mask)
{
    air_temporal_metrics metrics;
    assert_int_equal(air_temporal_measure(temporal, mask, &metrics), AIR_OK);
    return metrics;
}

static void variances_are_those_of_the_changes(void **state)
{
    image_fixture *self = *state;
    air_temporal *temporal = start(self);
    /* Changes of A: 2, -1, 2; of B: 1, 1, 4. Means 1 and 2, squares 1 + 4 + 1 and 1 + 1 + 4. */
    add_grey(self, temporal, 1.0f, 2.0f);
    add_grey(self, temporal, 3.0f, 3.0f);
    add_grey(self, temporal, 2.0f, 4.0f);
    add_grey(self, temporal, 4.0f, 8.0f);
    const air_temporal_metrics m = measure(temporal, NULL);
    assert_true(near(m.variance_a, 3.0) && near(m.variance_b, 3.0));
    assert_true(near(m.mean_b, 4.25));
    assert_true(near(m.ratio, 1.0) && near(m.ratio_of_means, 1.0));
    assert_true(near(m.difference, (1.0 + 2.0 + 2.0) / 3.0));
    assert_int_equal(m.frame_count, 4);
    assert_int_equal(m.pixel_count, 1);
    air_temporal_destroy(temporal);
}

static void steady_motion_and_constant_errors_do_not_flicker(void **state)
{
    image_fixture *self = *state;
    air_temporal *temporal = start(self);
    for (int t = 0; t < 5; t++) {
        add_grey(self, temporal, 0.5f * (float)t + 7.0f, 0.5f * (float)t);
    }
    const air_temporal_metrics m = measure(temporal, NULL);
    assert_true(m.variance_a == 0.0 && m.variance_b == 0.0 && m.difference == 0.0);
    assert_true(m.ratio == 1.0 && m.ratio_of_means == 0.0);
    air_temporal_destroy(temporal);
}

static void a_reference_that_stands_still_gives_a_finite_ratio_per_pixel(void **state)
{
    image_fixture *self = *state;
    air_temporal *temporal = start(self);
    /* Changes 1, -1: variance 2; f = 1e-6 of 4^2. */
    add_grey(self, temporal, 4.0f, 4.0f);
    add_grey(self, temporal, 5.0f, 4.0f);
    add_grey(self, temporal, 4.0f, 4.0f);
    const air_temporal_metrics m = measure(temporal, NULL);
    assert_true(near(m.ratio, (2.0 + 16e-6) / 16e-6));
    assert_true(isinf(m.ratio_of_means));
    air_temporal_destroy(temporal);
}

/* Two pixels: the first flickers, the second does in the reference too. */
static air_temporal *two_pixels(image_fixture *self)
{
    static const float a[3][2] = {{1, 1}, {2, 2}, {1, 1}}, b[3][2] = {{1, 1}, {1, 3}, {1, 1}};
    air_temporal *temporal = start(self);
    for (size_t t = 0; t < 3; t++) {
        air_image *image_a = image_make_rgb(self, 2, 1), *image_b = image_make_rgb(self, 2, 1);
        for (size_t k = 0; k < 3; k++) {
            memcpy(air_image_plane(image_a, k), a[t], sizeof a[t]);
            memcpy(air_image_plane(image_b, k), b[t], sizeof b[t]);
        }
        assert_int_equal(air_temporal_add(temporal, image_a, image_b), AIR_OK);
        air_image_destroy(image_a);
        air_image_destroy(image_b);
    }
    return temporal;
}

static void a_mask_selects_what_counts(void **state)
{
    image_fixture *self = *state;
    const uint8_t second[2] = {0, 1}, none[2] = {0, 0};
    air_temporal_metrics unused;
    air_temporal *temporal = two_pixels(self);
    const air_temporal_metrics all = measure(temporal, NULL), masked = measure(temporal, second);
    assert_true(near(all.variance_a, 2.0) && near(all.variance_b, 4.0));
    assert_true(near(masked.variance_a, 2.0) && near(masked.variance_b, 8.0));
    const double f = 1e-6 * (5.0 / 3.0) * (5.0 / 3.0);
    assert_true(near(masked.mean_b, 5.0 / 3.0) && near(masked.ratio, (2.0 + f) / (8.0 + f)));
    assert_true(near(all.difference, 1.0) && near(masked.difference, 1.0));
    assert_int_equal(masked.pixel_count, 1);
    assert_int_equal(air_temporal_measure(temporal, none, &unused), AIR_ERROR_ARGUMENT);
    air_temporal_destroy(temporal);
}

static void the_difference_as_an_image_has_the_metric_as_its_mean(void **state)
{
    image_fixture *self = *state;
    air_temporal *temporal = two_pixels(self);
    air_image *image = NULL;
    assert_int_equal(air_temporal_difference(temporal, &image), AIR_OK);
    assert_int_equal(air_image_width(image), 2);
    for (size_t k = 0; k < 3; k++) {
        assert_true(air_image_plane(image, k)[0] == 1.0f && air_image_plane(image, k)[1] == 1.0f);
    }
    air_image_destroy(image);
    air_temporal_destroy(temporal);
}

static void bad_frames_are_refused_and_do_not_count(void **state)
{
    image_fixture *self = *state;
    air_temporal *temporal = start(self);
    air_temporal_metrics metrics;
    air_image *difference = NULL, *wide = image_make_rgb(self, 2, 1);
    air_image *one = image_make_rgb(self, 1, 1), *nan = image_make_rgb(self, 1, 1);
    image_fill(nan, NAN, 0.0f, 0.0f);
    assert_int_equal(air_temporal_difference(temporal, &difference), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_temporal_add(temporal, one, wide), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_temporal_add(temporal, nan, one), AIR_ERROR_FORMAT);
    assert_int_equal(air_temporal_add(temporal, one, NULL), AIR_ERROR_ARGUMENT);
    for (int t = 0; t < 2; t++) {
        add_grey(self, temporal, 1.0f, 1.0f);
        assert_int_equal(air_temporal_add(temporal, wide, wide), AIR_ERROR_ARGUMENT);
        assert_int_equal(air_temporal_add(temporal, one, nan), AIR_ERROR_FORMAT);
    }
    assert_int_equal(air_temporal_measure(temporal, NULL, &metrics), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(self->context), "2 frames, expected at least 3"));
    add_grey(self, temporal, 1.0f, 1.0f);
    assert_int_equal(measure(temporal, NULL).frame_count, 3);
    assert_int_equal(air_temporal_create(self->context, NULL), AIR_ERROR_ARGUMENT);
    air_temporal_destroy(NULL);
    air_image_destroy(nan);
    air_image_destroy(one);
    air_image_destroy(wide);
    air_temporal_destroy(temporal);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(variances_are_those_of_the_changes),
        cmocka_unit_test(steady_motion_and_constant_errors_do_not_flicker),
        cmocka_unit_test(a_reference_that_stands_still_gives_a_finite_ratio_per_pixel),
        cmocka_unit_test(a_mask_selects_what_counts),
        cmocka_unit_test(the_difference_as_an_image_has_the_metric_as_its_mean),
        cmocka_unit_test(bad_frames_are_refused_and_do_not_count),
    };
    return cmocka_run_group_tests(tests, image_fixture_start, image_fixture_finish);
}
