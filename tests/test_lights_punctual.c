#include "cmocka_test.h"
#include "core/random.h"
#include "core/warp.h"
#include "light_fixture.h"
#include "scene/lights/punctual.h"

static air_light spot(double inner, double outer)
{
    air_light light = {
        .kind = AIR_LIGHT_SPOT, .dir = {0.0f, 0.0f, 1.0f}, .color = {1.0f, 1.0f, 1.0f}};
    air_spot_set_cone(&light, inner, outer);
    return light;
}

static void spot_is_full_inside_dark_outside_and_squared_between(void **state)
{
    (void)state;
    const double inner = 0.3, outer = 0.7;
    const air_light light = spot(inner, outer);
    assert_true(air_spot_falloff(&light, 1.0f) == 1.0f);
    assert_true(air_spot_falloff(&light, (float)cos(inner - 0.01)) == 1.0f);
    assert_true(air_spot_falloff(&light, (float)cos(outer + 0.01)) == 0.0f);
    assert_true(air_spot_falloff(&light, -1.0f) == 0.0f);
    /* halfway in the cosine: (1/2)^2 */
    const float half = (float)(0.5 * (cos(inner) + cos(outer)));
    assert_true(fabsf(air_spot_falloff(&light, half) - 0.25f) < 1e-5f); /* scale 5 times 2^-24 */
}

static void spot_solid_angle_is_the_integral_of_the_falloff(void **state)
{
    (void)state;
    const double cones[][2] = {{0.0, 0.5}, {0.3, 0.7}, {0.7, 0.71}, {0.0, 0.02}, {1.0, 1.5707963}};
    for (int i = 0; i < 5; i++) {
        const air_light light = spot(cones[i][0], cones[i][1]);
        enum { STEPS = 200000 };
        double sum = 0.0;
        const double range = 1.0 - cos(cones[i][1]);
        for (int k = 0; k < STEPS; k++) {
            const double cosine = 1.0 - range * (k + 0.5) / STEPS;
            sum += 2.0 * AIR_PI * range / STEPS * (double)air_spot_falloff(&light, (float)cosine);
        }
        /* the offset has 2^-24 of the scale, at most 1000, seen from a cone whose 1 - cos is 2e-4
         */
        const double solid_angle = air_spot_solid_angle(&light);
        assert_true(fabs(solid_angle - sum) < 2e-3 * sum);
    }
}

static void point_light_falls_off_with_the_square(void **state)
{
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.color[0] = desc.color[1] = desc.color[2] = 5.0f;
    desc.position[0] = 1.0f;
    air_light_table table = table_of_one(*state, &desc, NULL);
    air_light_point point;
    air_connection c;
    air_light_sample(&table, 0, 0.2f, 0.7f, &point);
    assert_true(point.delta && !point.infinite && point.pdf == 1.0f);
    assert_true(air_light_connect(&table, &point, vec3(1.0f, 0.0f, 3.0f), &c));
    assert_true(c.distance == 3.0f && c.pdf == 1.0f && c.dir.z == -1.0f);
    assert_true(fabsf(c.incident.x - 5.0f / 9.0f) < 1e-7f);
    assert_false(air_light_connect(&table, &point, vec3(1.0f, 0.0f, 0.0f), &c));
    air_light_table_finish(*state, &table);
}

static void spot_shines_along_its_direction(void **state)
{
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.kind = AIR_LIGHT_SPOT;
    desc.color[0] = 4.0f;
    desc.dir[0] = 2.0f;
    desc.dir[1] = 0.0f;
    air_light_table table = table_of_one(*state, &desc, NULL);
    air_light_point point;
    air_connection c;
    air_light_sample(&table, 0, 0.2f, 0.7f, &point);
    assert_true(air_light_connect(&table, &point, vec3(2.0f, 0.0f, 0.0f), &c));
    assert_true(fabsf(c.incident.x - 1.0f) < 1e-6f);
    assert_false(air_light_connect(&table, &point, vec3(-2.0f, 0.0f, 0.0f), &c));
    assert_false(air_light_connect(&table, &point, vec3(1.0f, 1.1f, 0.0f), &c));
    air_light_table_finish(*state, &table);
}

/* ---- windows ---- */

/* A C with an opening to the right and, above it, a square that overlaps its upper arm; both in the
 * plane z = 5. */
static const float C_SHAPE[] = {0, 0, 5, 3, 0, 5, 3, 1, 5, 1, 1, 5,
                                1, 2, 5, 3, 2, 5, 3, 3, 5, 0, 3, 5};
static const float SQUARE[] = {2, 2.5f, 5, 4, 2.5f, 5, 4, 4, 5, 2, 4, 5};

static bool in_c(float x, float y)
{
    return x > 0.0f && x < 3.0f && y > 0.0f && y < 3.0f && !(x > 1.0f && y > 1.0f && y < 2.0f);
}

static bool in_square(float x, float y) { return x > 2.0f && x < 4.0f && y > 2.5f && y < 4.0f; }

static void light_passes_inside_windows_only(void **state)
{
    const air_gobo_window windows[2] = {{C_SHAPE, 8}, {SQUARE, 4}};
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.kind = AIR_LIGHT_COLLIMATED;
    desc.color[1] = 7.0f;
    desc.dir[0] = 1.0f; /* the light comes in slantwise */
    desc.dir[1] = 0.5f;
    desc.dir[2] = -2.0f;
    desc.windows = windows;
    desc.window_count = 2;
    air_light_table table = table_of_one(*state, &desc, NULL);
    air_rng rng = air_rng_from_keys(5, 1);
    size_t open_count = 0;
    for (int i = 0; i < 20000; i++) {
        const float x = 6.0f * air_rng_float(&rng) - 1.0f, y = 6.0f * air_rng_float(&rng) - 1.0f;
        const float along = 20.0f * air_rng_float(&rng) - 10.0f; /* before and behind the window */
        const air_vec3 p = vec3_madd(vec3(x, y, 5.0f), along, vec3_load(desc.dir));
        const float edge_x = fabsf(x - roundf(x)), edge_y = fabsf(2.0f * y - roundf(2.0f * y));
        if (edge_x < 1e-4f || edge_y < 1e-4f) {
            continue; /* rounding of coordinates up to 30 */
        }
        const bool expected = in_c(x, y) || in_square(x, y);
        open_count += expected;
        air_light_point point;
        air_connection c;
        air_light_sample(&table, 0, 0.1f, 0.9f, &point);
        assert_true(point.infinite && point.delta);
        assert_true(air_light_connect(&table, &point, p, &c) == expected);
        assert_true(air_light_in_windows(&table.entries[0], p) == expected);
        if (expected) {
            assert_true(isinf(c.distance) && c.incident.y == 7.0f && c.pdf == 1.0f);
            assert_true(fabsf(vec3_dot(c.dir, vec3_normalize(vec3_load(desc.dir))) + 1.0f) < 1e-6f);
        }
    }
    assert_true(open_count > 3000);
    air_light_table_finish(*state, &table);
}

static void window_area_is_measured_across_the_light(void **state)
{
    const air_gobo_window window = {C_SHAPE, 8};
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.kind = AIR_LIGHT_COLLIMATED;
    desc.dir[0] = 0.0f;
    desc.dir[1] = -1.0f;
    desc.dir[2] = -1.0f;
    desc.windows = &window;
    desc.window_count = 1;
    air_light_table table = table_of_one(*state, &desc, NULL);
    /* 7 m^2 seen under 45 degrees */
    assert_true(fabs(air_windows_area(&table.entries[0]) - 7.0 * sqrt(0.5)) < 1e-5);
    air_light_table_finish(*state, &table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spot_is_full_inside_dark_outside_and_squared_between),
        cmocka_unit_test(spot_solid_angle_is_the_integral_of_the_falloff),
        cmocka_unit_test(point_light_falls_off_with_the_square),
        cmocka_unit_test(spot_shines_along_its_direction),
        cmocka_unit_test(light_passes_inside_windows_only),
        cmocka_unit_test(window_area_is_measured_across_the_light),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}
