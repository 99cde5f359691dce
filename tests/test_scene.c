/* Editing scenes: handles, references between objects, copies, and what is refused. */
#include <math.h>

#include "scene/snapshot.h"
#include "scene_fixture.h"

static air_handle add_square(air_scene *scene, const char *name, air_handle material)
{
    air_mesh_desc desc = fixture_square(name);
    air_handle handle = AIR_NONE;
    desc.material = material;
    assert_int_equal(air_scene_add_mesh(scene, &desc, &handle), AIR_OK);
    return handle;
}

static air_handle add_material(air_scene *scene, const char *name, air_handle texture)
{
    air_material_desc desc;
    air_handle handle = AIR_NONE;
    air_material_desc_default(&desc);
    desc.name = name;
    desc.base_color_texture.texture = texture;
    assert_int_equal(air_scene_add_material(scene, &desc, &handle), AIR_OK);
    return handle;
}

static air_handle add_texture(air_scene *scene, const char *name)
{
    const uint8_t bytes[3] = {1, 2, 3};
    const air_texture_desc desc = {
        .name = name, .width = 1, .height = 1, .channels = 3, .bytes = bytes};
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_texture(scene, &desc, &handle), AIR_OK);
    return handle;
}

static air_handle add_grid(air_scene *scene, const char *name)
{
    const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    const air_grid_desc desc = {.name = name,
                                .size = {2, 2, 2},
                                .channels = 1,
                                .values = values,
                                .index_to_local = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    air_handle handle = AIR_NONE;
    assert_int_equal(air_scene_add_grid(scene, &desc, &handle), AIR_OK);
    return handle;
}

static air_medium_desc haze(const char *name)
{
    air_medium_desc desc;
    air_medium_desc_default(&desc);
    desc.name = name;
    desc.sigma_s[0] = desc.sigma_s[1] = desc.sigma_s[2] = 0.1f;
    return desc;
}

/* ---- handles ---- */

static void handles_are_never_used_twice(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    (void)state;
    const air_handle first = add_square(scene, "first", AIR_NONE);
    const air_handle second = add_square(scene, "second", AIR_NONE);
    assert_int_equal(air_scene_remove(scene, second), AIR_OK);
    const air_handle third = add_square(scene, "third", AIR_NONE);
    assert_true(first != second && second != third && first != third);
    assert_int_equal(air_scene_remove(scene, second), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "names nothing");
    assert_int_equal(air_scene_remove(scene, AIR_NONE), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_remove(scene, 0xffffffffu), AIR_ERROR_ARGUMENT);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void handles_survive_the_removal_of_others(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_handle handles[20];
    (void)state;
    for (int i = 0; i < 20; ++i)
        handles[i] = add_material(scene, "m", AIR_NONE);
    for (int i = 0; i < 20; i += 2)
        assert_int_equal(air_scene_remove(scene, handles[i]), AIR_OK);
    for (int i = 1; i < 20; i += 2) {
        air_material_desc desc;
        air_material_desc_default(&desc);
        desc.metallic = (float)i / 20.0f;
        assert_int_equal(air_scene_set_material(scene, handles[i], &desc), AIR_OK);
    }
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    assert_int_equal(snapshot->material_count, 11);
    for (int i = 0; i < 10; ++i)
        assert_true(snapshot->materials[1 + i].metallic == (float)(2 * i + 1) / 20.0f);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void handles_of_another_kind_are_refused_by_name(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_mesh_desc mesh = fixture_square("floor");
    air_material_desc material;
    air_handle handle = 5;
    (void)state;
    const air_handle wood = add_texture(scene, "wood");
    mesh.material = wood;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "mesh \"floor\": material has to be a handle of a material");
    fixture_expect_message(context, "names the texture \"wood\"");
    assert_int_equal(handle, 5);
    air_material_desc_default(&material);
    assert_int_equal(air_scene_set_material(scene, wood, &material), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "names the texture \"wood\"");
    mesh.material = AIR_NONE;
    assert_int_equal(air_scene_set_mesh(scene, AIR_NONE, &mesh), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "is AIR_NONE");

    air_medium_desc medium = haze("smoke");
    medium.density.kind = AIR_DENSITY_GRID;
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "medium \"smoke\": density.grid has to be a handle of a grid");
    medium.density.grid = wood;
    assert_int_equal(air_scene_add_medium(scene, &medium, &handle), AIR_ERROR_ARGUMENT);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* ---- references ---- */

static void what_is_referred_to_cannot_be_removed(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_handle medium, light;
    (void)state;
    const air_handle texture = add_texture(scene, "wood"), image = add_texture(scene, "sky");
    const air_handle material = add_material(scene, "table", texture);
    const air_handle mesh = add_square(scene, "top", material);
    air_medium_desc smoke = haze("smoke");
    smoke.density.kind = AIR_DENSITY_GRID;
    smoke.density.grid = add_grid(scene, "plume");
    assert_int_equal(air_scene_add_medium(scene, &smoke, &medium), AIR_OK);
    air_light_desc sky;
    air_light_desc_default(&sky);
    sky.kind = AIR_LIGHT_ENVIRONMENT;
    sky.color[0] = sky.color[1] = sky.color[2] = 1.0f;
    sky.image = image;
    assert_int_equal(air_scene_add_light(scene, &sky, &light), AIR_OK);

    const air_handle used[] = {texture, image, material, smoke.density.grid};
    const char *const messages[] = {"texture \"wood\": cannot be removed",
                                    "texture \"sky\": cannot", "material \"table\": cannot",
                                    "grid \"plume\": cannot"};
    for (size_t i = 0; i < 4; ++i) {
        assert_int_equal(air_scene_remove(scene, used[i]), AIR_ERROR_ARGUMENT);
        fixture_expect_message(context, messages[i]);
    }
    const air_handle order[] = {light, image, medium, smoke.density.grid, mesh, material, texture};
    for (size_t i = 0; i < 7; ++i)
        assert_int_equal(air_scene_remove(scene, order[i]), AIR_OK);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void replacing_moves_the_references(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    (void)state;
    const air_handle red = add_material(scene, "red", AIR_NONE);
    const air_handle blue = add_material(scene, "blue", AIR_NONE);
    const air_handle mesh = add_square(scene, "wall", red);
    air_mesh_desc desc = fixture_square("wall");
    desc.material = blue;
    assert_int_equal(air_scene_set_mesh(scene, mesh, &desc), AIR_OK);
    assert_int_equal(air_scene_remove(scene, red), AIR_OK);
    assert_int_equal(air_scene_remove(scene, blue), AIR_ERROR_ARGUMENT);
    /* what fails changes nothing */
    desc.material = red;
    assert_int_equal(air_scene_set_mesh(scene, mesh, &desc), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_remove(scene, blue), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_remove(scene, mesh), AIR_OK);
    assert_int_equal(air_scene_remove(scene, blue), AIR_OK);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void a_scene_holds_64_media(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const air_medium_desc desc = haze("layer");
    air_handle handle;
    (void)state;
    for (int i = 0; i < AIR_MAX_MEDIA; ++i)
        assert_int_equal(air_scene_add_medium(scene, &desc, &handle), AIR_OK);
    assert_int_equal(air_scene_add_medium(scene, &desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "medium \"layer\": a scene can have at most 64 media");
    assert_int_equal(air_scene_remove(scene, handle), AIR_OK);
    assert_int_equal(air_scene_add_medium(scene, &desc, &handle), AIR_OK);
    air_snapshot_release(fixture_commit(scene, NULL));
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* ---- copies ---- */

static void descriptions_are_copied_deeply(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    (void)state;
    char name[] = "wall";
    float positions[12], window[9] = {0, 0, 0, 1, 0, 0, 0, 0, 1};
    uint32_t indices[6];
    air_handle handle;
    memcpy(positions, fixture_square_positions, sizeof positions);
    memcpy(indices, fixture_square_indices, sizeof indices);
    air_mesh_desc mesh = fixture_square(name);
    mesh.positions = positions;
    mesh.indices = indices;
    assert_int_equal(air_scene_add_mesh(scene, &mesh, &handle), AIR_OK);
    air_gobo_window windows[1] = {{window, 3}};
    air_light_desc sun;
    air_light_desc_default(&sun);
    sun.name = name;
    sun.kind = AIR_LIGHT_COLLIMATED;
    sun.color[0] = 1.0f;
    sun.windows = windows;
    sun.window_count = 1;
    assert_int_equal(air_scene_add_light(scene, &sun, &handle), AIR_OK);
    float planes[16] = {1, 0, 0, 1, -1, 0, 0, 1, 0, 1, 0, 1, 0, -1, 0, 1};
    air_medium_desc slab = haze(name);
    slab.boundary.kind = AIR_BOUNDARY_CONVEX;
    slab.boundary.planes = planes;
    slab.boundary.plane_count = 4;
    assert_int_equal(air_scene_add_medium(scene, &slab, &handle), AIR_OK);

    memset(name, 'x', sizeof name - 1);
    memset(positions, 0xff, sizeof positions);
    memset(indices, 0xff, sizeof indices);
    memset(window, 0xff, sizeof window);
    memset(windows, 0xff, sizeof windows);
    memset(planes, 0xff, sizeof planes);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    assert_string_equal(snapshot->meshes[0]->name, "wall");
    assert_memory_equal(snapshot->meshes[0]->positions, fixture_square_positions, sizeof positions);
    assert_memory_equal(snapshot->meshes[0]->indices, fixture_square_indices, sizeof indices);
    assert_string_equal(snapshot->media.media[0].name, "wall");
    assert_string_equal(snapshot->lights.entries[0].name, "wall");
    assert_true(air_light_in_windows(&snapshot->lights.entries[0], vec3(0.2f, 5.0f, 0.2f)));
    assert_false(air_light_in_windows(&snapshot->lights.entries[0], vec3(0.8f, 5.0f, 0.8f)));
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* ---- checks ---- */

static void expect_mesh_refused(const air_mesh_desc *desc, const char *message)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_handle handle = 5;
    assert_int_equal(air_scene_add_mesh(scene, desc, &handle), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, message);
    assert_int_equal(handle, 5);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void bad_meshes_are_refused_by_vertex_and_triangle(void **state)
{
    float values[16] = {0};
    const uint32_t indices[6] = {0, 1, 2, 0, 912, 3};
    air_mesh_desc desc = fixture_square("floor");
    (void)state;
    desc.indices = indices;
    expect_mesh_refused(&desc,
                        "mesh \"floor\": index 1 of triangle 1 is 912, but there are 4 vertices");
    desc = fixture_square(NULL);
    values[7] = NAN;
    desc.positions = values;
    expect_mesh_refused(&desc, "unnamed mesh: position of vertex 2 is");
    desc = fixture_square("floor");
    desc.normals = values;
    expect_mesh_refused(&desc, "normal of vertex 2 is");
    desc.normals = NULL;
    desc.tangents = values;
    expect_mesh_refused(&desc, "tangent of vertex 1 is");
    desc.tangents = NULL;
    desc.uv[1] = values;
    expect_mesh_refused(&desc, "uv[1] of vertex 3 is");
    desc.uv[1] = NULL;
    desc.colors = values;
    expect_mesh_refused(&desc, "color of vertex 1 is");
    desc.colors = NULL;
    desc.to_world[5] = 0.0f;
    expect_mesh_refused(&desc, "to_world is singular");
    desc.to_world[5] = INFINITY;
    expect_mesh_refused(&desc, "to_world[5] is inf, but must be finite");
    desc = fixture_square("floor");
    desc.triangle_count = 0;
    expect_mesh_refused(&desc, "has no triangles");
    desc = fixture_square("floor");
    desc.positions = NULL;
    expect_mesh_refused(&desc, "has no positions");
}

static void bad_materials_are_refused_by_field(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_material_desc good;
    air_handle handle = 5;
    (void)state;
    air_material_desc_default(&good);
    good.name = "gold";
    good.normal_texture.texture = add_texture(scene, "bumps");
    air_material_desc bad[9];
    for (size_t i = 0; i < 9; ++i)
        bad[i] = good;
    bad[0].base_color[3] = 1.5f;
    bad[1].metallic = -0.1f;
    bad[2].roughness = NAN;
    bad[3].emission[1] = -1.0f;
    bad[4].ior = 0.5f;
    bad[5].alpha_mode = (air_alpha_mode)7;
    bad[6].normal_texture.uv_set = 2;
    bad[7].normal_texture.uv_transform[4] = INFINITY;
    bad[8].normal_texture.texture = 12345;
    const char *const parts[9] = {"base_color[3] is 1.5, but must be in [0, 1]",
                                  "metallic is -0.1",
                                  "roughness is",
                                  "emission[1] is -1, but must be finite and at least 0",
                                  "ior is 0.5",
                                  "alpha_mode is 7",
                                  "normal_texture.uv_set is 2",
                                  "normal_texture[4] is inf",
                                  "normal_texture has to be a handle of a texture"};
    for (size_t i = 0; i < 9; ++i) {
        assert_int_equal(air_scene_add_material(scene, &bad[i], &handle), AIR_ERROR_ARGUMENT);
        fixture_expect_message(context, "material \"gold\": ");
        fixture_expect_message(context, parts[i]);
        assert_int_equal(handle, 5);
    }
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void bad_textures_are_refused_by_field(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    const uint8_t bytes[4] = {0};
    const float floats[4] = {0, 0, NAN, 0};
    const air_texture_desc good = {
        .name = "t", .width = 1, .height = 1, .channels = 4, .bytes = bytes};
    air_texture_desc bad[5] = {good, good, good, good, good};
    air_handle handle = 5;
    (void)state;
    bad[0].width = 0;
    bad[1].channels = 5;
    bad[2].floats = floats;
    bad[3].bytes = NULL;
    bad[3].floats = floats;
    bad[4].wrap_v = (air_wrap)9;
    const char *const parts[5] = {"size is 0 x 1", "channels is 5",
                                  "exactly one of bytes and floats", "floats[2] is", "wrap_v is 9"};
    for (size_t i = 0; i < 5; ++i) {
        assert_int_equal(air_scene_add_texture(scene, &bad[i], &handle), AIR_ERROR_ARGUMENT);
        fixture_expect_message(context, parts[i]);
        assert_int_equal(handle, 5);
    }
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void missing_pointers_are_refused(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = NULL;
    air_handle handle;
    (void)state;
    assert_int_equal(air_scene_create(NULL, &scene), AIR_ERROR_ARGUMENT);
    assert_null(scene);
    scene = fixture_scene(context);
    assert_int_equal(air_scene_add_mesh(scene, NULL, &handle), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_set_light(scene, 1, NULL), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_load_grid(scene, NULL, NULL, &handle), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_remove(NULL, 1), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_commit(scene, NULL, NULL), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_load_grid(scene, "smoke.vdb", NULL, &handle), AIR_ERROR_UNSUPPORTED);
    fixture_expect_message(context, "smoke.vdb: grid files end in .nvdb or .vol");
    air_scene_destroy(scene);
    air_scene_destroy(NULL);
    air_snapshot_release(NULL);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(handles_are_never_used_twice),
        cmocka_unit_test(handles_survive_the_removal_of_others),
        cmocka_unit_test(handles_of_another_kind_are_refused_by_name),
        cmocka_unit_test(what_is_referred_to_cannot_be_removed),
        cmocka_unit_test(replacing_moves_the_references),
        cmocka_unit_test(a_scene_holds_64_media),
        cmocka_unit_test(descriptions_are_copied_deeply),
        cmocka_unit_test(bad_meshes_are_refused_by_vertex_and_triangle),
        cmocka_unit_test(bad_materials_are_refused_by_field),
        cmocka_unit_test(bad_textures_are_refused_by_field),
        cmocka_unit_test(missing_pointers_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
