/* View transforms, automatic exposure, differences and false colours. */
#include "image_fixture.h"

static void apply(air_view view, float ev, float r, float g, float b, float out[3])
{
    const float rgb[3] = {r, g, b};
    air_view_apply(view, ev, rgb, out);
}

/* Rounding of a handful of float operations on values up to 2. */
static const float rounding = 1e-6f;

/* ---- Khronos PBR Neutral ---- */

static void neutral_only_takes_the_fresnel_offset_away_below_its_shoulder(void **state)
{
    image_fixture *self = *state;
    for (size_t i = 0; i < 1000; i++) {
        float rgb[3];
        float out[3];
        for (size_t c = 0; c < 3; c++) {
            rgb[c] = (float)(0.08 + 0.719 * image_fixture_random(self));
        }
        air_view_apply(AIR_VIEW_NEUTRAL, 0.0f, rgb, out);
        for (size_t c = 0; c < 3; c++) {
            assert_true(fabsf(out[c] - (rgb[c] - 0.04f)) <= rounding);
        }
    }
}

static void neutral_keeps_saturated_dark_colours_saturated(void **state)
{
    (void)state;
    float out[3];
    apply(AIR_VIEW_NEUTRAL, 0.0f, 0.5f, 0.04f, 0.0f, out);
    assert_true(out[0] == 0.5f && out[1] == 0.04f && out[2] == 0.0f);
    /* Smallest component x < 0.08: x - 6.25 x^2 is taken away. */
    apply(AIR_VIEW_NEUTRAL, 0.0f, 0.5f, 0.3f, 0.04f, out);
    assert_true(fabsf(out[0] - 0.47f) <= rounding && fabsf(out[1] - 0.27f) <= rounding &&
                fabsf(out[2] - 0.01f) <= rounding);
}

static void neutral_compresses_as_its_specification_computes(void **state)
{
    (void)state;
    float out[3];
    /* Grey 1: peak 0.96, 1 - 0.24^2 / (0.96 + 0.24 - 0.76). */
    apply(AIR_VIEW_NEUTRAL, 0.0f, 1.0f, 1.0f, 1.0f, out);
    for (size_t c = 0; c < 3; c++) {
        assert_true(fabsf(out[c] - 0.86909091f) <= rounding);
    }
    /* (1.96, 0.46, 0.06) after the offset: new peak 1 - 0.0576/1.44 = 0.96, grey share 1 - 1/1.15.
     */
    apply(AIR_VIEW_NEUTRAL, 0.0f, 2.0f, 0.5f, 0.1f, out);
    assert_true(fabsf(out[0] - 0.96f) <= rounding);
    assert_true(fabsf(out[1] - (0.46f * 0.96f / 1.96f + 0.15f * 0.96f) / 1.15f) <= rounding);
    assert_true(fabsf(out[2] - (0.06f * 0.96f / 1.96f + 0.15f * 0.96f) / 1.15f) <= rounding);
}

static void neutral_is_monotone_and_continuous_on_greys_and_stays_below_one(void **state)
{
    (void)state;
    float last = 0.0f;
    for (int i = 0; i <= 40000; i++) {
        const float grey = (float)i * 1e-4f;
        float out[3];
        apply(AIR_VIEW_NEUTRAL, 0.0f, grey, grey, grey, out);
        assert_true(out[0] == out[1] && out[1] == out[2]);
        /* Its slope never exceeds 1 (12.5 x below 0.08, then 1, then less). */
        assert_true(out[0] >= last && out[0] - last <= 1e-4f + rounding);
        assert_true(out[0] < 1.0f);
        last = out[0];
    }
}

static void every_view_maps_anything_into_the_unit_cube(void **state)
{
    image_fixture *self = *state;
    const float strange[8] = {NAN, INFINITY, -INFINITY, 3.4e38f, -3.4e38f, 1e-45f, 0.0f, 1.0f};
    const air_view views[3] = {AIR_VIEW_NEUTRAL, AIR_VIEW_STANDARD, AIR_VIEW_RAW};
    for (size_t i = 0; i < 3000; i++) {
        float rgb[3];
        for (size_t c = 0; c < 3; c++) {
            rgb[c] = strange[(size_t)(8.0 * image_fixture_random(self))];
        }
        air_view_apply(views[i % 3], (float)(100.0 * image_fixture_random(self) - 50.0), rgb, rgb);
        for (size_t c = 0; c < 3; c++) {
            assert_true(rgb[c] >= 0.0f && rgb[c] <= 1.0f);
        }
    }
}

static void exposure_is_a_factor_of_two_per_stop_except_in_raw(void **state)
{
    (void)state;
    for (int view = AIR_VIEW_NEUTRAL; view <= AIR_VIEW_RAW; view++) {
        float exposed[3];
        float scaled[3];
        const float f = view == AIR_VIEW_RAW ? 1.0f : 0.125f;
        apply((air_view)view, -3.0f, 0.9f, 0.5f, 0.2f, exposed);
        apply((air_view)view, 0.0f, 0.9f * f, 0.5f * f, 0.2f * f, scaled);
        assert_memory_equal(exposed, scaled, sizeof(exposed));
    }
}

static void standard_clips(void **state)
{
    (void)state;
    float out[3];
    apply(AIR_VIEW_STANDARD, 0.0f, 1.5f, 0.25f, -1.0f, out);
    assert_true(out[0] == 1.0f && out[1] == 0.25f && out[2] == 0.0f);
}

/* ---- automatic exposure ---- */

static void auto_exposure_brings_an_even_picture_to_middle_grey(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 20, 20);
    for (int stops = -30; stops <= 30; stops += 5) {
        const float level = exp2f((float)stops);
        image_fill(image, level, level, level);
        /* The luminance weights sum to 1 in double; float's half unit at 32 stops is 2e-6. */
        assert_true(fabs((double)air_image_auto_exposure(image) - (log2(0.18) - stops)) < 4e-6);
    }
    air_image_destroy(image);
}

static void auto_exposure_averages_logarithms(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 10, 10);
    image_fill(image, 1.0f, 1.0f, 1.0f);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < 50; i++) {
            air_image_plane(image, c)[i] = 16.0f;
        }
    }
    /* As much of each is cut off as of the other: the average of 1 and 16 is 4. */
    assert_true(fabs((double)air_image_auto_exposure(image) - log2(0.18 / 4.0)) < 1e-6);
    air_image_destroy(image);
}

static void auto_exposure_ignores_suns_and_holes(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 100, 100);
    image_fill(image, 0.5f, 0.5f, 0.5f);
    const float before = air_image_auto_exposure(image);
    for (size_t c = 0; c < 3; c++) {
        float *const plane = air_image_plane(image, c);
        for (size_t i = 0; i < 400; i++) { /* 4 %, of the 5 % that each tail may have */
            plane[i] = 68300.0f / 6.8e-5f; /* the sun's disc under full daylight */
            plane[1000 + i] = 1e-12f;
        }
        plane[5000] = 0.0f; /* black and what is no number are no light to adapt to */
        plane[5001] = NAN;
        plane[5002] = INFINITY;
        plane[5003] = -5.0f;
    }
    assert_true(fabsf(air_image_auto_exposure(image) - before) < 1e-6f);
    air_image_destroy(image);
}

static void auto_exposure_of_black_or_colourless_images_is_zero(void **state)
{
    static const char *const depth[1] = {"depth"};
    image_fixture *self = *state;
    air_image *black = image_make_rgb(self, 4, 4);
    air_image *data = image_make(self, 4, 4, 1, depth);
    air_image_plane(data, 0)[0] = 7.0f;
    assert_true(air_image_auto_exposure(black) == 0.0f);
    assert_true(air_image_auto_exposure(data) == 0.0f);
    air_image_destroy(data);
    air_image_destroy(black);
}

/* ---- differences and false colour ---- */

static void differences_are_absolute(void **state)
{
    static const char *const grey[1] = {"Y"};
    image_fixture *self = *state;
    air_image *a = image_make_rgb(self, 2, 2);
    air_image *b = image_make(self, 2, 2, 1, grey);
    image_fill(a, 1.0f, 2.0f, 4.0f);
    for (size_t i = 0; i < 4; i++) {
        air_image_plane(b, 0)[i] = 2.5f;
    }
    air_image *difference = NULL;
    assert_int_equal(air_image_difference(self->context, a, b, &difference), AIR_OK);
    assert_true(air_image_plane(difference, 0)[3] == 1.5f &&
                air_image_plane(difference, 1)[3] == 0.5f &&
                air_image_plane(difference, 2)[3] == 1.5f);
    air_image_destroy(difference);
    air_image *other = image_make_rgb(self, 2, 3);
    assert_int_equal(air_image_difference(self->context, a, other, &difference),
                     AIR_ERROR_ARGUMENT);
    assert_null(difference);
    air_image_destroy(other);
    air_image_destroy(b);
    air_image_destroy(a);
}

/* Linear Rec. 709 to Oklab [Ottosson2020], the inverse of what the map is made with. */
static void oklab(const double rgb[3], double lab[3])
{
    const double l = cbrt(0.4122214708 * rgb[0] + 0.5363325363 * rgb[1] + 0.0514459929 * rgb[2]);
    const double m = cbrt(0.2119034982 * rgb[0] + 0.6806995451 * rgb[1] + 0.1073969566 * rgb[2]);
    const double s = cbrt(0.0883024619 * rgb[0] + 0.2817188376 * rgb[1] + 0.6299787005 * rgb[2]);
    lab[0] = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
    lab[1] = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    lab[2] = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
}

static void false_colours_rise_evenly_within_the_gamut(void **state)
{
    enum { STEPS = 100 };
    static const char *const grey[1] = {"anything"};
    image_fixture *self = *state;
    air_image *ramp = image_make(self, STEPS + 1, 1, 1, grey);
    for (size_t i = 0; i <= STEPS; i++) {
        air_image_plane(ramp, 0)[i] = 5.0f * (float)i / STEPS;
    }
    air_image *colours = NULL;
    assert_int_equal(air_image_false_colour(self->context, ramp, 5.0f, &colours), AIR_OK);
    double last[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i <= STEPS; i++) {
        double rgb[3];
        double lab[3];
        for (size_t c = 0; c < 3; c++) {
            rgb[c] = (double)air_image_plane(colours, c)[i];
            assert_true(rgb[c] > 0.0 && rgb[c] < 1.0); /* nothing was clipped */
        }
        oklab(rgb, lab);
        if (i > 0) {
            const double step =
                STEPS * sqrt(pow(lab[0] - last[0], 2.0) + pow(lab[1] - last[1], 2.0) +
                             pow(lab[2] - last[2], 2.0));
            /* Designed length 0.95 to 1.00; a lightness step of 0.80. */
            assert_true(step > 0.94 && step < 1.01);
            assert_true(fabs(STEPS * (lab[0] - last[0]) - 0.80) < 1e-3);
        }
        memcpy(last, lab, sizeof(last));
    }
    air_image_destroy(colours);
    air_image_destroy(ramp);
}

static void false_colours_clip_at_the_scale_and_mark_what_is_not_finite(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 4, 1);
    image_fill(image, 2.0f, -2.0f, 2.0f); /* magnitudes */
    air_image_plane(image, 0)[1] = 1e30f;
    air_image_plane(image, 1)[2] = NAN;
    air_image_plane(image, 2)[3] = INFINITY;
    air_image *colours = NULL;
    assert_int_equal(air_image_false_colour(self->context, image, 2.0f, &colours), AIR_OK);
    for (size_t c = 0; c < 3; c++) {
        const float *const plane = air_image_plane(colours, c);
        assert_true(plane[0] == plane[1]);
        assert_true(plane[2] == (c == 0 ? 0.0f : 1.0f) && plane[3] == plane[2]);
    }
    air_image_destroy(colours);
    const float scales[4] = {0.0f, -1.0f, NAN, INFINITY};
    for (size_t i = 0; i < 4; i++) {
        assert_int_equal(air_image_false_colour(self->context, image, scales[i], &colours),
                         AIR_ERROR_ARGUMENT);
        assert_null(colours);
    }
    air_image_destroy(image);
}

#define WITH_FIXTURE(test)                                                                         \
    cmocka_unit_test_setup_teardown(test, image_fixture_start, image_fixture_finish)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FIXTURE(neutral_only_takes_the_fresnel_offset_away_below_its_shoulder),
        cmocka_unit_test(neutral_keeps_saturated_dark_colours_saturated),
        cmocka_unit_test(neutral_compresses_as_its_specification_computes),
        cmocka_unit_test(neutral_is_monotone_and_continuous_on_greys_and_stays_below_one),
        WITH_FIXTURE(every_view_maps_anything_into_the_unit_cube),
        cmocka_unit_test(exposure_is_a_factor_of_two_per_stop_except_in_raw),
        cmocka_unit_test(standard_clips),
        WITH_FIXTURE(auto_exposure_brings_an_even_picture_to_middle_grey),
        WITH_FIXTURE(auto_exposure_averages_logarithms),
        WITH_FIXTURE(auto_exposure_ignores_suns_and_holes),
        WITH_FIXTURE(auto_exposure_of_black_or_colourless_images_is_zero),
        WITH_FIXTURE(differences_are_absolute),
        WITH_FIXTURE(false_colours_rise_evenly_within_the_gamut),
        WITH_FIXTURE(false_colours_clip_at_the_scale_and_mark_what_is_not_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
