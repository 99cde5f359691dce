/* The collimated method in pictures: who owns what, and that every way of sharing light out between
 * it and path gives the picture that path gives alone. */
#include "image/film.h"
#include "picture_fixture.h"
#include "sun_scene.h"

/* ---- owners ---- */

static void owners_are_as_asked_for(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    sun_scene s = sun_scene_default();
    air_snapshot *snapshot;
    air_owner_table *table;
    s.lamp = s.two_suns = s.second_medium = true;
    assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
    assert_int_equal(
        air_owner_table_create(context, snapshot, "second sun=collimated:rees", &table), AIR_OK);
    for (size_t medium = 0; medium < 2; medium++) { /* lights: sun, second sun, bulb */
        assert_int_equal(air_owner_table_get(table, 0, medium, AIR_TERM_M1), AIR_METHOD_COLLIMATED);
        assert_int_equal(air_owner_table_get(table, 1, medium, AIR_TERM_M1), AIR_METHOD_COLLIMATED);
        assert_int_equal(air_owner_table_get(table, 2, medium, AIR_TERM_M1), AIR_METHOD_PATH);
        assert_int_equal(air_owner_table_get(table, 0, medium, AIR_TERM_M2), AIR_METHOD_PATH);
    }
    assert_int_equal(air_owner_table_get(table, 0, 2, AIR_TERM_S0), AIR_METHOD_COLLIMATED);
    assert_int_equal(air_owner_table_get(table, 0, 2, AIR_TERM_S_PLUS), AIR_METHOD_PATH);
    assert_int_equal(air_owner_table_get(table, 2, 2, AIR_TERM_S0), AIR_METHOD_PATH);
    assert_string_equal(air_owner_table_mode(table, 0), "exact");
    assert_string_equal(air_owner_table_mode(table, 1), "rees");
    assert_string_equal(air_owner_table_mode(table, 2), "");
    assert_int_equal(m.warnings, 0);
    air_owner_table_destroy(table);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void a_name_means_all_lights_that_have_it(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    sun_scene s = sun_scene_default();
    air_snapshot *snapshot;
    air_owner_table *table;
    s.two_suns = s.one_name = true;
    assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
    assert_int_equal(air_owner_table_create(context, snapshot, "sun=path", &table), AIR_OK);
    for (size_t light = 0; light < 2; light++) {
        assert_int_equal(air_owner_table_get(table, light, 0, AIR_TERM_M1), AIR_METHOD_PATH);
    }
    air_owner_table_destroy(table);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void what_does_not_apply_is_left_to_path_with_one_warning(void **state)
{
    (void)state;
    messages m;
    air_context *context = make_context(1, &m);
    air_snapshot *snapshot;
    air_owner_table *table;
    assert_int_equal(room_make(context, true, &snapshot), AIR_OK); /* with a grid */
    m.warnings = 0;
    assert_int_equal(air_owner_table_create(context, snapshot, "auto", &table), AIR_OK);
    assert_int_equal(m.warnings, 0);
    assert_int_equal(air_owner_table_get(table, 1, 0, AIR_TERM_M1), AIR_METHOD_PATH);
    air_owner_table_destroy(table);
    assert_int_equal(air_owner_table_create(context, snapshot, "sun=collimated", &table), AIR_OK);
    assert_int_equal(m.warnings, 1);
    assert_non_null(strstr(m.last_warning, "smoke"));
    assert_non_null(strstr(m.last_warning, "sun"));
    assert_int_equal(air_owner_table_get(table, 1, 0, AIR_TERM_M1), AIR_METHOD_PATH);
    air_owner_table_destroy(table);
    assert_int_equal(air_owner_table_create(context, snapshot, "collimated:rm", &table), AIR_OK);
    assert_int_equal(m.warnings, 2);
    assert_non_null(strstr(m.last_warning, "bulb"));
    air_owner_table_destroy(table);
    assert_int_equal(air_owner_table_create(context, snapshot, "collimated:best", &table),
                     AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "collimated:best"));
    assert_non_null(strstr(air_context_last_error(context), "wvds"));
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* The mean of one term's layer, all channels. */
static double layer_mean(const air_image *image, const char *term)
{
    char name[16];
    double sum = 0.0;
    snprintf(name, sizeof name, "%s.R", term);
    const ptrdiff_t first = air_image_find_channel(image, name);
    assert_true(first >= 0);
    for (size_t c = 0; c < 3; c++) {
        const float *plane = air_image_plane_const(image, (size_t)first + c);
        for (size_t p = 0; p < WIDTH * HEIGHT; p++) {
            sum += (double)plane[p] / (3.0 * WIDTH * HEIGHT);
        }
    }
    return sum;
}

/* ---- the same picture ---- */

/* Scenes that between them hold every way through the code. */
static sun_scene scene_number(int i)
{
    sun_scene s = sun_scene_default();
    s.windows = i == 1 || i == 4;
    s.two_suns = i == 2 || i == 6;
    s.coverage = i == 3 || i == 4;
    s.lamp = i == 2;
    s.camera_inside = i == 1 || i == 5;
    s.second_medium = i >= 5;
    s.third_medium = i == 6;
    s.mixture = i == 7;
    if (i == 4 || i == 3) {
        room_set3(s.sigma_s, 0.2f, 0.5f, 1.2f);
    }
    if (i == 0) {
        room_set3(s.dir, 0.0f, -1.0f, 0.0f); /* parallel to four faces of the box */
    }
    return s;
}

enum { SCENES = 8 };

static void every_mode_has_the_expectation_of_path(void **state)
{
    (void)state;
    static const char *const modes[] = {"auto",
                                        "collimated:rm",
                                        "collimated:ds",
                                        "collimated:wvds",
                                        "collimated:rees",
                                        "collimated:reds",
                                        "sun=path"};
    static const air_pattern patterns[] = {AIR_PATTERN_STRATIFIED, AIR_PATTERN_INDEPENDENT,
                                           AIR_PATTERN_SYSTEMATIC, AIR_PATTERN_BLUE_NOISE};
    messages m;
    air_context *context = make_context(2, &m);
    for (int i = 0; i < SCENES; i++) {
        const sun_scene s = scene_number(i);
        air_snapshot *snapshot;
        assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
        air_render_params params = picture("path", 512);
        params.variance_replicates = REPLICATES;
        params.max_depth = i == 2 ? 4 : 1; /* one scene with all terms */
        params.layers = false;
        air_image *truth = render(context, snapshot, &params);
        for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
            params.methods = modes[k];
            params.pattern = patterns[(k + (size_t)i) % 4];
            params.seed = 1 + k;
            air_image *image = render(context, snapshot, &params);
            assert_same_expectation(context, image, truth, i, modes[k]);
            air_image_destroy(image);
        }
        air_image_destroy(truth);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

/* Suns of which one keeps three sums and the other does not, in chromatic media: the choice between
 * them goes by luminance, what they give does not. */
static void ratio_and_plain_modes_mix(void **state)
{
    (void)state;
    static const char *const methods[] = {"sun=collimated:rees,second sun=collimated:rm",
                                          "sun=collimated:ds,second sun=collimated:reds"};
    messages m;
    air_context *context = make_context(2, &m);
    sun_scene s = scene_number(2);
    air_snapshot *snapshot;
    s.lamp = false;
    room_set3(s.sigma_s, 0.2f, 0.5f, 1.2f);
    assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
    air_render_params params = picture("path", 512);
    params.variance_replicates = REPLICATES;
    params.layers = false;
    air_image *truth = render(context, snapshot, &params);
    for (size_t k = 0; k < 2; k++) {
        params.methods = methods[k];
        params.seed = 3 + k;
        air_image *image = render(context, snapshot, &params);
        assert_same_expectation(context, image, truth, 2, methods[k]);
        air_image_destroy(image);
    }
    air_image_destroy(truth);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* Through pixel centres nothing in an exact picture is left to chance: one sample gives what 32
 * give, to the rounding of sums of doubles. */
static void exact_pictures_have_no_noise(void **state)
{
    (void)state;
    air_context *context = make_context(2, NULL);
    for (int i = 0; i < SCENES; i++) {
        const sun_scene s = scene_number(i);
        air_snapshot *snapshot;
        if (s.coverage || s.lamp) {
            continue; /* these are sampled */
        }
        assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
        air_render_params params = picture("auto", 1);
        params.filter = AIR_FILTER_POINT;
        air_image *one = render(context, snapshot, &params);
        params.sample_end = 32;
        params.seed = 9;
        air_image *many = render(context, snapshot, &params);
        double sum = 0.0;
        for (size_t c = 0; c < 3; c++) {
            const float *a = air_image_plane(one, c), *b = air_image_plane(many, c);
            for (size_t p = 0; p < WIDTH * HEIGHT; p++) {
                assert_float_equal(a[p], b[p], 1e-6f * b[p]);
                sum += (double)a[p];
            }
        }
        assert_true(sum > 1.0);
        air_image_destroy(one);
        air_image_destroy(many);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

/* Moments are biased; that they come near shows that map, weights and bounds fit together. The
 * blocks throw shadows of two depths at most, which four moments tell exactly but for the shared
 * weight: within 5 % of the exact mean. */
static void moments_come_near(void **state)
{
    (void)state;
    static const char *const modes[] = {"collimated:me", "collimated:me6", "collimated:me-ideal",
                                        "collimated:me6-ideal"};
    air_context *context = make_context(2, NULL);
    for (int i = 0; i < SCENES; i++) {
        const sun_scene s = scene_number(i);
        air_snapshot *snapshot;
        if (s.coverage) {
            continue; /* left out by moments */
        }
        assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
        air_render_params params = picture("collimated", 16);
        params.terms = 1u << AIR_TERM_M1;
        air_image *exact = render(context, snapshot, &params);
        const double expected = layer_mean(exact, "M1");
        air_image_destroy(exact);
        for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
            params.methods = modes[k];
            air_image *image = render(context, snapshot, &params);
            const double got = layer_mean(image, "M1");
            if (!(fabs(got - expected) < 0.05 * expected)) {
                fail_msg("scene %d, %s: %g, exact %g", i, modes[k], got, expected);
            }
            air_image_destroy(image);
        }
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

/* A near plane in front of the haze cuts nothing off: the picture stays but for the rounding of
 * where rays begin, 1e-7 of some 5 m. */
static void moments_know_where_rays_begin(void **state)
{
    (void)state;
    static const char *const modes[] = {"collimated:me", "collimated:me6-ideal"};
    air_context *context = make_context(2, NULL);
    for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
        sun_scene s = scene_number(7);
        air_render_params params = picture(modes[k], 16);
        double means[2];
        params.terms = 1u << AIR_TERM_M1;
        for (int i = 0; i < 2; i++) {
            air_snapshot *snapshot;
            s.near_distance = i == 0 ? 0.0f : 2.5f;
            assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
            air_image *image = render(context, snapshot, &params);
            means[i] = layer_mean(image, "M1");
            air_image_destroy(image);
            air_snapshot_release(snapshot);
        }
        if (!(fabs(means[1] - means[0]) < 1e-5 * means[0])) {
            fail_msg("%s: %g behind a near plane, %g without", modes[k], means[1], means[0]);
        }
    }
    air_context_destroy(context);
}

/* ---- the same bytes ---- */

static void assert_same_film(const air_film *a, const air_film *b)
{
    assert_int_equal(a->node_count, b->node_count);
    for (size_t i = 0; i < a->node_count; i++) {
        assert_memory_equal(a->nodes[i].sums, b->nodes[i].sums,
                            air_film_pixel_count(a) * a->layout.stride * sizeof(double));
    }
}

static air_film *film_of(air_context *context, const sun_scene *s, const air_render_params *params)
{
    air_snapshot *snapshot;
    air_film *film;
    assert_int_equal(sun_scene_make(context, s, &snapshot), AIR_OK);
    assert_int_equal(air_render(context, snapshot, params, &film), AIR_OK);
    air_snapshot_release(snapshot);
    return film;
}

static void threads_tiles_and_splits_change_no_byte(void **state)
{
    (void)state;
    static const char *const modes[] = {"collimated", "collimated:wvds", "collimated:reds",
                                        "collimated:me"};
    air_context *one = make_context(1, NULL), *three = make_context(3, NULL);
    sun_scene s = scene_number(4);
    s.two_suns = true;
    for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
        air_render_params params = picture(modes[k], 64);
        air_film *whole = film_of(one, &s, &params);
        params.tile_size = 5;
        air_film *threaded = film_of(three, &s, &params);
        assert_same_film(whole, threaded);
        params.sample_end = 32;
        air_film *first = film_of(three, &s, &params);
        params.sample_begin = 32;
        params.sample_end = 64;
        air_film *second = film_of(three, &s, &params);
        assert_int_equal(air_film_merge(first, second), AIR_OK);
        assert_same_film(whole, first);
        air_film_destroy(whole);
        air_film_destroy(threaded);
        air_film_destroy(first);
        air_film_destroy(second);
    }
    air_context_destroy(one);
    air_context_destroy(three);
}

/* ---- sums ---- */

/* M1 and S0 alone are what they are together with the rest. */
static void terms_rendered_apart_are_those_of_the_whole(void **state)
{
    (void)state;
    static const char *const modes[] = {"collimated", "collimated:reds"};
    air_context *context = make_context(2, NULL);
    const sun_scene s = scene_number(6);
    air_snapshot *snapshot;
    assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
    for (size_t k = 0; k < 2; k++) {
        air_render_params params = picture(modes[k], 16);
        params.max_depth = 3;
        air_image *all = render(context, snapshot, &params);
        for (unsigned term = AIR_TERM_S0; term <= AIR_TERM_M2; term++) {
            const char *name = air_term_name((air_term)term);
            params.terms = 1u << term;
            air_image *alone = render(context, snapshot, &params);
            const double expected = layer_mean(all, name);
            assert_true(expected > 0.0);
            assert_true(fabs(layer_mean(alone, name) - expected) <= 1e-6 * expected);
            air_image_destroy(alone);
        }
        air_image_destroy(all);
    }
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

/* ---- extremes ---- */

static void nothing_is_ever_not_finite(void **state)
{
    (void)state;
    static const char *const modes[] = {"collimated",      "collimated:rm",       "collimated:ds",
                                        "collimated:wvds", "collimated:rees",     "collimated:reds",
                                        "collimated:me",   "collimated:me6-ideal"};
    static const float densities[] = {0.0f, 1e-30f, 1e-6f, 50.0f, 1e6f, 1e30f};
    air_context *context = make_context(2, NULL);
    for (size_t d = 0; d < sizeof densities / sizeof *densities; d++) {
        for (int i = 0; i < SCENES; i++) {
            sun_scene s = scene_number(i);
            air_snapshot *snapshot;
            room_set3(s.sigma_s, densities[d], 0.5f * densities[d], 0.0f);
            room_set3(s.sigma_a, 0.0f, densities[d], densities[d]);
            assert_int_equal(sun_scene_make(context, &s, &snapshot), AIR_OK);
            for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
                const air_render_params params = picture(modes[k], 16);
                air_image *image = render(context, snapshot, &params);
                for (size_t c = 0; c < air_image_channel_count(image); c++) {
                    const float *plane = air_image_plane(image, c);
                    for (size_t p = 0; p < WIDTH * HEIGHT; p++) {
                        assert_true(isfinite(plane[p]) && plane[p] >= 0.0f);
                    }
                }
                air_image_destroy(image);
            }
            air_snapshot_release(snapshot);
        }
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(owners_are_as_asked_for),
        cmocka_unit_test(a_name_means_all_lights_that_have_it),
        cmocka_unit_test(what_does_not_apply_is_left_to_path_with_one_warning),
        cmocka_unit_test(every_mode_has_the_expectation_of_path),
        cmocka_unit_test(ratio_and_plain_modes_mix),
        cmocka_unit_test(exact_pictures_have_no_noise),
        cmocka_unit_test(moments_come_near),
        cmocka_unit_test(moments_know_where_rays_begin),
        cmocka_unit_test(threads_tiles_and_splits_change_no_byte),
        cmocka_unit_test(terms_rendered_apart_are_those_of_the_whole),
        cmocka_unit_test(nothing_is_ever_not_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
