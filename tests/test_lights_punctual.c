#include "cmocka_test.h"
#include "core/random.h"
#include "core/warp.h"
#include "light_fixture.h"
#include "scene/lights/punctual.h"

static air_light shaped_spot(air_spot_shape shape, double inner, double outer)
{
    air_light light = {
        .kind = AIR_LIGHT_SPOT, .dir = {0.0f, 0.0f, 1.0f}, .color = {1.0f, 1.0f, 1.0f}};
    air_spot_set_cone(&light, shape, inner, outer);
    return light;
}

static air_light spot(double inner, double outer)
{
    return shaped_spot(AIR_SPOT_COSINE, inner, outer);
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

static void an_angular_spot_is_linear_in_the_angle(void **state)
{
    (void)state;
    const double inner = 0.3, outer = 0.7;
    const air_light light = shaped_spot(AIR_SPOT_ANGLE, inner, outer);
    for (int i = 0; i <= 80; i++) {
        const double angle = 0.01 * i;
        const double expected = fmin(fmax((outer - angle) / (outer - inner), 0.0), 1.0);
        /* a cosine in float leaves 2^-25 over the sine of the angle, times the slope 2.5 */
        const double got = (double)air_spot_falloff(&light, (float)cos(angle));
        assert_true(fabs(got - expected) < 1e-6 + (angle > 0.25 ? 5e-7 / sin(angle) : 0.0));
    }
    assert_true(air_spot_falloff(&light, -1.0f) == 0.0f);
    assert_true(fabs((double)air_spot_opening(&light) - (1.0 - cos(outer))) < 1e-6);
}

static void check_solid_angle(const air_light *light, double outer)
{
    enum { STEPS = 200000 };
    double sum = 0.0;
    const double range = 1.0 - cos(outer);
    for (int k = 0; k < STEPS; k++) {
        const double cosine = 1.0 - range * (k + 0.5) / STEPS;
        sum += 2.0 * AIR_PI * range / STEPS * (double)air_spot_falloff(light, (float)cosine);
    }
    /* the offset has 2^-24 of the scale, at most 1000, seen from a cone whose 1 - cos is 2e-4 */
    assert_true(fabs(air_spot_solid_angle(light) - sum) < 2e-3 * sum);
}

static void spot_solid_angle_is_the_integral_of_the_falloff(void **state)
{
    (void)state;
    const double cones[][2] = {{0.0, 0.5}, {0.3, 0.7}, {0.7, 0.71}, {0.0, 0.02}, {1.0, 1.5707963}};
    for (int i = 0; i < 5; i++) {
        for (int shape = AIR_SPOT_COSINE; shape <= AIR_SPOT_ANGLE; shape++) {
            const air_light light = shaped_spot((air_spot_shape)shape, cones[i][0], cones[i][1]);
            check_solid_angle(&light, cones[i][1]);
        }
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

/* ---- projectors ---- */

/* Four texels, two by two: red and green above, blue and white below. */
static air_texture four_texels(uint8_t texels[12])
{
    static const uint8_t values[12] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    memcpy(texels, values, sizeof values);
    return (air_texture){.width = 2,
                         .height = 2,
                         .channels = 3,
                         .bytes = texels,
                         .wrap_u = AIR_WRAP_REPEAT,
                         .wrap_v = AIR_WRAP_REPEAT,
                         .filter = AIR_TEXTURE_NEAREST};
}

/* At the place (x, y) of a screen at z = -5, from (1, 2, 3) along -Z. */
static air_vec3 on_screen(const air_light_table *table, float x, float y)
{
    air_light_point point;
    air_connection c;
    const air_vec3 at = vec3(1.0f + x, 2.0f + y, -5.0f);
    air_light_sample(table, 0, 0.5f, 0.5f, &point);
    if (!air_light_connect(table, &point, at, &c)) {
        return vec3_set1(0.0f);
    }
    return vec3_scale(c.incident, -vec3_dot(c.dir, vec3(0.0f, 0.0f, -1.0f)));
}

static void a_projector_lights_a_screen_evenly_with_its_picture(void **state)
{
    uint8_t texels[12];
    const air_texture picture = four_texels(texels);
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.kind = AIR_LIGHT_PROJECTOR;
    desc.color[0] = desc.color[1] = desc.color[2] = 128.0f;
    desc.position[0] = 1.0f;
    desc.position[1] = 2.0f;
    desc.position[2] = 3.0f;
    desc.fov_x_rad = 2.0f * atanf(0.5f); /* 4 metres to each side */
    air_light_table table = table_of_one(*state, &desc, &picture);
    /* 128 / 8^2 = 2, whatever the angle */
    const float places[4][2] = {{-3.9f, 3.9f}, {0.1f, 0.1f}, {-2.0f, -1.0f}, {3.0f, -3.9f}};
    for (int i = 0; i < 4; i++) {
        const air_vec3 e = on_screen(&table, places[i][0], places[i][1]);
        assert_true(fabsf(e.x - 2.0f * (float)texels[3 * i] / 255.0f) < 2e-6f);
        assert_true(fabsf(e.y - 2.0f * (float)texels[3 * i + 1] / 255.0f) < 2e-6f);
        assert_true(fabsf(e.z - 2.0f * (float)texels[3 * i + 2] / 255.0f) < 2e-6f);
    }
    assert_true(vec3_is_zero(on_screen(&table, 4.1f, 0.0f)));
    assert_true(vec3_is_zero(on_screen(&table, 0.0f, -4.1f)));
    air_light_point point;
    air_connection c;
    air_light_sample(&table, 0, 0.5f, 0.5f, &point);
    assert_true(point.delta && !point.infinite);
    assert_false(air_light_connect(&table, &point, vec3(1.0f, 2.0f, 9.0f), &c));
    air_light_table_finish(*state, &table);
}

static void the_flux_of_a_projector_is_what_its_screen_gets(void **state)
{
    uint8_t texels[12];
    const air_texture picture = four_texels(texels);
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.kind = AIR_LIGHT_PROJECTOR;
    desc.fov_x_rad = 1.0f;
    air_light_table table = table_of_one(*state, &desc, &picture);
    /* half of each colour on a square of 2 tan(1/2) at the distance 1 */
    const float side = 2.0f * tanf(0.5f);
    const air_vec3 got = air_projector_solid_angle(&table.entries[0]);
    assert_true(fabsf(got.x - 0.5f * side * side) < 1e-5f && fabsf(got.z - got.x) < 1e-5f);
    air_light_table_finish(*state, &table);
    desc.fov_x_rad = 3.2f;
    assert_int_equal(air_light_check(*state, &desc), AIR_ERROR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spot_is_full_inside_dark_outside_and_squared_between),
        cmocka_unit_test(spot_solid_angle_is_the_integral_of_the_falloff),
        cmocka_unit_test(an_angular_spot_is_linear_in_the_angle),
        cmocka_unit_test(a_projector_lights_a_screen_evenly_with_its_picture),
        cmocka_unit_test(the_flux_of_a_projector_is_what_its_screen_gets),
        cmocka_unit_test(point_light_falls_off_with_the_square),
        cmocka_unit_test(spot_shines_along_its_direction),
        cmocka_unit_test(light_passes_inside_windows_only),
        cmocka_unit_test(window_area_is_measured_across_the_light),
    };
    return cmocka_run_group_tests(tests, make_context, destroy_context);
}
