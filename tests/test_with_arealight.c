/* The arealight method in pictures: who owns what, and that its light is path's. */
#include <math.h>

#include "picture_fixture.h"
#include "sun_scene.h"

/* Lamps over matte floor and blocks. */
static sun_scene lamp_scene(int number)
{
    sun_scene s = sun_scene_default();
    s.no_suns = true;
    s.matte = number != 2;
    s.panels = number == 0 ? 1 : 2;
    s.camera_inside = number == 2;
    s.second_medium = number == 3;
    s.third_medium = number == 3;
    s.coverage = number == 4;
    s.mixture = number == 6;
    if (number == 1) {
        room_set3(s.sigma_s, 0.2f, 0.5f, 1.2f);
    }
    if (number == 5) { /* suns beside lamps */
        s.no_suns = false;
        s.windows = true;
    }
    return s;
}
enum { SCENES = 7 };

static void owners_are_as_asked_for(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    const sun_scene s = lamp_scene(5);
    air_snapshot *snapshot;
    air_owner_table *table;
    assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
    assert_int_equal(
        air_owner_table_create(context, snapshot, "panel=arealight,corner=arealight:mix", &table),
        AIR_OK);
    assert_int_equal(air_owner_table_get(table, 0, 0, AIR_TERM_M1), AIR_METHOD_AREALIGHT);
    assert_int_equal(air_owner_table_get(table, 0, 1, AIR_TERM_S0), AIR_METHOD_AREALIGHT);
    assert_int_equal(air_owner_table_get(table, 0, 0, AIR_TERM_M2), AIR_METHOD_PATH);
    assert_int_equal(air_owner_table_get(table, 2, 0, AIR_TERM_M1), AIR_METHOD_COLLIMATED);
    assert_string_equal(air_owner_table_mode(table, 0), "edge");
    assert_string_equal(air_owner_table_mode(table, 1), "mix");
    assert_string_equal(air_owner_table_mode(table, 2), "exact");
    air_owner_table_destroy(table);
    assert_int_equal(m.warnings, 0);
    assert_int_equal(air_owner_table_create(context, snapshot, "sun=arealight", &table), AIR_OK);
    assert_int_equal(m.warnings, 1);
    assert_non_null(strstr(m.last_warning, "arealight leaves light \"sun\" to path"));
    air_owner_table_destroy(table);
    assert_int_equal(air_owner_table_create(context, snapshot, "arealight:best", &table),
                     AIR_ERROR_ARGUMENT);
    assert_non_null(
        strstr(air_context_last_error(context), "arealight[:edge|mix|ltsd|volume-ris]"));
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* Eight nodes are off by less than 1e-3 of the light in a scene's middle (bench_arealight), the
 * ratios' bias is of the order of the squared noise of a replicate, 16 samples: both below what the
 * test can see, 1 % of a block's light. */
static void every_exact_mode_has_the_expectation_of_path(void **state)
{
    (void)state;
    static const char *const modes[] = {"panel=arealight,corner=arealight", "arealight:volume-ris",
                                        "corner=arealight"};
    messages m;
    air_context *context = make_context(2, &m);
    for (int i = 0; i < SCENES; i++) {
        const sun_scene s = lamp_scene(i);
        air_snapshot *snapshot;
        assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
        air_render_params params = picture("path", 256);
        params.variance_replicates = REPLICATES;
        params.layers = false;
        params.tile_size = 8;
        params.sample_end = 1024; /* path is noisy near lamps, and all else is held against it */
        air_image *truth = render(context, snapshot, &params);
        params.sample_end = 256;
        for (size_t k = 0; k < (s.panels > 1 ? 3 : 2); k++) {
            params.methods = s.panels > 1 ? modes[k] : k == 0 ? "panel=arealight" : modes[k];
            params.seed = 1 + k;
            air_image *image = render(context, snapshot, &params);
            assert_same_expectation(context, image, truth, i, params.methods);
            air_image_destroy(image);
        }
        air_image_destroy(truth);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

static void assert_expectation_of_path(const sun_scene *s, int number)
{
    messages m;
    air_context *context = make_context(2, &m);
    air_snapshot *snapshot;
    assert_int_equal(sun_scene_make(context, s, &snapshot), AIR_OK);
    air_render_params params = picture("path", 256);
    params.variance_replicates = REPLICATES;
    params.layers = false;
    params.tile_size = 8;
    params.sample_end = 1024;
    air_image *truth = render(context, snapshot, &params);
    params.methods = "arealight";
    params.sample_end = 256;
    params.seed = 1;
    air_image *image = render(context, snapshot, &params);
    assert_same_expectation(context, image, truth, number, params.methods);
    assert_int_equal(m.warnings, 0);
    air_image_destroy(image);
    air_image_destroy(truth);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* A rectangle of cells, an L with two sides, with shadows; and the rectangle by a mirror. */
static void emissive_meshes_have_the_expectation_of_path(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        sun_scene s = lamp_scene(i == 0 ? 1 : 0);
        s.glow = 4;
        s.mirrored = i == 1;
        assert_expectation_of_path(&s, i);
    }
}

static air_image *without_shadows(air_context *context, const sun_scene *s)
{
    air_snapshot *snapshot;
    assert_int_equal(sun_scene_make(context, s, &snapshot), AIR_OK);
    air_render_params params = picture("arealight", 1);
    params.shadow_samples = 0;
    params.layers = false;
    air_image *image = render(context, snapshot, &params);
    air_snapshot_release(snapshot);
    return image;
}

/* The corners are equal floats, so that the lamps differ by the order of their corners only: sums
 * in double are of 1e-15, pixels are floats. 12 x 12 cells have more triangles than there may be
 * lamps. The L of the second scene is cut the same way as a light and as a mesh. */
static void a_rectangle_is_one_lamp_however_it_is_cut(void **state)
{
    (void)state;
    static const int cells[4] = {1, 4, 12, 4};
    messages m;
    air_context *context = make_context(2, &m);
    for (int number = 0; number < 4; number += 3) {
        sun_scene s = lamp_scene(number);
        air_image *whole = without_shadows(context, &s);
        for (int i = 0; i < 4; i++) {
            s.glow = cells[i];
            s.mirrored = i > 1;
            air_image *cut = without_shadows(context, &s);
            for (size_t c = 0; c < air_image_channel_count(whole); c++) {
                const float *a = air_image_plane(whole, c), *b = air_image_plane(cut, c);
                float sum = 0.0f;
                for (size_t p = 0; p < WIDTH * HEIGHT; p++) {
                    assert_true(fabsf(a[p] - b[p]) <= 1e-6f * fabsf(a[p]));
                    sum += b[p];
                }
                assert_true(sum > 0.0f);
            }
            air_image_destroy(cut);
        }
        air_image_destroy(whole);
    }
    assert_int_equal(m.warnings, 0);
    air_context_destroy(context);
}

/* Haze from nearly none to nearly solid, every mode and rule, smoothed or not. */
static void nothing_is_ever_not_finite(void **state)
{
    static const float sigmas[] = {1e-6f, 1.0f, 1e3f};
    static const char *const modes[] = {"arealight", "arealight:mix", "arealight:ltsd",
                                        "arealight:volume-ris"};
    messages m;
    air_context *context = make_context(2, &m);
    (void)state;
    for (int n = 0; n < 3 * 4 * 2; n++) {
        sun_scene s = lamp_scene(n % 2 == 0 ? 3 : 2);
        air_snapshot *snapshot;
        air_film *film;
        air_image *image;
        room_set3(s.sigma_s, sigmas[n % 3], sigmas[(n + 1) % 3], sigmas[n % 3]);
        assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
        air_render_params params = picture(modes[n / 6], 2);
        params.area_rule = (air_area_rule)(n % 4);
        params.shadow_samples = (uint32_t)(n % 3);
        assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
        assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
        for (size_t c = 0; c < air_image_channel_count(image); c++) {
            for (size_t p = 0; p < WIDTH * HEIGHT; p++) {
                assert_true(isfinite(air_image_plane(image, c)[p]));
            }
        }
        air_image_destroy(image);
        air_film_destroy(film);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

/* Films of parts are the film of the whole, and tiles and threads change nothing. */
static void splits_and_threads_change_no_byte(void **state)
{
    (void)state;
    const sun_scene s = lamp_scene(4);
    float first[WIDTH * HEIGHT];
    for (size_t threads = 1; threads <= 3; threads++) {
        air_context *context = make_context(threads, NULL);
        air_snapshot *snapshot;
        air_film *film, *rest;
        air_image *image;
        assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
        air_render_params params = picture("arealight", 32);
        params.tile_size = 5 * threads;
        params.sample_end = threads == 1 ? 32 : 16;
        assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
        if (threads > 1) {
            params.sample_begin = 16;
            params.sample_end = 32;
            assert_int_equal(air_render(context, snapshot, &params, &rest), AIR_OK);
            assert_int_equal(air_film_merge(film, rest), AIR_OK);
            air_film_destroy(rest);
        }
        assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
        if (threads == 1) {
            memcpy(first, air_image_plane(image, 0), sizeof first);
        }
        assert_memory_equal(air_image_plane(image, 0), first, sizeof first);
        air_image_destroy(image);
        air_film_destroy(film);
        air_snapshot_release(snapshot);
        air_context_destroy(context);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(owners_are_as_asked_for),
        cmocka_unit_test(nothing_is_ever_not_finite),
        cmocka_unit_test(splits_and_threads_change_no_byte),
        cmocka_unit_test(a_rectangle_is_one_lamp_however_it_is_cut),
        cmocka_unit_test(emissive_meshes_have_the_expectation_of_path),
        cmocka_unit_test(every_exact_mode_has_the_expectation_of_path),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
