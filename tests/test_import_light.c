/* Punctual lights and cameras of a glTF file. */
#include <math.h>

#include "import_fixture.h"

#define LIT(light, node)                                                                           \
    "{" GLTF_SCENE ",'extensions':{'KHR_lights_punctual':{'lights':[{" light "}]}},'nodes':[{"     \
    "'extensions':{'KHR_lights_punctual':{'light':0}}" node "}]}"
#define SEEN(camera, node)                                                                         \
    "{" GLTF_SCENE ",'cameras':[{" camera "}],'nodes':[{'camera':0" node "}]}"

static const air_light *only_light(const import_fixture *f)
{
    assert_int_equal(f->snapshot->lights.explicit_count, 1);
    return &f->snapshot->lights.entries[0];
}

/* Relative, a few roundings of single precision. */
static void expect_near(float value, double expected)
{
    if (fabs((double)value - expected) > 1e-6 * fabs(expected) + 1e-7)
        fail_msg("%.9g is not %.9g", (double)value, expected);
}

static void a_point_light_is_divided_by_683(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, LIT("'type':'point','intensity':1366,'color':[1,0.5,0]",
                         ",'translation':[1,2,3],'scale':[9,9,9]"));
    const air_light *light = only_light(&f);
    assert_int_equal(light->kind, AIR_LIGHT_POINT);
    expect_near(light->color.x, 2.0);
    expect_near(light->color.y, 1.0);
    assert_true(light->color.z == 0.0f);
    assert_true(light->position.x == 1.0f && light->position.y == 2.0f &&
                light->position.z == 3.0f);
    assert_int_equal(f.snapshot->light_units, AIR_UNITS_PHOTOMETRIC);
    f.params.light_units = AIR_UNITS_RADIOMETRIC;
    import_loads(&f, LIT("'type':'point','intensity':1366", ""));
    expect_near(only_light(&f)->color.x, 1366.0);
    assert_int_equal(f.snapshot->light_units, AIR_UNITS_RADIOMETRIC);
    import_finish(&f);
}

static void blender_files_have_photometric_lights_too(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f,
        "{'asset':{'version':'2.0','generator':'Khronos glTF Blender I/O v4.0.44'},'extensions':{"
        "'KHR_lights_punctual':{'lights':[{'type':'point','intensity':683}]}},'nodes':[{"
        "'extensions':{'KHR_lights_punctual':{'light':0}}}]}");
    expect_near(only_light(&f)->color.x, 1.0);
    assert_int_equal(f.snapshot->light_units, AIR_UNITS_PHOTOMETRIC);
    assert_int_equal(f.snapshot->emissive_units, AIR_UNITS_RADIOMETRIC);
    import_finish(&f);
}

static void a_directional_light_travels_along_its_minus_z(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    /* a quarter turn about +X takes -Z to +Y... and about -X to -Y */
    import_loads(&f, LIT("'type':'directional','intensity':68300",
                         ",'rotation':[-0.70710678,0,0,0.70710678]"));
    const air_light *light = only_light(&f);
    assert_int_equal(light->kind, AIR_LIGHT_COLLIMATED);
    expect_near(light->color.x, 100.0);
    expect_near(light->dir.x, 0.0);
    expect_near(light->dir.y, -1.0);
    expect_near(light->dir.z, 0.0);
    import_finish(&f);
}

static void a_spot_light_keeps_its_cone(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f, LIT("'type':'spot','spot':{'innerConeAngle':0.25,'outerConeAngle':0.5},'range':3", ""));
    const air_light *light = only_light(&f);
    assert_int_equal(light->kind, AIR_LIGHT_SPOT);
    /* full inside the inner cone, dark outside the outer one */
    const double scale = 1.0 / (cos(0.25) - cos(0.5));
    assert_true(fabs((double)light->spot_scale - scale) < 1e-4 * scale);
    assert_true(fabs((double)light->spot_offset + cos(0.5) * scale) < 1e-4 * scale);
    import_expect(&f, AIR_MESSAGE_INFO,
                  "lights whose range is ignored: they fall off by distance alone: 1");
    import_expect_silence(&f, AIR_MESSAGE_WARNING);
    /* a hard edge and a half-space, as exporters write them in single precision */
    import_loads(&f, LIT("'type':'spot','spot':{'innerConeAngle':1.5707963705062866,'"
                         "outerConeAngle':1.5707963705062866}",
                         ""));
    import_finish(&f);
}

static void bad_lights_are_refused_with_their_place(void **state)
{
    (void)state;
    static const struct {
        const char *light, *message;
    } cases[] = {
        {"'type':'area'", "type: expected one of directional, point, spot, found \"area\""},
        {"'intensity':1", "type: expected a light type, found nothing"},
        {"'type':'point','intensity':-1", "intensity: expected a number >= 0, found -1"},
        {"'type':'point','color':[1,1]",
         "color: expected an array of 3 numbers, found an array of 2"},
        {"'type':'spot','spot':{'innerConeAngle':0.6,'outerConeAngle':0.5}",
         "spot.innerConeAngle: expected an angle below the outer one, found 0.6"},
        {"'type':'spot','spot':{'outerConeAngle':1.6}",
         "spot.outerConeAngle: expected an angle of at most pi/2, found 1.6"},
    };
    import_fixture f;
    import_init(&f);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[512];
        assert_int_equal(import_format(&f, LIT("%s", ""), cases[i].light), AIR_ERROR_FORMAT);
        snprintf(line, sizeof line, "room.gltf: $.extensions.KHR_lights_punctual.lights[0].%s\n",
                 cases[i].message);
        assert_string_equal(f.said[AIR_MESSAGE_ERROR], line);
    }
    import_finish(&f);
}

static void a_perspective_camera_stands_where_its_node_is(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(&f, SEEN("'name':'Data','type':'perspective','perspective':{'yfov':0.5,'znear':0."
                          "1,'aspectRatio':2}",
                          ",'name':'Camera','translation':[1,2,3],'scale':[2,2,2]"));
    assert_int_equal(f.snapshot->camera_count, 1);
    assert_true(f.snapshot->camera_in_file);
    const air_camera *camera = &f.snapshot->cameras[0];
    assert_string_equal(camera->name, "Camera");
    assert_int_equal(camera->kind, AIR_CAMERA_PERSPECTIVE);
    assert_true(camera->fov_y_rad == 0.5f && camera->aspect == 2.0f);
    const float expected[12] = {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3};
    for (size_t i = 0; i < 12; ++i)
        expect_near(camera->to_world[i], (double)expected[i]);
    import_finish(&f);
}

static void an_orthographic_camera_has_half_its_height(void **state)
{
    (void)state;
    import_fixture f;
    import_init(&f);
    import_loads(
        &f,
        SEEN("'type':'orthographic','orthographic':{'xmag':3,'ymag':1.5,'znear':0,'zfar':9}", ""));
    const air_camera *camera = &f.snapshot->cameras[0];
    assert_int_equal(camera->kind, AIR_CAMERA_ORTHOGRAPHIC);
    assert_true(camera->half_height == 1.5f && camera->aspect == 2.0f);
    import_finish(&f);
}

static void bad_cameras_are_refused_with_their_place(void **state)
{
    (void)state;
    static const struct {
        const char *camera, *message;
    } cases[] = {
        {"'type':'fisheye'", "type: expected one of perspective, orthographic, found \"fisheye\""},
        {"'type':'perspective'", "perspective: expected an object, found nothing"},
        {"'type':'perspective','perspective':{}",
         "perspective.yfov: expected an angle, found nothing"},
        {"'type':'perspective','perspective':{'yfov':4}",
         "perspective.yfov: expected an angle below pi, found 4"},
        {"'type':'orthographic','orthographic':{'xmag':1,'ymag':0}",
         "orthographic.ymag: expected a number > 0, found 0"},
    };
    import_fixture f;
    import_init(&f);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[512];
        assert_int_equal(import_format(&f, SEEN("%s", ""), cases[i].camera), AIR_ERROR_FORMAT);
        snprintf(line, sizeof line, "room.gltf: $.cameras[0].%s\n", cases[i].message);
        assert_string_equal(f.said[AIR_MESSAGE_ERROR], line);
    }
    import_finish(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_light_is_divided_by_683),
        cmocka_unit_test(blender_files_have_photometric_lights_too),
        cmocka_unit_test(a_directional_light_travels_along_its_minus_z),
        cmocka_unit_test(a_spot_light_keeps_its_cone),
        cmocka_unit_test(bad_lights_are_refused_with_their_place),
        cmocka_unit_test(a_perspective_camera_stands_where_its_node_is),
        cmocka_unit_test(an_orthographic_camera_has_half_its_height),
        cmocka_unit_test(bad_cameras_are_refused_with_their_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
