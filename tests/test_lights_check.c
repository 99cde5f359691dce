#include "cmocka_test.h"
#include "light_fixture.h"

/* Does the description fail with a message that names the light and says `part`? */
static void expect_bad(air_context *context, air_light_desc *desc, const char *part)
{
    desc->name = "lamp";
    assert_int_equal(air_light_check(context, desc), AIR_ERROR_ARGUMENT);
    const char *message = air_context_last_error(context);
    if (strstr(message, "\"lamp\"") == NULL || strstr(message, part) == NULL) {
        fail_msg("\"%s\" does not name the lamp and say \"%s\"", message, part);
    }
}

static air_light_desc described(air_light_kind kind)
{
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.kind = kind;
    return desc;
}

static air_light_desc polygon(const float *vertices, size_t count)
{
    air_light_desc desc = described(AIR_LIGHT_POLYGON);
    desc.vertices = vertices;
    desc.vertex_count = count;
    return desc;
}

static void the_default_of_every_kind_without_arrays_is_sound(void **state)
{
    const air_light_kind kinds[] = {AIR_LIGHT_POINT, AIR_LIGHT_SPOT, AIR_LIGHT_COLLIMATED,
                                    AIR_LIGHT_ENVIRONMENT};
    for (int i = 0; i < 4; i++) {
        const air_light_desc desc = described(kinds[i]);
        assert_int_equal(air_light_check(*state, &desc), AIR_OK);
    }
}

static void bad_numbers_are_named(void **state)
{
    air_light_desc desc = described(AIR_LIGHT_POINT);
    desc.color[1] = -1.0f;
    expect_bad(*state, &desc, "color[1] is -1");
    desc.color[1] = NAN;
    expect_bad(*state, &desc, "color[1]");
    desc = described(AIR_LIGHT_POINT);
    desc.position[2] = INFINITY;
    expect_bad(*state, &desc, "position[2]");
    desc = described(AIR_LIGHT_SPOT);
    desc.dir[1] = 0.0f;
    expect_bad(*state, &desc, "dir is (0, 0, 0)");
    desc = described(AIR_LIGHT_COLLIMATED);
    desc.dir[0] = NAN;
    expect_bad(*state, &desc, "dir[0]");
    desc = described((air_light_kind)7);
    expect_bad(*state, &desc, "kind is 7");
}

static void cones_must_be_in_order(void **state)
{
    const float cones[][2] = {{0.5f, 0.5f}, {0.6f, 0.5f}, {-0.1f, 0.5f}, {0.1f, 1.6f}, {0.1f, NAN}};
    for (int i = 0; i < 5; i++) {
        air_light_desc desc = described(AIR_LIGHT_SPOT);
        desc.inner_cone_rad = cones[i][0];
        desc.outer_cone_rad = cones[i][1];
        expect_bad(*state, &desc, "outer_cone_rad");
    }
    air_light_desc widest = described(AIR_LIGHT_SPOT);
    widest.outer_cone_rad = 1.57079637f; /* pi/2 as a float */
    assert_int_equal(air_light_check(*state, &widest), AIR_OK);
}

static void polygons_without_area_are_refused(void **state)
{
    const float line[] = {1, 2, 3, 2, 4, 6, 3, 6, 9, 4, 8, 12};
    air_light_desc desc = polygon(line, 4);
    expect_bad(*state, &desc, "no area");
    const float point[9] = {1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000};
    desc = polygon(point, 3);
    expect_bad(*state, &desc, "no area");
    desc = polygon(line, 2);
    expect_bad(*state, &desc, "vertices: there are 2");
    desc = polygon(NULL, 3);
    expect_bad(*state, &desc, "vertices must not be NULL");
    /* a strip of 10 m x 1 mm is thin, but a light */
    const float strip[12] = {5, 0, 0, 15, 0, 0, 15, 0.001f, 0, 5, 0.001f, 0};
    desc = polygon(strip, 4);
    assert_int_equal(air_light_check(*state, &desc), AIR_OK);
}

static void polygons_must_be_planar_and_simple(void **state)
{
    const float bent[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0.1f, 0, 1, 0};
    air_light_desc desc = polygon(bent, 4);
    expect_bad(*state, &desc, "planar");
    const float nearly_flat[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0.001f, 0, 1, 0};
    desc = polygon(nearly_flat, 4);
    assert_int_equal(air_light_check(*state, &desc), AIR_OK);
    const float bow_tie[12] = {0, 0, 0, 2, 2, 0, 2, 0, 0, 0, 1, 0};
    desc = polygon(bow_tie, 4);
    expect_bad(*state, &desc, "edge from vertex 0 to 1 crosses another");
    /* two squares that touch at a corner, the second one run round the other way */
    const float touching[] = {0,    0,    0, 1, 0,    0, 1, 1, 0, 1.5f, 1, 0,
                              1.5f, 1.5f, 0, 1, 1.5f, 0, 1, 1, 0, 0,    1, 0};
    desc = polygon(touching, 8);
    assert_int_equal(air_light_check(*state, &desc), AIR_OK);
    const float folded[] = {0,    0,    0, 1,    0, 0, 1, 1, 0, 1, 1.5f, 0,
                            1.5f, 1.5f, 0, 1.5f, 1, 0, 1, 1, 0, 0, 1,    0};
    desc = polygon(folded, 8);
    expect_bad(*state, &desc, "folds over itself");
}

static void polygons_far_away_are_judged_alike(void **state)
{
    /* 1 m^2 at 10 km: float coordinates are good to 1 mm there */
    const float square[12] = {10000, 5000, -3000, 10001, 5000, -3000,
                              10001, 5000, -3001, 10000, 5000, -3001};
    const air_light_desc desc = polygon(square, 4);
    assert_int_equal(air_light_check(*state, &desc), AIR_OK);
}

static void bad_windows_are_named(void **state)
{
    const float good[12] = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1};
    const float bow_tie[12] = {0, 0, 0, 2, 0, 2, 2, 0, 0, 0, 0, 1};
    const float edge_on[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const float nan_vertex[9] = {0, 0, 0, 1, 0, NAN, 1, 0, 1};
    air_gobo_window windows[2] = {{good, 4}, {bow_tie, 4}};
    air_light_desc desc = described(AIR_LIGHT_COLLIMATED); /* along -Y */
    desc.windows = windows;
    desc.window_count = 2;
    expect_bad(*state, &desc, "windows[1].vertices: the edge from vertex 0");
    windows[1] = (air_gobo_window){edge_on, 4};
    expect_bad(*state, &desc, "windows[1].vertices: seen along the light");
    windows[1] = (air_gobo_window){nan_vertex, 3};
    expect_bad(*state, &desc, "windows[1].vertices[5]");
    windows[1] = (air_gobo_window){good, 1};
    expect_bad(*state, &desc, "windows[1].vertices: there are 1");
    desc.windows = NULL;
    expect_bad(*state, &desc, "windows must not be NULL");
}

static void environments_must_be_rotated_only(void **state)
{
    air_light_desc desc = described(AIR_LIGHT_ENVIRONMENT);
    desc.to_world[0] = -1.0f; /* mirrored */
    expect_bad(*state, &desc, "to_world must be a rotation");
    desc = described(AIR_LIGHT_ENVIRONMENT);
    desc.to_world[4] = 1.1f;
    expect_bad(*state, &desc, "to_world must be a rotation");
    desc.to_world[4] = NAN;
    expect_bad(*state, &desc, "to_world[4]");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_default_of_every_kind_without_arrays_is_sound),
        cmocka_unit_test(bad_numbers_are_named),
        cmocka_unit_test(cones_must_be_in_order),
        cmocka_unit_test(polygons_without_area_are_refused),
        cmocka_unit_test(polygons_must_be_planar_and_simple),
        cmocka_unit_test(polygons_far_away_are_judged_alike),
        cmocka_unit_test(bad_windows_are_named),
        cmocka_unit_test(environments_must_be_rotated_only),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}
