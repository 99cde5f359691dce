/* Metrics on images whose errors can be computed by hand. */
#include "image_fixture.h"

static air_metrics compare(image_fixture *self, const air_image *a, const air_image *b,
                           const uint8_t *mask)
{
    air_metrics_params params;
    air_metrics_params_default(&params);
    params.mask = mask;
    air_metrics metrics;
    assert_int_equal(air_image_compare(self->context, a, b, &params, &metrics), AIR_OK);
    return metrics;
}

static bool near(double value, double expected)
{
    return fabs(value - expected) <= 1e-12 * fabs(expected);
}

static void a_constant_offset_gives_the_closed_forms(void **state)
{
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 12, 9);
    air_image *b = image_make_rgb(self, 12, 9);
    image_fill(a, 2.5f, 2.5f, 2.5f);
    image_fill(b, 2.0f, 2.0f, 2.0f);
    const air_metrics m = compare(self, a, b, NULL);
    assert_int_equal(m.pixel_count, 108);
    assert_true(near(m.mean_a, 2.5) && near(m.mean_b, 2.0) && near(m.bias, 0.25));
    assert_true(near(m.rmse, 0.5) && near(m.relative_rmse, 0.25));
    assert_true(near(m.rel_mse, 0.25 / (4.0 + 1e-4 * 4.0)));
    assert_true(near(m.psnr, 20.0 * log10(4.0)));
    air_image_destroy(b);
    air_image_destroy(a);
}

static void errors_of_unlike_pixels_combine_as_defined(void **state)
{
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 2, 1);
    air_image *b = image_make_rgb(self, 2, 1);
    image_fill(b, 0.0f, 1.0f, 3.0f);
    image_fill(a, 0.0f, 1.0f, 3.0f);
    air_image_plane(b, 2)[1] = 8.0f;
    air_image_plane(a, 2)[1] = 4.0f;
    air_image_plane(a, 0)[0] = 1.0f;
    /* Reference: 0 1 3, 0 1 8; errors 1 0 0, 0 0 -4. */
    const double mean_b = 13.0 / 6.0;
    const air_metrics m = compare(self, a, b, NULL);
    assert_true(near(m.mean_b, mean_b) && near(m.mean_a, 10.0 / 6.0));
    assert_true(near(m.bias, -3.0 / 13.0));
    assert_true(near(m.rmse, sqrt(17.0 / 6.0)));
    assert_true(near(m.relative_rmse, sqrt(17.0 / 6.0) / mean_b));
    const double floor_value = 1e-4 * mean_b * mean_b;
    assert_true(near(m.rel_mse, (1.0 / floor_value + 16.0 / (64.0 + floor_value)) / 6.0));
    assert_true(near(m.psnr, -10.0 * log10(17.0 / 6.0 / 64.0)));
    air_image_destroy(b);
    air_image_destroy(a);
}

static void equal_images_have_no_error(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 30, 20);
    for (size_t i = 0; i < 1800; i++) {
        air_image_plane(image, i / 600)[i % 600] = (float)(100.0 * image_fixture_random(self));
    }
    const air_metrics m = compare(self, image, image, NULL);
    assert_true(m.bias == 0.0 && m.rmse == 0.0 && m.relative_rmse == 0.0 && m.rel_mse == 0.0);
    assert_true(m.flip == 0.0 && m.hdr_flip == 0.0);
    assert_true(isinf(m.psnr) && m.psnr > 0.0);
    air_image_destroy(image);
}

static void black_references_give_zero_or_infinity_but_no_nan(void **state)
{
    image_fixture *self = *state;
    air_image *black = image_make_rgb(self, 4, 4);
    air_image *a = image_make_rgb(self, 4, 4);
    air_metrics m = compare(self, a, black, NULL);
    assert_true(m.bias == 0.0 && m.relative_rmse == 0.0 && m.rel_mse == 0.0 && m.flip == 0.0);
    image_fill(a, 1.0f, 1.0f, 1.0f);
    m = compare(self, a, black, NULL);
    assert_true(isinf(m.bias) && isinf(m.relative_rmse) && isinf(m.rel_mse) && isinf(m.psnr));
    assert_true(m.rmse == 1.0 && m.flip > 0.0 && m.hdr_flip > 0.0);
    air_image_destroy(a);
    air_image_destroy(black);
}

static void the_mask_selects_what_is_averaged(void **state)
{
    image_fixture *self = *state;
    uint8_t mask[64] = {0};
    air_image *a = image_make_rgb(self, 8, 8);
    air_image *b = image_make_rgb(self, 8, 8);
    image_fill(b, 1.0f, 1.0f, 1.0f);
    image_fill(a, 9.0f, 9.0f, 9.0f);
    for (size_t i = 5; i < 64; i += 7) {
        mask[i] = 255;
        for (size_t c = 0; c < 3; c++) {
            air_image_plane(a, c)[i] = 1.5f;
        }
    }
    const air_metrics m = compare(self, a, b, mask);
    assert_int_equal(m.pixel_count, 9);
    assert_true(near(m.rmse, 0.5) && near(m.mean_a, 1.5) && near(m.rel_mse, 0.25 / 1.0001));
    memset(mask, 0, sizeof(mask));
    air_metrics_params params;
    air_metrics_params_default(&params);
    params.mask = mask;
    air_metrics untouched = {.rmse = 7.0};
    assert_int_equal(air_image_compare(self->context, a, b, &params, &untouched),
                     AIR_ERROR_ARGUMENT);
    assert_true(untouched.rmse == 7.0);
    air_image_destroy(b);
    air_image_destroy(a);
}

static void ldr_flip_sees_the_picture_after_exposure_and_view(void **state)
{
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 16, 16);
    air_image *b = image_make_rgb(self, 16, 16);
    image_fill(a, 4.0f, 4.0f, 4.0f);
    image_fill(b, 2.0f, 2.0f, 2.0f);
    air_metrics_params params;
    air_metrics_params_default(&params);
    params.view = AIR_VIEW_STANDARD;
    params.auto_exposure = false;
    params.exposure_ev = -0.5f; /* both are white */
    air_metrics m;
    assert_int_equal(air_image_compare(self->context, a, b, &params, &m), AIR_OK);
    assert_true(m.flip == 0.0 && m.hdr_flip > 0.0 && m.rmse == 2.0);
    params.exposure_ev = -3.0f;
    assert_int_equal(air_image_compare(self->context, a, b, &params, &m), AIR_OK);
    assert_true(m.flip > 0.1);
    air_image *map = NULL;
    assert_int_equal(air_image_flip(self->context, a, b, &params, &map), AIR_OK);
    assert_string_equal(air_image_channel_name(map, 0), "Y");
    for (size_t i = 0; i < 256; i++) {
        /* An even picture has an even error; the sum over pixels rounds. */
        assert_true(fabs((double)air_image_plane(map, 0)[i] - m.flip) < 1e-6);
    }
    air_image_destroy(map);
    air_image_destroy(b);
    air_image_destroy(a);
}

static void pixels_that_are_not_finite_are_named(void **state)
{
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 6, 5);
    air_image *b = image_make_rgb(self, 6, 5);
    air_image_plane(a, 2)[4 * 6 + 1] = NAN;
    air_image_plane(a, 0)[3 * 6 + 2] = INFINITY;
    air_image_plane(a, 1)[3 * 6 + 2] = NAN;
    air_metrics_params params;
    air_metrics_params_default(&params);
    air_metrics m;
    air_image *map = NULL;
    assert_int_equal(air_image_compare(self->context, a, b, &params, &m), AIR_ERROR_FORMAT);
    assert_non_null(strstr(air_context_last_error(self->context), "image A has 2 pixels"));
    assert_non_null(strstr(air_context_last_error(self->context), "(2,3)"));
    assert_int_equal(air_image_flip(self->context, b, a, &params, &map), AIR_ERROR_FORMAT);
    assert_non_null(strstr(air_context_last_error(self->context), "image B"));
    assert_null(map);
    air_image_destroy(b);
    air_image_destroy(a);
}

static void unlike_images_and_odd_parameters_are_refused(void **state)
{
    static const char *const names[1] = {"depth"};
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 6, 5);
    air_image *wide = image_make_rgb(self, 7, 5);
    air_image *data = image_make(self, 6, 5, 1, names);
    air_metrics_params params;
    air_metrics_params_default(&params);
    air_metrics m;
    assert_int_equal(air_image_compare(self->context, a, wide, &params, &m), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(self->context), "6 x 5 and 7 x 5"));
    assert_int_equal(air_image_compare(self->context, a, data, &params, &m), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(self->context), "image B"));
    assert_int_equal(air_image_compare(self->context, data, a, &params, &m), AIR_ERROR_ARGUMENT);
    const float wrong[4] = {0.0f, 1e6f, NAN, -67.0f};
    for (size_t i = 0; i < 4; i++) {
        params.pixels_per_degree = wrong[i];
        assert_int_equal(air_image_compare(self->context, a, a, &params, &m), AIR_ERROR_ARGUMENT);
    }
    air_metrics_params_default(&params);
    params.auto_exposure = false;
    params.exposure_ev = INFINITY;
    assert_int_equal(air_image_compare(self->context, a, a, &params, &m), AIR_ERROR_ARGUMENT);
    air_image_destroy(data);
    air_image_destroy(wide);
    air_image_destroy(a);
}

#define WITH_FIXTURE(test)                                                                         \
    cmocka_unit_test_setup_teardown(test, image_fixture_start, image_fixture_finish)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FIXTURE(a_constant_offset_gives_the_closed_forms),
        WITH_FIXTURE(errors_of_unlike_pixels_combine_as_defined),
        WITH_FIXTURE(equal_images_have_no_error),
        WITH_FIXTURE(black_references_give_zero_or_infinity_but_no_nan),
        WITH_FIXTURE(the_mask_selects_what_is_averaged),
        WITH_FIXTURE(ldr_flip_sees_the_picture_after_exposure_and_view),
        WITH_FIXTURE(pixels_that_are_not_finite_are_named),
        WITH_FIXTURE(unlike_images_and_odd_parameters_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
