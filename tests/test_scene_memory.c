/* Scenes when memory runs out at any allocation: an error, nothing lost, and the same call works
 * once there is memory. */
#include <limits.h>

#include "failing_allocator.h"
#include "scene_fixture.h"

/* What the steps below work on. */
typedef struct workshop {
    air_scene *scene;
    air_handle texture, grid, material, mesh, medium, light, camera;
    air_snapshot *first, *second;
} workshop;

static air_status add_texture(workshop *w)
{
    const float floats[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    const air_texture_desc desc = {
        .name = "sky", .width = 4, .height = 1, .channels = 4, .floats = floats};
    return air_scene_add_texture(w->scene, &desc, &w->texture);
}

static air_status add_grid(workshop *w)
{
    const float values[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    const air_grid_desc desc = {.name = "plume",
                                .size = {2, 2, 2},
                                .channels = 1,
                                .values = values,
                                .index_to_local = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    return air_scene_add_grid(w->scene, &desc, &w->grid);
}

static air_status add_material(workshop *w)
{
    air_material_desc desc;
    air_material_desc_default(&desc);
    desc.name = "glowing";
    desc.emission[0] = 1.0f;
    desc.base_color_texture.texture = w->texture;
    return air_scene_add_material(w->scene, &desc, &w->material);
}

static air_mesh_desc square_of(const workshop *w)
{
    static const float normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const float tangents[16] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    air_mesh_desc desc = fixture_square("square");
    desc.normals = normals;
    desc.tangents = tangents;
    desc.colors = tangents;
    desc.material = w->material;
    desc.to_world[3] = 1.0f;
    return desc;
}

static air_status add_mesh(workshop *w)
{
    const air_mesh_desc desc = square_of(w);
    return air_scene_add_mesh(w->scene, &desc, &w->mesh);
}

static air_status add_medium(workshop *w)
{
    const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    air_medium_desc desc;
    air_medium_desc_default(&desc);
    desc.name = "smoke";
    desc.sigma_s[0] = 1.0f;
    desc.density.kind = AIR_DENSITY_GRID;
    desc.density.grid = w->grid;
    desc.boundary.kind = AIR_BOUNDARY_MESH;
    desc.boundary.positions = positions;
    desc.boundary.vertex_count = 4;
    desc.boundary.indices = indices;
    desc.boundary.triangle_count = 4;
    return air_scene_add_medium(w->scene, &desc, &w->medium);
}

static air_status add_light(workshop *w)
{
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.name = "environment";
    desc.kind = AIR_LIGHT_ENVIRONMENT;
    desc.color[0] = 1.0f;
    desc.image = w->texture;
    return air_scene_add_light(w->scene, &desc, &w->light);
}

static air_status add_gobo(workshop *w)
{
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 0, 1};
    const air_gobo_window windows[2] = {{corners, 3}, {corners, 3}};
    air_light_desc desc;
    air_handle handle;
    air_light_desc_default(&desc);
    desc.name = "sun";
    desc.kind = AIR_LIGHT_COLLIMATED;
    desc.color[0] = 1.0f;
    desc.windows = windows;
    desc.window_count = 2;
    return air_scene_add_light(w->scene, &desc, &handle);
}

static air_status add_words(workshop *w)
{
    const air_status status =
        air_scene_set_source(w->scene, "room.glb", AIR_UNITS_RADIOMETRIC, AIR_UNITS_RADIOMETRIC);
    return status == AIR_OK ? air_scene_add_warning(w->scene, "something") : status;
}

static air_status commit_first(workshop *w) { return air_scene_commit(w->scene, &w->first, NULL); }

static air_status move_mesh(workshop *w)
{
    air_mesh_desc desc = square_of(w);
    desc.to_world[7] = 1.0f;
    return air_scene_set_mesh(w->scene, w->mesh, &desc);
}

static air_status add_camera(workshop *w)
{
    air_camera_desc desc;
    air_camera_desc_default(&desc);
    return air_scene_add_camera(w->scene, &desc, &w->camera);
}

static air_status commit_second(workshop *w)
{
    return air_scene_commit(w->scene, &w->second, NULL);
}

static air_status (*const steps[])(workshop *) = {
    add_texture, add_grid,     add_material, add_mesh,  add_medium, add_light,
    add_gobo,    commit_first, add_words,    move_mesh, add_camera, commit_second};
enum { STEP_COUNT = sizeof steps / sizeof *steps };

/* Runs all steps with `remaining` allocations; returns whether they sufficed. */
static bool run_with(long remaining)
{
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, LONG_MAX);
    air_context *context = NULL;
    workshop w = {.scene = NULL};
    bool sufficed = true;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_int_equal(air_scene_create(context, &w.scene), AIR_OK);
    atomic_store(&allocator.remaining, remaining);
    for (size_t i = 0; i < STEP_COUNT; ++i) {
        air_status status = steps[i](&w);
        if (status != AIR_OK) {
            assert_true(sufficed); /* it fails once, then there is memory again */
            assert_int_equal(status, AIR_ERROR_MEMORY);
            sufficed = false;
            atomic_store(&allocator.remaining, LONG_MAX);
            status = steps[i](&w);
        }
        assert_int_equal(status, AIR_OK);
    }
    /* the same scene, however it came about */
    air_scene_info info;
    air_snapshot_info(w.second, &info);
    assert_int_equal(info.triangle_count, 2);
    assert_int_equal(info.light_count, 2);
    assert_int_equal(info.emissive_triangle_count, 2);
    assert_int_equal(info.medium_count, 1);
    air_scene_destroy(w.scene);
    air_snapshot_release(w.first);
    air_snapshot_release(w.second);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
    return sufficed;
}

static void every_allocation_may_fail(void **state)
{
    long n = 0;
    (void)state;
    while (!run_with(n))
        ++n;
    assert_true(n > 100); /* the steps do allocate */
}

static void a_scene_that_cannot_be_created_is_null(void **state)
{
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, LONG_MAX);
    air_context *context = NULL;
    air_scene *scene = (air_scene *)&allocator;
    (void)state;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    atomic_store(&allocator.remaining, 0);
    assert_int_equal(air_scene_create(context, &scene), AIR_ERROR_MEMORY);
    assert_null(scene);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(a_scene_that_cannot_be_created_is_null),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
