/* Skies at the edges of what they may be, and beyond. */
#include <math.h>
#include <string.h>

#include "cmocka_test.h"
#include "environment_fixture.h"
#include "failing_allocator.h"

/* ---- edges ---- */

static void black_maps_give_dark_even_ordinates(void **state)
{
    static float pixels[3 * 8 * 4];
    static air_ordinate ordinates[64];
    double mean = 0.0;
    const air_environment_map map = map_of(pixels, 8, 4);
    air_environment_ordinates *sky = prepare(*state, &map);
    choose(*state, sky, 64, NULL, ordinates);
    for (size_t n = 0; n < 64; n++) {
        assert_true(ordinates[n].irradiance[0] == 0.0 && ordinates[n].irradiance[2] == 0.0);
        mean += ordinates[n].lobe / 64.0;
    }
    assert_true(1.0 - mean < 1.4 / 64.0); /* as for an even sky */
    air_environment_ordinates_destroy(sky);
}

static void importance_without_light_is_left_out(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    float importance[AIR_IMPORTANCE_TEXELS] = {0};
    static air_ordinate a[16], b[16];
    paint(pixels, WIDTH, HEIGHT, 40);
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    air_environment_ordinates *sky = prepare(*state, &map);
    choose(*state, sky, 16, importance, a);
    choose(*state, sky, 16, NULL, b);
    assert_memory_equal(a, b, sizeof a);
    air_environment_ordinates_destroy(sky);
}

static void one_pixel_is_an_even_sky(void **state)
{
    const float pixel[3] = {1.0f, 2.0f, 3.0f};
    static air_ordinate a[64], b[64];
    air_environment_map map = map_of(pixel, 1, 1);
    air_environment_ordinates *sky = prepare(*state, &map);
    choose(*state, sky, 64, NULL, a);
    air_environment_ordinates_destroy(sky);
    air_environment_map_default(&map);
    memcpy(map.radiance, pixel, sizeof pixel);
    sky = prepare(*state, &map);
    choose(*state, sky, 64, NULL, b);
    assert_memory_equal(a, b, sizeof a);
    choose(*state, sky, 1, NULL, a); /* the whole of it has no direction */
    assert_true(a[0].lobe == 0.0 && a[0].travel[1] == -1.0);
    assert_true(fabs(a[0].irradiance[2] - 12.0 * AIR_PI) < 1e-9);
    air_environment_ordinates_destroy(sky);
}

static void strides_skip(void **state)
{
    static float tight[3 * 8 * 4], loose[5 * 8 * 4 + 4 * 7];
    static air_ordinate a[16], b[16];
    paint(tight, 8, 4, 3);
    for (size_t y = 0; y < 4; y++) {
        for (size_t x = 0; x < 8; x++) {
            float *p = loose + y * (5 * 8 + 7) + 5 * x;
            memcpy(p, tight + 3 * (y * 8 + x), 3 * sizeof *p);
            p[3] = p[4] = NAN;
        }
    }
    air_environment_map map = map_of(tight, 8, 4);
    air_environment_ordinates *sky = prepare(*state, &map);
    choose(*state, sky, 16, NULL, a);
    air_environment_ordinates_destroy(sky);
    map.pixels = loose;
    map.pixel_stride = 5;
    map.row_stride = 5 * 8 + 7;
    sky = prepare(*state, &map);
    choose(*state, sky, 16, NULL, b);
    assert_memory_equal(a, b, sizeof a);
    air_environment_ordinates_destroy(sky);
}

/* ---- refusals ---- */

static void count_message(void *user, air_message_level level, const char *text)
{
    (void)level, (void)text;
    ++*(int *)user;
}

static void bad_pixels_are_named(void **state)
{
    (void)state;
    static float pixels[3 * WIDTH * HEIGHT];
    const float bad[] = {NAN, INFINITY, -1.0f, 2e30f};
    int messages = 0;
    air_context *context = NULL;
    air_context_params params;
    air_context_params_default(&params);
    params.message = count_message;
    params.message_user = &messages;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    for (int i = 0; i < 4; i++) {
        air_environment_ordinates *sky = NULL;
        paint(pixels, WIDTH, HEIGHT, 40);
        pixels[3 * (7 * WIDTH + 5) + 1] = bad[i];
        pixels[3 * (9 * WIDTH + 6)] = bad[i];
        assert_int_equal(air_environment_ordinates_create(context, &map, &sky), AIR_ERROR_ARGUMENT);
        assert_null(sky);
        assert_int_equal(messages, i + 1);
        assert_non_null(strstr(air_context_last_error(context), "pixel (5, 7)"));
        assert_non_null(strstr(air_context_last_error(context), "expected numbers from 0 to 1e30"));
    }
    air_context_destroy(context);
}

static void bad_maps_are_refused(void **state)
{
    static float pixels[3 * WIDTH * HEIGHT];
    for (int i = 0; i < 9; i++) {
        air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
        air_environment_ordinates *sky = NULL;
        switch (i) {
        case 0:
            map.width = 0;
            break;
        case 1:
            map.height = 0;
            break;
        case 2:
            map.width = 65536;
            break;
        case 3:
            map.pixel_stride = 2;
            break;
        case 4:
            map.row_stride = 3 * WIDTH - 1;
            break;
        case 5:
            map.radiance[1] = -1.0f;
            break;
        case 6:
            map.radiance[2] = NAN;
            break;
        case 7:
            map.contrast = 0.0f;
            break;
        default:
            map.contrast = 1.5f;
            break;
        }
        assert_int_equal(air_environment_ordinates_create(*state, &map, &sky), AIR_ERROR_ARGUMENT);
        assert_null(sky);
    }
}

static void bad_choices_are_refused(void **state)
{
    air_environment_map map;
    air_environment_map_default(&map);
    air_environment_ordinates *sky = prepare(*state, &map);
    float importance[AIR_IMPORTANCE_TEXELS] = {0};
    importance[33] = -1.0f;
    air_ordinate out = {.lobe = 42.0};
    for (int i = 0; i < 8; i++) {
        air_environment_choice choice;
        air_environment_choice_default(&choice);
        choice.count = 1;
        switch (i) {
        case 0:
            choice.count = 0;
            break;
        case 1:
            choice.count = MOST + 1;
            break;
        case 2:
            choice.form = (air_ordinate_form)7;
            break;
        case 3:
            choice.lobe = (air_ordinate_lobe)-1;
            break;
        case 4:
            choice.beta = 0.0f;
            break;
        case 5:
            choice.to_world[0] = -1.0f;
            break; /* mirrored */
        case 6:
            choice.to_world[4] = NAN;
            break;
        default:
            choice.importance = importance;
            break;
        }
        assert_int_equal(air_environment_ordinates_choose(*state, sky, &choice, &out),
                         AIR_ERROR_ARGUMENT);
        assert_true(out.lobe == 42.0);
    }
    assert_non_null(strstr(air_context_last_error(*state), "texel (1, 1)"));
    air_environment_ordinates_destroy(sky);
}

static void failed_allocations_leave_nothing(void **state)
{
    (void)state;
    static float pixels[3 * WIDTH * HEIGHT];
    paint(pixels, WIDTH, HEIGHT, 40);
    const air_environment_map map = map_of(pixels, WIDTH, HEIGHT);
    for (long allowed = 0; allowed < 100; allowed++) {
        failing_allocator allocator;
        air_context_params params = failing_params(&allocator, 1000);
        air_context *context = NULL;
        air_environment_ordinates *sky = NULL;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        atomic_store(&allocator.remaining, allowed);
        const air_status status = air_environment_ordinates_create(context, &map, &sky);
        air_environment_ordinates_destroy(sky);
        atomic_store(&allocator.remaining, 1000);
        air_context_destroy(context);
        assert_int_equal(atomic_load(&allocator.live), 0);
        if (status == AIR_OK) {
            assert_true(allowed >= 6);
            return;
        }
        assert_int_equal(status, AIR_ERROR_MEMORY);
        assert_null(sky);
    }
    fail();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(black_maps_give_dark_even_ordinates),
        cmocka_unit_test(importance_without_light_is_left_out),
        cmocka_unit_test(one_pixel_is_an_even_sky),
        cmocka_unit_test(strides_skip),
        cmocka_unit_test(bad_pixels_are_named),
        cmocka_unit_test(bad_maps_are_refused),
        cmocka_unit_test(bad_choices_are_refused),
        cmocka_unit_test(failed_allocations_leave_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
