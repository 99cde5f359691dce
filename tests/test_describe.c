/* The description of a snapshot as JSON. */
#include <jansson.h>
#include <math.h>
#include <stdlib.h>

#include "airlight/render.h"
#include "scene_fixture.h"

static json_t *describe(air_scene *scene)
{
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    size_t size = 0;
    assert_int_equal(air_snapshot_describe(snapshot, NULL, &size), AIR_OK);
    char *text = malloc(size);
    assert_non_null(text);
    const size_t needed = size;
    assert_int_equal(air_snapshot_describe(snapshot, text, &size), AIR_OK);
    assert_int_equal(size, needed);
    assert_int_equal(strlen(text) + 1, needed);
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    free(text);
    air_snapshot_release(snapshot);
    return root;
}

/* The member of an object inside an array. */
static const json_t *member(const json_t *root, const char *list, size_t index, const char *key)
{
    const json_t *value = json_object_get(json_array_get(json_object_get(root, list), index), key);
    if (value == NULL)
        fail_msg("no %s[%zu].%s", list, index, key);
    return value;
}

static void assert_text(const json_t *root, const char *list, size_t index, const char *key,
                        const char *text)
{
    assert_string_equal(json_string_value(member(root, list, index, key)), text);
}

static void add_room(air_scene *scene)
{
    air_material_desc material;
    air_mesh_desc mesh = fixture_square("panel");
    air_light_desc lamp;
    air_medium_desc haze;
    air_handle handle;
    air_material_desc_default(&material);
    material.name = "glow";
    material.emission[1] = 0.1f;
    assert_int_equal(air_scene_add_material(scene, &material, &mesh.material), AIR_OK);
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    mesh.name = "wall";
    mesh.material = AIR_NONE;
    mesh.casts_shadow = false;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    air_light_desc_default(&lamp);
    lamp.name = "lamp";
    lamp.color[0] = 3.0f;
    assert_int_equal(air_scene_add_light(scene, &lamp, &handle), AIR_OK);
    air_medium_desc_default(&haze);
    haze.name = "haze";
    haze.sigma_s[2] = 0.1f;
    haze.phase = (air_phase){.kind = AIR_PHASE_HG, .g = 0.3f};
    haze.boundary.kind = AIR_BOUNDARY_BOX;
    const float box[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5};
    memcpy(haze.boundary.box_to_world, box, sizeof box);
    assert_int_equal(air_scene_add_medium(scene, &haze, &handle), AIR_OK);
    assert_int_equal(
        air_scene_set_source(scene, "room.glb", AIR_UNITS_PHOTOMETRIC, AIR_UNITS_RADIOMETRIC),
        AIR_OK);
    assert_int_equal(air_scene_add_warning(scene, "no \"camera\" in the file"), AIR_OK);
}

static void everything_in_a_scene_is_described(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    (void)state;
    add_room(scene);
    json_t *root = describe(scene);
    assert_string_equal(json_string_value(json_object_get(root, "source")), "room.glb");
    assert_int_equal(json_integer_value(json_object_get(root, "triangles")), 4);
    assert_int_equal(json_integer_value(json_object_get(root, "emissive_triangles")), 2);
    const json_t *units = json_object_get(root, "units");
    assert_string_equal(json_string_value(json_object_get(units, "light")), "photometric");
    assert_string_equal(json_string_value(json_object_get(units, "emissive")), "radiometric");
    const json_t *top = json_object_get(json_object_get(root, "bounds"), "max");
    assert_true(fabs(json_number_value(json_array_get(top, 2)) - 6.0) < 1e-5);

    assert_text(root, "meshes", 0, "name", "panel");
    assert_text(root, "meshes", 0, "material", "glow");
    assert_true(json_is_true(member(root, "meshes", 0, "emits")));
    assert_true(json_is_false(member(root, "meshes", 1, "casts_shadow")));
    /* the decimal number, not the float's binary expansion */
    assert_true(json_real_value(json_array_get(member(root, "materials", 0, "emission"), 1)) ==
                0.1);
    assert_text(root, "lights", 0, "name", "lamp");
    assert_text(root, "lights", 0, "kind", "point");
    assert_text(root, "lights", 0, "units", "W/sr");
    assert_text(root, "lights", 1, "kind", "emissive");
    assert_text(root, "media", 0, "name", "haze");
    assert_text(root, "media", 0, "boundary", "box");
    assert_text(root, "media", 0, "density", "constant");
    const json_t *g = json_object_get(member(root, "media", 0, "phase"), "g");
    assert_true(json_real_value(g) == 0.3);
    assert_true(json_is_true(member(root, "cameras", 0, "frames_the_bounds")));
    assert_string_equal(json_string_value(json_array_get(json_object_get(root, "warnings"), 0)),
                        "no \"camera\" in the file");
    json_decref(root);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void every_light_medium_and_term_has_an_owner(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    (void)state;
    add_room(scene);
    json_t *root = describe(scene);
    /* two lights; M1 and M2 in one medium, the other terms once: six each */
    assert_int_equal(json_array_size(json_object_get(root, "owners")), 12);
    for (size_t i = 0; i < 12; ++i) {
        assert_text(root, "owners", i, "method", "path");
        assert_text(root, "owners", i, "light", i < 6 ? "lamp" : "emissive meshes");
        assert_int_equal(json_integer_value(member(root, "owners", i, "light_index")), i / 6);
        const bool in_media = json_is_string(member(root, "owners", i, "medium"));
        const char *term = json_string_value(member(root, "owners", i, "term"));
        assert_int_equal(in_media, term[0] == 'M');
    }
    json_decref(root);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void an_empty_scene_has_no_bounds(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    (void)state;
    json_t *root = describe(scene);
    assert_true(json_is_null(json_object_get(root, "bounds")));
    assert_int_equal(json_array_size(json_object_get(root, "owners")), 0);
    json_decref(root);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void names_that_are_not_utf8_are_shown_as_far_as_they_can(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc mesh = fixture_square("w\xffll \xc3\xa4");
    air_handle handle;
    (void)state;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    mesh.name = "\xc3\xa4";
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    json_t *root = describe(scene);
    assert_text(root, "meshes", 0, "name", "w?ll ??");
    assert_text(root, "meshes", 1, "name", "\xc3\xa4");
    json_decref(root);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void a_buffer_that_is_too_small_is_left_alone(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    char buffer[8] = "abcdefg";
    size_t size = sizeof buffer;
    (void)state;
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    assert_int_equal(air_snapshot_describe(snapshot, buffer, &size), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "the buffer has 8 bytes");
    assert_string_equal(buffer, "abcdefg");
    assert_int_equal(size, 8);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void lobes_of_mixtures_are_described(void **state)
{
    static const air_phase_mixture mixture = {
        2, {{AIR_PHASE_HG, 0.8f, 3.0f}, {AIR_PHASE_RAYLEIGH, 0.0f, 1.0f}}};
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_medium_desc haze;
    air_handle handle;
    (void)state;
    air_medium_desc_default(&haze);
    haze.sigma_s[0] = 0.1f;
    haze.phase = (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = &mixture};
    assert_int_equal(air_scene_add_medium(scene, &haze, &handle), AIR_OK);
    json_t *root = describe(scene);
    const json_t *phase = member(root, "media", 0, "phase");
    assert_string_equal(json_string_value(json_object_get(phase, "kind")), "mixture");
    assert_int_equal(json_array_size(json_object_get(phase, "lobes")), 2);
    assert_text(phase, "lobes", 0, "kind", "hg");
    assert_true(json_number_value(member(phase, "lobes", 0, "g")) == 0.8);
    assert_true(json_number_value(member(phase, "lobes", 0, "weight")) == 0.75);
    assert_text(phase, "lobes", 1, "kind", "rayleigh");
    json_decref(root);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_in_a_scene_is_described),
        cmocka_unit_test(lobes_of_mixtures_are_described),
        cmocka_unit_test(every_light_medium_and_term_has_an_owner),
        cmocka_unit_test(an_empty_scene_has_no_bounds),
        cmocka_unit_test(names_that_are_not_utf8_are_shown_as_far_as_they_can),
        cmocka_unit_test(a_buffer_that_is_too_small_is_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
