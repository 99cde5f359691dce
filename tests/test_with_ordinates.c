/* The ordinates method in a picture: who owns what, that terms and samples add up, and that it
 * fails well. */
#include <math.h>

#include "grid_scene.h"
#include "memory_shortage.h"
#include "picture_fixture.h"

static const grid_scene outdoors = {.name = "outdoors",
                                    .lights = GRID_SUN | GRID_SKY,
                                    .sigma_s = {2, 3, 4},
                                    .sigma_a = {0.1f, 0.2f, 0.3f},
                                    .g = 0.6f,
                                    .blob = true,
                                    .blocker = true};

/* Few cells and directions. */
static air_render_params small_picture(const char *methods, uint32_t samples)
{
    air_render_params params = picture(methods, samples);
    params.max_depth = UINT32_MAX;
    params.ordinates.cells = 8;
    params.ordinates.directions = 8;
    params.ordinates.patches = 4;
    params.ordinates.bands = 3;
    params.ordinates.polar = 4;
    params.ordinates.azimuths = 8;
    params.ordinates.sweeps = 8;
    return params;
}

static air_snapshot *make_scene(air_context *context, const grid_scene *s)
{
    air_snapshot *snapshot;
    assert_int_equal(grid_scene_make(context, s, &snapshot), AIR_OK);
    return snapshot;
}

/* ---- owners ---- */

/* Light 0 is the sun, light 1 the sky. */
static void assert_owners(const grid_scene *s, const char *methods, air_method sun, air_method sky,
                          size_t warnings)
{
    messages m;
    air_context *context = make_context(1, &m);
    air_snapshot *snapshot = make_scene(context, s);
    air_owner_table *table;
    assert_int_equal(air_owner_table_create(context, snapshot, methods, &table), AIR_OK);
    assert_int_equal(air_owner_table_get(table, 0, 0, AIR_TERM_M1), sun);
    assert_int_equal(air_owner_table_get(table, 1, 0, AIR_TERM_M1), sky);
    for (size_t light = 0; light < 2; light++) {
        const air_method method = light == 0 ? sun : sky;
        const bool grid = method == AIR_METHOD_ORDINATES;
        const bool beam = method == AIR_METHOD_COLLIMATED;
        assert_int_equal(air_owner_table_get(table, light, 0, AIR_TERM_M2),
                         grid ? AIR_METHOD_ORDINATES : AIR_METHOD_PATH);
        assert_int_equal(air_owner_table_get(table, light, 1, AIR_TERM_S0),
                         beam ? AIR_METHOD_COLLIMATED : AIR_METHOD_PATH);
        assert_int_equal(air_owner_table_get(table, light, 1, AIR_TERM_S_PLUS), AIR_METHOD_PATH);
    }
    assert_int_equal(m.warnings, warnings);
    air_owner_table_destroy(table);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static const grid_scene homogeneous = {
    .name = "homogeneous", .lights = GRID_SUN | GRID_SKY, .sigma_s = {4, 4, 4}, .g = 0.5f};

static void it_owns_what_media_scatter_and_no_surface(void **state)
{
    (void)state;
    assert_owners(&outdoors, "ordinates", AIR_METHOD_ORDINATES, AIR_METHOD_ORDINATES, 0);
    assert_owners(&outdoors, "sky=path,sun=ordinates", AIR_METHOD_ORDINATES, AIR_METHOD_PATH, 0);
    assert_owners(&homogeneous, "sun=collimated,sky=ordinates", AIR_METHOD_COLLIMATED,
                  AIR_METHOD_ORDINATES, 0);
    assert_owners(&homogeneous, "sky=ordinates", AIR_METHOD_COLLIMATED, AIR_METHOD_ORDINATES, 0);
    assert_owners(&homogeneous, "auto", AIR_METHOD_COLLIMATED, AIR_METHOD_PATH, 0);
}

static void interactive_is_ordinates_but_for_suns_in_thin_haze(void **state)
{
    (void)state;
    grid_scene thin = homogeneous, endless = homogeneous;
    room_set3(thin.sigma_s, 0.9f, 0.5f, 0.1f); /* a cube of 1 m: less than one event */
    endless.endless = true;
    assert_owners(&outdoors, "interactive", AIR_METHOD_ORDINATES, AIR_METHOD_ORDINATES, 0);
    assert_owners(&homogeneous, "interactive", AIR_METHOD_ORDINATES, AIR_METHOD_ORDINATES, 0);
    assert_owners(&thin, "interactive", AIR_METHOD_COLLIMATED, AIR_METHOD_ORDINATES, 0);
    assert_owners(&endless, "interactive", AIR_METHOD_PATH, AIR_METHOD_PATH, 0);
    assert_owners(&homogeneous, "interactive,sun=path", AIR_METHOD_PATH, AIR_METHOD_ORDINATES, 0);
    assert_owners(&homogeneous, "sky=interactive", AIR_METHOD_COLLIMATED, AIR_METHOD_ORDINATES, 0);
}

static void media_without_end_leave_lights_to_path_with_a_warning(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    grid_scene s = homogeneous;
    s.endless = true;
    assert_owners(&s, "ordinates", AIR_METHOD_PATH, AIR_METHOD_PATH, 1);
    air_snapshot *snapshot = make_scene(context, &s);
    air_owner_table *table;
    assert_int_equal(air_owner_table_create(context, snapshot, "sun=ordinates", &table), AIR_OK);
    assert_string_equal(m.last_warning,
                        "method ordinates leaves light \"sun\" to path: medium \"air\" has no end");
    air_owner_table_destroy(table);
    air_snapshot_release(snapshot);
    s.endless = false;
    room_set3(s.sigma_s, 0.0f, 0.0f, 0.0f);
    room_set3(s.sigma_a, 1.0f, 1.0f, 1.0f);
    snapshot = make_scene(context, &s);
    assert_int_equal(air_owner_table_create(context, snapshot, "sun=ordinates", &table), AIR_OK);
    assert_non_null(strstr(m.last_warning, "no medium scatters light"));
    air_owner_table_destroy(table);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void modes_are_told(void **state)
{
    (void)state;
    static const char *const modes[] = {"dom", "cm", "six", "literal", "shdom"};
    messages m;
    air_context *context = make_context(1, &m);
    air_snapshot *snapshot = make_scene(context, &outdoors);
    air_owner_table *table;
    for (size_t i = 0; i < sizeof modes / sizeof modes[0]; i++) {
        char methods[32];
        snprintf(methods, sizeof methods, "ordinates:%s", modes[i]);
        assert_int_equal(air_owner_table_create(context, snapshot, methods, &table), AIR_OK);
        assert_string_equal(air_owner_table_mode(table, 1), modes[i]);
        air_owner_table_destroy(table);
    }
    assert_int_equal(air_owner_table_create(context, snapshot, "ordinates:best", &table),
                     AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context),
                           "expected one of auto, interactive, path, collimated["));
    assert_non_null(
        strstr(air_context_last_error(context), "ordinates[:dom|cm|six|literal|shdom]"));
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- terms ---- */

static const char *const mixes[] = {"ordinates", "sun=path,sky=ordinates", "sky=path,sun=ordinates",
                                    "sun=collimated,sky=ordinates"};
enum { MIXES = sizeof mixes / sizeof mixes[0] };

/* Pixels of a are those of b but for the rounding of floats: terms are sums of up to a few hundred
 * steps along a ray in float, of which M2 is a difference; 2^-24 for each. */
static void assert_equal_up_to_rounding(const air_image *a, const float *b)
{
    static const char *const names[3] = {"R", "G", "B"};
    float largest = 0.0f;
    for (size_t c = 0; c < 3; c++) {
        const float *const plane =
            air_image_plane_const(a, (size_t)air_image_find_channel(a, names[c]));
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            largest = fmaxf(largest, plane[i]);
        }
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            const float off = fabsf(plane[i] - b[c * WIDTH * HEIGHT + i]);
            if (!(off <= 3e-5f * largest)) {
                fail_msg("channel %zu, pixel %zu: %g and %g", c, i, (double)plane[i],
                         (double)b[c * WIDTH * HEIGHT + i]);
            }
        }
    }
    assert_true(largest > 0.0f);
}

static void add_image(const air_image *image, const char *prefix, float *sum)
{
    static const char *const names[3] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; c++) {
        char name[32];
        snprintf(name, sizeof name, "%s%s", prefix, names[c]);
        const ptrdiff_t at = air_image_find_channel(image, name);
        assert_true(at >= 0);
        const float *const plane = air_image_plane_const(image, (size_t)at);
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            sum[c * WIDTH * HEIGHT + i] += plane[i];
        }
    }
}

static void terms_and_layers_add_up_to_the_whole(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(2, &m);
    for (int i = 0; i < MIXES; i++) {
        float sum[3 * WIDTH * HEIGHT] = {0}, layers[3 * WIDTH * HEIGHT] = {0};
        air_snapshot *snapshot = make_scene(context, i == 3 ? &homogeneous : &outdoors);
        air_render_params params = small_picture(mixes[i], 16);
        params.layers = false;
        air_image *whole = render(context, snapshot, &params);
        params.layers = true;
        air_image *apart = render(context, snapshot, &params);
        for (uint32_t t = 0; t < AIR_TERM_COUNT; t++) {
            char prefix[32];
            snprintf(prefix, sizeof prefix, "%s.", air_term_name((air_term)t));
            add_image(apart, prefix, layers);
            params.terms = 1u << t;
            params.layers = false;
            air_image *term = render(context, snapshot, &params);
            add_image(term, "", sum);
            air_image_destroy(term);
        }
        assert_equal_up_to_rounding(whole, layers);
        assert_equal_up_to_rounding(whole, sum);
        air_image_destroy(whole);
        air_image_destroy(apart);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

/* One event is M1 alone, in the same bits as where more are asked for. */
static void a_depth_of_one_is_single_scattering(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    air_snapshot *snapshot = make_scene(context, &outdoors);
    float first[3 * WIDTH * HEIGHT] = {0};
    air_render_params params = small_picture("ordinates", 4);
    params.terms = 1u << AIR_TERM_M1 | 1u << AIR_TERM_M2;
    air_image *deep = render(context, snapshot, &params);
    add_image(deep, "M1.", first);
    params.max_depth = 1;
    params.layers = false;
    air_image *single = render(context, snapshot, &params);
    for (size_t c = 0; c < 3; c++) {
        static const char *const names[3] = {"R", "G", "B"};
        const ptrdiff_t at = air_image_find_channel(single, names[c]);
        assert_memory_equal(air_image_plane(single, (size_t)at), first + c * WIDTH * HEIGHT,
                            WIDTH * HEIGHT * sizeof(float));
    }
    air_image_destroy(single);
    air_image_destroy(deep);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- settings ---- */

static void settings_out_of_range_are_refused(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    air_snapshot *snapshot = make_scene(context, &outdoors);
    for (int i = 0; i < 14; i++) {
        air_render_params params = small_picture("path", 1); /* whoever owns the light */
        air_ordinates_settings *const o = &params.ordinates;
        air_film *film = (air_film *)&params;
        uint32_t *const numbers[6] = {&o->cells,  &o->directions, &o->patches,
                                      &o->sweeps, &o->steps,      &o->march};
        if (i < 6) {
            *numbers[i] = 0;
        } else if (i < 9) {
            *numbers[i - 6] = 4097;
        } else {
            o->change = i == 9 ? -1.0 : o->change;
            o->bands = i == 10 ? 11 : i == 11 ? 5 : o->bands;
            o->polar = i == 12 ? 3 : o->polar;
            o->azimuths = i == 13 ? 10 : o->azimuths;
        }
        assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_ARGUMENT);
        assert_null(film);
        assert_non_null(strstr(air_context_last_error(context), "expected"));
    }
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* No machine has so much, and nothing of it is asked for. */
static void a_grid_beyond_the_memory_is_refused_before_it_is_made(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    air_snapshot *snapshot = make_scene(context, &homogeneous);
    air_render_params params = small_picture("ordinates", 1);
    air_film *film = NULL;
    params.ordinates.cells = 256;
    params.ordinates.bands = 10;
    params.ordinates.polar = 10;
    params.ordinates.azimuths = 20;
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_MEMORY);
    assert_null(film);
    assert_non_null(strstr(air_context_last_error(context),
                           "ordinates: 256 x 256 x 256 cells with 10 bands need 5"));
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- splits ---- */

static void splits_and_threads_change_no_byte(void **state)
{
    (void)state;
    float first[WIDTH * HEIGHT];
    for (size_t threads = 1; threads <= 3; threads++) {
        air_context *context = make_context(threads, NULL);
        air_snapshot *snapshot = make_scene(context, &outdoors);
        air_film *film, *rest;
        air_image *image;
        air_render_params params = small_picture("ordinates", 32);
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
        const ptrdiff_t at = air_image_find_channel(image, "R");
        if (threads == 1) {
            memcpy(first, air_image_plane(image, (size_t)at), sizeof first);
        }
        assert_memory_equal(air_image_plane(image, (size_t)at), first, sizeof first);
        air_image_destroy(image);
        air_film_destroy(film);
        air_snapshot_release(snapshot);
        air_context_destroy(context);
    }
}

static void films_of_other_grids_do_not_merge(void **state)
{
    (void)state;
    air_context *context = make_context(1, NULL);
    air_snapshot *snapshot = make_scene(context, &outdoors);
    air_film *film, *other;
    air_render_params params = small_picture("ordinates", 16);
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
    params.sample_begin = 16;
    params.sample_end = 32;
    params.ordinates.cells = 9;
    assert_int_equal(air_render(context, snapshot, &params, &other), AIR_OK);
    assert_int_equal(air_film_merge(film, other), AIR_ERROR_ARGUMENT);
    air_film_destroy(other);
    air_film_destroy(film);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static air_status try_render(air_context *context, void *user)
{
    const grid_scene *const s = user;
    air_snapshot *snapshot;
    air_film *film = NULL;
    air_status status = grid_scene_make(context, s, &snapshot);
    if (status == AIR_OK) {
        air_render_params params = small_picture("ordinates", 1);
        params.width = 4;
        params.height = 3;
        params.ordinates.cells = 3;
        status = air_render(context, snapshot, &params, &film);
        assert_true((status == AIR_OK) == (film != NULL));
    }
    air_film_destroy(film);
    air_snapshot_release(snapshot);
    return status;
}

static void allocation_failures_are_reported_and_leak_nothing(void **state)
{
    (void)state;
    grid_scene s = outdoors;
    s.lights |= GRID_LAMP;
    assert_shortage_survived(try_render, &s, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_owns_what_media_scatter_and_no_surface),
        cmocka_unit_test(interactive_is_ordinates_but_for_suns_in_thin_haze),
        cmocka_unit_test(media_without_end_leave_lights_to_path_with_a_warning),
        cmocka_unit_test(modes_are_told),
        cmocka_unit_test(terms_and_layers_add_up_to_the_whole),
        cmocka_unit_test(a_depth_of_one_is_single_scattering),
        cmocka_unit_test(settings_out_of_range_are_refused),
        cmocka_unit_test(a_grid_beyond_the_memory_is_refused_before_it_is_made),
        cmocka_unit_test(splits_and_threads_change_no_byte),
        cmocka_unit_test(films_of_other_grids_do_not_merge),
        cmocka_unit_test(allocation_failures_are_reported_and_leak_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
