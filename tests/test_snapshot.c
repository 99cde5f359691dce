/* Commits: what is dirty, what is shared, bounds, framing, and life after the scene. */
#include <math.h>
#include <pthread.h>

#include "scene/media/grid.h"
#include "scene/snapshot.h"
#include "scene_fixture.h"

enum {
    ALL_DIRTY = AIR_DIRTY_CAMERA | AIR_DIRTY_LIGHT | AIR_DIRTY_MEDIUM | AIR_DIRTY_TRANSFORM |
                AIR_DIRTY_GEOMETRY | AIR_DIRTY_MATERIAL
};

/* A scene with one of each. */
typedef struct studio {
    air_context *context;
    air_scene *scene;
    air_handle texture, grey, glowing, wall, panel, haze, lamp, camera;
    air_material_desc grey_desc, glowing_desc;
    air_mesh_desc wall_desc, panel_desc;
    air_medium_desc haze_desc;
    air_light_desc lamp_desc;
    air_camera_desc camera_desc;
} studio;

static void describe_studio(studio *s)
{
    air_material_desc_default(&s->grey_desc);
    s->grey_desc.name = "grey";
    s->glowing_desc = s->grey_desc;
    s->glowing_desc.name = "glowing";
    s->glowing_desc.emission[0] = 2.0f;
    s->wall_desc = fixture_square("wall");
    s->panel_desc = fixture_square("panel");
    s->panel_desc.to_world[11] = 3.0f;
    air_medium_desc_default(&s->haze_desc);
    s->haze_desc.name = "haze";
    s->haze_desc.sigma_s[0] = s->haze_desc.sigma_s[1] = s->haze_desc.sigma_s[2] = 0.1f;
    s->haze_desc.boundary.kind = AIR_BOUNDARY_BOX;
    const float box[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
    memcpy(s->haze_desc.boundary.box_to_world, box, sizeof box);
    air_light_desc_default(&s->lamp_desc);
    s->lamp_desc.name = "lamp";
    s->lamp_desc.color[0] = s->lamp_desc.color[1] = s->lamp_desc.color[2] = 5.0f;
    air_camera_desc_default(&s->camera_desc);
    s->camera_desc.name = "camera";
}

static void open_studio(studio *s)
{
    const uint8_t white[3] = {255, 255, 255};
    const air_texture_desc texture = {
        .name = "white", .width = 1, .height = 1, .channels = 3, .bytes = white};
    s->context = fixture_context();
    s->scene = fixture_scene(s->context);
    describe_studio(s);
    assert_int_equal(air_scene_add_texture(s->scene, &texture, &s->texture), AIR_OK);
    s->grey_desc.base_color_texture.texture = s->texture;
    assert_int_equal(air_scene_add_material(s->scene, &s->grey_desc, &s->grey), AIR_OK);
    assert_int_equal(air_scene_add_material(s->scene, &s->glowing_desc, &s->glowing), AIR_OK);
    s->wall_desc.material = s->grey;
    s->panel_desc.material = s->glowing;
    assert_int_equal(air_scene_add_mesh(s->scene, &s->wall_desc, &s->wall), AIR_OK);
    assert_int_equal(air_scene_add_mesh(s->scene, &s->panel_desc, &s->panel), AIR_OK);
    assert_int_equal(air_scene_add_medium(s->scene, &s->haze_desc, &s->haze), AIR_OK);
    assert_int_equal(air_scene_add_light(s->scene, &s->lamp_desc, &s->lamp), AIR_OK);
    assert_int_equal(air_scene_add_camera(s->scene, &s->camera_desc, &s->camera), AIR_OK);
}

static void close_studio(studio *s)
{
    air_scene_destroy(s->scene);
    air_context_destroy(s->context);
}

static void set_wall(studio *s)
{
    assert_int_equal(air_scene_set_mesh(s->scene, s->wall, &s->wall_desc), AIR_OK);
}

static void set_panel(studio *s)
{
    assert_int_equal(air_scene_set_mesh(s->scene, s->panel, &s->panel_desc), AIR_OK);
}

static void set_grey(studio *s)
{
    assert_int_equal(air_scene_set_material(s->scene, s->grey, &s->grey_desc), AIR_OK);
}

static void set_glowing(studio *s)
{
    assert_int_equal(air_scene_set_material(s->scene, s->glowing, &s->glowing_desc), AIR_OK);
}

/* ---- dirty ---- */

static void the_first_commit_is_all_dirty_and_the_next_clean(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    assert_int_equal(fixture_dirty(s.scene), ALL_DIRTY);
    assert_int_equal(fixture_dirty(s.scene), 0);
    close_studio(&s);
}

static void setting_what_is_there_is_not_dirty(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    fixture_dirty(s.scene);
    set_wall(&s);
    set_panel(&s);
    set_grey(&s);
    set_glowing(&s);
    assert_int_equal(air_scene_set_medium(s.scene, s.haze, &s.haze_desc), AIR_OK);
    assert_int_equal(air_scene_set_light(s.scene, s.lamp, &s.lamp_desc), AIR_OK);
    assert_int_equal(air_scene_set_camera(s.scene, s.camera, &s.camera_desc), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), 0);
    close_studio(&s);
}

static void changing_back_before_the_commit_is_not_dirty(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    air_snapshot *before = fixture_commit(s.scene, NULL);
    const float positions[12] = {-9, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    s.wall_desc.positions = positions;
    set_wall(&s);
    s.wall_desc.positions = fixture_square_positions;
    set_wall(&s);
    s.lamp_desc.color[0] = 7.0f;
    assert_int_equal(air_scene_set_light(s.scene, s.lamp, &s.lamp_desc), AIR_OK);
    s.lamp_desc.color[0] = 5.0f;
    assert_int_equal(air_scene_set_light(s.scene, s.lamp, &s.lamp_desc), AIR_OK);
    uint32_t dirty;
    air_snapshot *after = fixture_commit(s.scene, &dirty);
    assert_int_equal(dirty, 0);
    assert_ptr_equal(before->accelerator, after->accelerator);
    assert_ptr_equal(before->lights.entries, after->lights.entries);
    air_snapshot_release(before);
    air_snapshot_release(after);
    close_studio(&s);
}

static void each_edit_is_dirty_in_its_own_way(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    fixture_dirty(s.scene);

    s.camera_desc.fov_y_rad = 1.0f;
    assert_int_equal(air_scene_set_camera(s.scene, s.camera, &s.camera_desc), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_CAMERA);
    s.lamp_desc.position[1] = 1.0f;
    assert_int_equal(air_scene_set_light(s.scene, s.lamp, &s.lamp_desc), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_LIGHT);
    s.haze_desc.phase = (air_phase){.kind = AIR_PHASE_HG, .g = 0.5f};
    assert_int_equal(air_scene_set_medium(s.scene, s.haze, &s.haze_desc), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MEDIUM);
    air_phase_mixture mixture = {2,
                                 {{AIR_PHASE_HG, 0.5f, 1.0f}, {AIR_PHASE_ISOTROPIC, 0.0f, 1.0f}}};
    s.haze_desc.phase = (air_phase){.kind = AIR_PHASE_MIXTURE, .mixture = &mixture};
    assert_int_equal(air_scene_set_medium(s.scene, s.haze, &s.haze_desc), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MEDIUM);
    assert_int_equal(air_scene_set_medium(s.scene, s.haze, &s.haze_desc), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), 0);
    mixture.lobes[1].weight = 2.0f;
    assert_int_equal(air_scene_set_medium(s.scene, s.haze, &s.haze_desc), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MEDIUM);

    s.wall_desc.to_world[3] = 1.0f;
    set_wall(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_TRANSFORM);
    s.wall_desc.casts_shadow = false;
    set_wall(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_GEOMETRY);
    s.wall_desc.uv[0] = NULL;
    set_wall(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_GEOMETRY);
    s.wall_desc.material = AIR_NONE;
    set_wall(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MATERIAL);
    s.wall_desc.name = "a new name";
    set_wall(&s);
    assert_int_equal(fixture_dirty(s.scene), 0);
    close_studio(&s);
}

static void emissive_meshes_are_lights(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    fixture_dirty(s.scene);
    s.panel_desc.to_world[3] = 1.0f;
    set_panel(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_TRANSFORM | AIR_DIRTY_LIGHT);
    s.glowing_desc.emission[0] = 3.0f;
    set_glowing(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MATERIAL | AIR_DIRTY_LIGHT);
    s.glowing_desc.roughness = 0.5f;
    set_glowing(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MATERIAL);
    s.grey_desc.emission[2] = 1.0f;
    set_grey(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MATERIAL | AIR_DIRTY_LIGHT);
    s.panel_desc.material = s.grey;
    set_panel(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MATERIAL | AIR_DIRTY_LIGHT);
    assert_int_equal(air_scene_remove(s.scene, s.panel), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_GEOMETRY | AIR_DIRTY_LIGHT);
    close_studio(&s);
}

static void adding_and_removing_is_dirty(void **state)
{
    studio s;
    air_handle handle;
    (void)state;
    open_studio(&s);
    fixture_dirty(s.scene);
    assert_int_equal(air_scene_add_mesh(s.scene, &s.wall_desc, &handle), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_GEOMETRY);
    assert_int_equal(air_scene_remove(s.scene, handle), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_GEOMETRY);
    assert_int_equal(air_scene_add_mesh(s.scene, &s.wall_desc, &handle), AIR_OK);
    assert_int_equal(air_scene_remove(s.scene, handle), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), 0);
    assert_int_equal(air_scene_remove(s.scene, s.lamp), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_LIGHT);
    assert_int_equal(air_scene_remove(s.scene, s.haze), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_MEDIUM);
    assert_int_equal(air_scene_remove(s.scene, s.camera), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_CAMERA);
    /* now the camera frames the bounds and goes with them */
    s.wall_desc.to_world[3] = -4.0f;
    set_wall(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_TRANSFORM | AIR_DIRTY_CAMERA);
    close_studio(&s);
}

static air_grid_desc cube_of(const float *values)
{
    return (air_grid_desc){.name = "smoke",
                           .size = {2, 2, 2},
                           .channels = 1,
                           .values = values,
                           .index_to_local = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
}

static void a_new_grid_makes_the_media_that_hold_it_dirty_and_nothing_else(void **state)
{
    const float thin[8] = {1, 1, 1, 1, 1, 1, 1, 1}, thick[8] = {2, 2, 2, 2, 2, 2, 2, 2};
    const air_grid_desc thin_desc = cube_of(thin), thick_desc = cube_of(thick);
    studio s;
    air_handle grid, other;
    (void)state;
    open_studio(&s);
    assert_int_equal(air_scene_add_grid(s.scene, &thin_desc, &grid), AIR_OK);
    s.haze_desc.density.kind = AIR_DENSITY_GRID;
    s.haze_desc.density.grid = grid;
    s.haze_desc.density.grid_to_world[0] = s.haze_desc.density.grid_to_world[5] =
        s.haze_desc.density.grid_to_world[10] = 1.0f;
    assert_int_equal(air_scene_set_medium(s.scene, s.haze, &s.haze_desc), AIR_OK);
    air_snapshot *a = fixture_commit(s.scene, NULL);
    assert_int_equal(air_scene_set_grid(s.scene, grid, &thick_desc), AIR_OK);
    uint32_t dirty;
    air_snapshot *b = fixture_commit(s.scene, &dirty);
    assert_int_equal(dirty, AIR_DIRTY_MEDIUM);
    assert_ptr_equal(a->accelerator, b->accelerator);
    assert_ptr_equal(a->lights.entries, b->lights.entries);
    assert_float_equal(air_grid_max(a->media.media[0].density_grid), 1.0f, 0.0f);
    assert_float_equal(air_grid_max(b->media.media[0].density_grid), 2.0f, 0.0f);

    assert_int_equal(air_scene_add_grid(s.scene, &thin_desc, &other), AIR_OK);
    assert_int_equal(fixture_dirty(s.scene), 0);
    assert_int_equal(air_scene_set_grid(s.scene, other, &thick_desc), AIR_OK);
    air_snapshot *c = fixture_commit(s.scene, &dirty);
    assert_int_equal(dirty, 0);
    assert_ptr_equal(b->media.media, c->media.media);

    assert_int_equal(air_scene_set_grid(s.scene, s.haze, &thick_desc), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_remove(s.scene, grid), AIR_ERROR_ARGUMENT);
    air_snapshot_release(a);
    air_snapshot_release(b);
    air_snapshot_release(c);
    close_studio(&s);
}

/* ---- sharing ---- */

static void what_is_unchanged_is_shared(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    air_snapshot *a = fixture_commit(s.scene, NULL);
    s.camera_desc.fov_y_rad = 1.0f;
    assert_int_equal(air_scene_set_camera(s.scene, s.camera, &s.camera_desc), AIR_OK);
    s.grey_desc.roughness = 0.25f;
    set_grey(&s);
    air_snapshot *b = fixture_commit(s.scene, NULL);
    assert_ptr_equal(a->accelerator, b->accelerator);
    assert_ptr_equal(a->lights.entries, b->lights.entries);
    assert_ptr_equal(a->media.media, b->media.media);
    assert_ptr_equal(a->materials[1].base_color_slot.texture,
                     b->materials[1].base_color_slot.texture);
    assert_true(a->materials[1].roughness == 1.0f && b->materials[1].roughness == 0.25f);
    assert_ptr_equal(a->meshes[1]->positions, b->meshes[1]->positions);
    assert_int_equal(a->meshes[1]->first_emitter, b->meshes[1]->first_emitter);

    s.lamp_desc.color[0] = 1.0f;
    assert_int_equal(air_scene_set_light(s.scene, s.lamp, &s.lamp_desc), AIR_OK);
    air_snapshot *c = fixture_commit(s.scene, NULL);
    assert_ptr_equal(b->accelerator, c->accelerator);
    assert_ptr_equal(b->media.media, c->media.media);
    assert_ptr_not_equal(b->lights.entries, c->lights.entries);
    assert_true(b->lights.entries[0].color.x == 5.0f && c->lights.entries[0].color.x == 1.0f);
    air_snapshot_release(a);
    air_snapshot_release(b);
    air_snapshot_release(c);
    close_studio(&s);
}

static void moving_one_mesh_shares_the_other(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    air_snapshot *a = fixture_commit(s.scene, NULL);
    s.wall_desc.to_world[3] = 0.5f;
    set_wall(&s);
    air_snapshot *b = fixture_commit(s.scene, NULL);
    assert_ptr_not_equal(a->accelerator, b->accelerator);
    assert_ptr_not_equal(a->meshes[0]->positions, b->meshes[0]->positions);
    assert_ptr_equal(a->meshes[0]->indices, b->meshes[0]->indices);
    assert_ptr_equal(a->meshes[1]->positions, b->meshes[1]->positions);
    assert_true(a->meshes[0]->positions[0] == -1.0f && b->meshes[0]->positions[0] == -0.5f);
    air_snapshot_release(a);
    air_snapshot_release(b);
    close_studio(&s);
}

static void visibility_rebuilds_the_accelerator_and_names_do_not(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    air_snapshot *a = fixture_commit(s.scene, NULL);
    s.wall_desc.name = "renamed";
    set_wall(&s);
    air_snapshot *b = fixture_commit(s.scene, NULL);
    assert_ptr_equal(a->accelerator, b->accelerator);
    assert_string_equal(a->meshes[0]->name, "wall");
    assert_string_equal(b->meshes[0]->name, "renamed");
    s.grey_desc.alpha_mode = AIR_ALPHA_BLEND;
    s.grey_desc.base_color[3] = 0.5f;
    set_grey(&s);
    air_snapshot *c = fixture_commit(s.scene, NULL);
    assert_ptr_not_equal(b->accelerator, c->accelerator);
    assert_int_equal(b->meshes[0]->mask,
                     AIR_MASK_CAMERA | AIR_MASK_SCATTER | AIR_MASK_SHADOW_OPAQUE);
    assert_int_equal(c->meshes[0]->mask,
                     AIR_MASK_CAMERA | AIR_MASK_SCATTER | AIR_MASK_SHADOW_ALPHA);
    assert_false(b->has_alpha);
    assert_true(c->has_alpha);
    air_snapshot_release(a);
    air_snapshot_release(b);
    air_snapshot_release(c);
    close_studio(&s);
}

static void masks_follow_flags(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_handle handle;
    (void)state;
    for (int i = 0; i < 4; ++i) {
        air_mesh_desc desc = fixture_square("square");
        desc.camera_visible = (i & 1) != 0;
        desc.casts_shadow = (i & 2) != 0;
        assert_int_equal(air_scene_add_mesh(scene, &desc, &handle), AIR_OK);
    }
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    for (uint32_t i = 0; i < 4; ++i)
        assert_int_equal(snapshot->meshes[i]->mask, AIR_MASK_SCATTER |
                                                        (i & 1 ? AIR_MASK_CAMERA : 0) |
                                                        (i & 2 ? AIR_MASK_SHADOW_OPAQUE : 0));
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

/* ---- life ---- */

static void snapshots_outlive_their_scene(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    air_snapshot *first = fixture_commit(s.scene, NULL);
    s.panel_desc.to_world[3] = 1.0f;
    set_panel(&s);
    air_snapshot *second = fixture_commit(s.scene, NULL);
    air_scene_destroy(s.scene);
    air_snapshot_retain(first);
    air_snapshot_release(first);
    air_snapshot_release(first);

    const air_ray ray = {
        .origin = {0.5f, 0.25f, 9.0f}, .dir = {0, 0, -1}, .tmax = INFINITY, .mask = 1};
    air_hit hit;
    air_context_ray_backend(s.context)->intersect(second->accelerator, &ray, 1, &hit);
    assert_int_equal(hit.mesh, 1);
    assert_true(fabsf(hit.t - 6.0f) < 1e-5f);
    assert_string_equal(second->materials[2].name, "glowing");
    assert_int_equal(second->materials[1].base_color_slot.texture->bytes[0], 255);
    air_snapshot_release(second);
    air_context_destroy(s.context);
}

static void *retain_and_release(void *snapshot)
{
    for (int i = 0; i < 10000; ++i) {
        air_snapshot_retain(snapshot);
        air_snapshot_release(snapshot);
    }
    air_snapshot_release(snapshot);
    return NULL;
}

static void references_are_counted_across_threads(void **state)
{
    studio s;
    pthread_t threads[4];
    (void)state;
    open_studio(&s);
    air_snapshot *snapshot = fixture_commit(s.scene, NULL);
    air_scene_destroy(s.scene);
    for (int i = 0; i < 4; ++i) {
        air_snapshot_retain(snapshot);
        assert_int_equal(pthread_create(&threads[i], NULL, retain_and_release, snapshot), 0);
    }
    for (int i = 0; i < 4; ++i)
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    assert_int_equal(atomic_load(&snapshot->references), 1);
    air_snapshot_release(snapshot);
    air_context_destroy(s.context);
}

static void a_failed_commit_changes_nothing(void **state)
{
    studio s;
    (void)state;
    open_studio(&s);
    fixture_dirty(s.scene);
    s.wall_desc.to_world[0] = 3e38f;
    s.wall_desc.to_world[3] = 3e38f;
    set_wall(&s);
    air_snapshot *snapshot = (air_snapshot *)&s;
    uint32_t dirty = 12345;
    assert_int_equal(air_scene_commit(s.scene, &snapshot, &dirty), AIR_ERROR_ARGUMENT);
    fixture_expect_message(s.context, "mesh \"wall\": to_world moves vertex 1 beyond");
    assert_ptr_equal(snapshot, (air_snapshot *)&s);
    assert_int_equal(dirty, 12345);
    s.wall_desc.to_world[0] = 1.0f;
    s.wall_desc.to_world[3] = 1.0f;
    set_wall(&s);
    assert_int_equal(fixture_dirty(s.scene), AIR_DIRTY_TRANSFORM);
    close_studio(&s);
}

/* ---- looking ---- */

static void bounds_are_those_of_meshes_and_bounded_media(void **state)
{
    studio s;
    air_scene_info info;
    (void)state;
    open_studio(&s);
    s.lamp_desc.position[0] = 100.0f; /* lights do not count */
    assert_int_equal(air_scene_set_light(s.scene, s.lamp, &s.lamp_desc), AIR_OK);
    air_snapshot *snapshot = fixture_commit(s.scene, NULL);
    air_snapshot_info(snapshot, &info);
    /* the walls span [-1,1]^2 at z = 0 and 3, the haze [-2,2]^3 */
    for (int axis = 0; axis < 3; ++axis) {
        assert_true(fabsf(info.bounds_min[axis] + 2.0f) < 1e-5f);
        assert_true(fabsf(info.bounds_max[axis] - (axis == 2 ? 3.0f : 2.0f)) < 1e-5f);
    }
    assert_int_equal(info.triangle_count, 4);
    assert_int_equal(info.mesh_count, 2);
    assert_int_equal(info.material_count, 2);
    assert_int_equal(info.texture_count, 1);
    assert_int_equal(info.light_count, 1);
    assert_int_equal(info.emissive_triangle_count, 2);
    assert_int_equal(info.medium_count, 1);
    assert_int_equal(info.camera_count, 1);
    assert_true(info.camera_in_file && info.light_present);
    air_snapshot_release(snapshot);
    s.haze_desc.boundary.kind = AIR_BOUNDARY_UNBOUNDED;
    assert_int_equal(air_scene_set_medium(s.scene, s.haze, &s.haze_desc), AIR_OK);
    snapshot = fixture_commit(s.scene, NULL);
    assert_true(snapshot->bounds_min[0] == -1.0f && snapshot->bounds_max[2] == 3.0f);
    air_snapshot_release(snapshot);
    close_studio(&s);
}

static void an_empty_scene_commits_with_a_camera(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    air_scene_info info;
    (void)state;
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    air_snapshot_info(snapshot, &info);
    assert_true(info.bounds_min[0] > info.bounds_max[0]);
    assert_false(info.camera_in_file || info.light_present);
    assert_int_equal(snapshot->camera_count, 1);
    assert_true(snapshot->cameras[0].framed);
    assert_null(snapshot->accelerator);
    assert_int_equal(snapshot->material_count, 1);
    assert_true(snapshot->materials[0].base_color.x == 1.0f);
    assert_int_equal(air_snapshot_camera(snapshot, AIR_NONE), 0);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void cameras_are_found_by_handle(void **state)
{
    studio s;
    air_handle second;
    (void)state;
    open_studio(&s);
    assert_int_equal(air_scene_add_camera(s.scene, &s.camera_desc, &second), AIR_OK);
    air_snapshot *snapshot = fixture_commit(s.scene, NULL);
    assert_int_equal(air_snapshot_camera(snapshot, AIR_NONE), 0);
    assert_int_equal(air_snapshot_camera(snapshot, s.camera), 0);
    assert_int_equal(air_snapshot_camera(snapshot, second), 1);
    assert_true(air_snapshot_camera(snapshot, s.lamp) == SIZE_MAX);
    air_snapshot_release(snapshot);
    close_studio(&s);
}

static void source_and_warnings_are_kept(void **state)
{
    air_context *context = fixture_context();
    air_scene *scene = fixture_scene(context);
    (void)state;
    assert_int_equal(
        air_scene_set_source(scene, "room.glb", AIR_UNITS_PHOTOMETRIC, AIR_UNITS_RADIOMETRIC),
        AIR_OK);
    assert_int_equal(air_scene_set_source(scene, "room.glb", AIR_UNITS_AUTO, AIR_UNITS_RADIOMETRIC),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_scene_add_warning(scene, "no light"), AIR_OK);
    assert_int_equal(air_scene_add_warning(scene, "no medium"), AIR_OK);
    air_snapshot *snapshot = fixture_commit(scene, NULL);
    assert_string_equal(snapshot->source, "room.glb");
    assert_int_equal(snapshot->light_units, AIR_UNITS_PHOTOMETRIC);
    assert_int_equal(snapshot->warning_count, 2);
    assert_string_equal(snapshot->warnings[1], "no medium");
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_commit_is_all_dirty_and_the_next_clean),
        cmocka_unit_test(setting_what_is_there_is_not_dirty),
        cmocka_unit_test(changing_back_before_the_commit_is_not_dirty),
        cmocka_unit_test(each_edit_is_dirty_in_its_own_way),
        cmocka_unit_test(emissive_meshes_are_lights),
        cmocka_unit_test(adding_and_removing_is_dirty),
        cmocka_unit_test(a_new_grid_makes_the_media_that_hold_it_dirty_and_nothing_else),
        cmocka_unit_test(what_is_unchanged_is_shared),
        cmocka_unit_test(moving_one_mesh_shares_the_other),
        cmocka_unit_test(visibility_rebuilds_the_accelerator_and_names_do_not),
        cmocka_unit_test(masks_follow_flags),
        cmocka_unit_test(snapshots_outlive_their_scene),
        cmocka_unit_test(references_are_counted_across_threads),
        cmocka_unit_test(a_failed_commit_changes_nothing),
        cmocka_unit_test(bounds_are_those_of_meshes_and_bounded_media),
        cmocka_unit_test(an_empty_scene_commits_with_a_camera),
        cmocka_unit_test(cameras_are_found_by_handle),
        cmocka_unit_test(source_and_warnings_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
