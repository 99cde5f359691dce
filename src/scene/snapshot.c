/* Freezing a scene, and what can be asked of the result. */
#include "scene/snapshot.h"

#include <inttypes.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/shared.h"
#include "scene/texture.h"

/* ---- life ---- */

static void destroy_snapshot(air_snapshot *snapshot)
{
    air_context *context = snapshot->context;
    for (size_t i = 0; i < snapshot->warning_count; ++i)
        air_free(context, snapshot->warnings[i]);
    air_free(context, snapshot->warnings);
    air_free(context, snapshot->source);
    air_free(context, snapshot->cameras);
    air_free(context, snapshot->materials);
    air_free(context, snapshot->meshes);
    air_shared_destroy(context, snapshot->shared);
    air_free(context, snapshot);
}

void air_snapshot_retain(air_snapshot *snapshot)
{
    atomic_fetch_add_explicit(&snapshot->references, 1, memory_order_relaxed);
}

void air_snapshot_release(air_snapshot *snapshot)
{
    if (snapshot != NULL &&
        atomic_fetch_sub_explicit(&snapshot->references, 1, memory_order_acq_rel) == 1)
        destroy_snapshot(snapshot);
}

/* ---- freezing, step by step ---- */

/* Objects that were changed and changed back since the last commit take their old record, so that
 * what was made from it can be shared. */
static void restore_records(air_scene *scene)
{
    if (scene->last == NULL)
        return;
    for (size_t kind = 0; kind < AIR_OBJECT_KIND_COUNT; ++kind) {
        for (size_t i = 0; i < scene->lists[kind].count; ++i) {
            air_slot *slot = &scene->lists[kind].slots[i];
            const size_t index =
                air_shared_find(scene->last->shared, (air_object_kind)kind, slot->handle);
            if (index == SIZE_MAX)
                continue;
            air_record *old = scene->last->shared->held[kind][index].record;
            if (old == slot->record || strcmp(old->name, slot->record->name) != 0 ||
                !air_record_equal((air_object_kind)kind, old, slot->record))
                continue;
            air_record_retain(old);
            air_record_release(slot->record);
            slot->record = old;
        }
    }
}

static air_status hold_records(const air_scene *scene, air_snapshot *snapshot)
{
    struct air_shared *shared = snapshot->shared;
    for (size_t kind = 0; kind < AIR_OBJECT_KIND_COUNT; ++kind) {
        const air_slot_list *list = &scene->lists[kind];
        shared->held[kind] = air_allocate(snapshot->context, list->count, sizeof(air_held));
        if (shared->held[kind] == NULL)
            return air_fail_memory(snapshot->context, "snapshot");
        shared->held_count[kind] = list->count;
        for (size_t i = 0; i < list->count; ++i) {
            air_record_retain(list->slots[i].record);
            shared->held[kind][i] = (air_held){list->slots[i].handle, list->slots[i].record};
        }
    }
    snapshot->texture_count = shared->held_count[AIR_OBJECT_TEXTURE];
    return AIR_OK;
}

static uint32_t material_index(const air_snapshot *snapshot, air_handle handle)
{
    return handle == AIR_NONE
               ? 0
               : (uint32_t)air_shared_find(snapshot->shared, AIR_OBJECT_MATERIAL, handle) + 1;
}

static void set_material(const air_snapshot *snapshot, const air_material_record *record,
                         bool colored, air_material *out_material)
{
    air_link links[AIR_MAX_LINKS];
    const air_texture *textures[AIR_MATERIAL_TEXTURES] = {NULL};
    air_material_links(&record->desc, links);
    for (size_t i = 0; i < AIR_MATERIAL_TEXTURES; ++i) {
        const size_t index = air_shared_find(snapshot->shared, AIR_OBJECT_TEXTURE, links[i].handle);
        if (index != SIZE_MAX)
            textures[i] =
                &((air_texture_record *)snapshot->shared->held[AIR_OBJECT_TEXTURE][index].record)
                     ->texture;
    }
    air_material_init(record, textures, colored, out_material);
}

static air_status set_blend(const air_snapshot *snapshot, const air_material_record *record,
                            air_material *material)
{
    for (size_t i = 0; i < 2 && material->model == AIR_MATERIAL_BLEND; ++i) {
        const air_material *blended =
            &snapshot->materials[material_index(snapshot, record->desc.blend[i])];
        if (blended->model == AIR_MATERIAL_BLEND || blended->model == AIR_MATERIAL_NULL)
            return air_fail(snapshot->context, AIR_ERROR_ARGUMENT,
                            "material \"%s\": blend[%zu] is \"%s\", but must be neither a blend "
                            "nor NULL",
                            material->name, i, blended->name);
        material->blend[i] = blended;
    }
    return AIR_OK;
}

/* The default material first. */
static air_status set_materials(air_snapshot *snapshot)
{
    const struct air_shared *shared = snapshot->shared;
    const size_t count = shared->held_count[AIR_OBJECT_MATERIAL] + 1;
    bool *colored = air_allocate(snapshot->context, count, sizeof *colored);
    snapshot->materials = air_allocate(snapshot->context, count, sizeof *snapshot->materials);
    if (colored == NULL || snapshot->materials == NULL) {
        air_free(snapshot->context, colored);
        return air_fail_memory(snapshot->context, "materials");
    }
    snapshot->material_count = count;
    for (size_t i = 0; i < shared->held_count[AIR_OBJECT_MESH]; ++i) {
        const air_mesh_record *mesh =
            (const air_mesh_record *)shared->held[AIR_OBJECT_MESH][i].record;
        if (mesh->geometry->colors != NULL)
            colored[material_index(snapshot, mesh->material)] = true;
    }
    air_material_record default_record = {.base = {.name = ""}};
    air_material_desc_default(&default_record.desc);
    set_material(snapshot, &default_record, colored[0], &snapshot->materials[0]);
    for (size_t i = 1; i < count; ++i)
        set_material(snapshot,
                     (const air_material_record *)shared->held[AIR_OBJECT_MATERIAL][i - 1].record,
                     colored[i], &snapshot->materials[i]);
    air_free(snapshot->context, colored);
    air_status status = AIR_OK;
    for (size_t i = 1; i < count && status == AIR_OK; ++i)
        status = set_blend(
            snapshot, (const air_material_record *)shared->held[AIR_OBJECT_MATERIAL][i - 1].record,
            &snapshot->materials[i]);
    return status;
}

static air_status set_meshes(air_snapshot *snapshot)
{
    struct air_shared *shared = snapshot->shared;
    const size_t count = shared->held_count[AIR_OBJECT_MESH];
    shared->meshes = air_allocate(snapshot->context, count, sizeof *shared->meshes);
    snapshot->meshes = air_allocate(snapshot->context, count, sizeof(air_mesh *));
    if (shared->meshes == NULL || snapshot->meshes == NULL)
        return air_fail_memory(snapshot->context, "meshes");
    snapshot->mesh_count = count;
    for (size_t i = 0; i < count; ++i) {
        air_mesh_record *record = (air_mesh_record *)shared->held[AIR_OBJECT_MESH][i].record;
        const air_status status = air_mesh_record_place(record);
        if (status != AIR_OK)
            return status;
        const uint32_t material = material_index(snapshot, record->material);
        air_mesh_init(record, material, &snapshot->materials[material], &shared->meshes[i]);
        snapshot->meshes[i] = &shared->meshes[i];
        snapshot->triangle_count += shared->meshes[i].triangle_count;
        snapshot->has_alpha =
            snapshot->has_alpha || snapshot->materials[material].alpha_mode != AIR_ALPHA_OPAQUE;
    }
    return AIR_OK;
}

static void empty_bounds(float low[3], float high[3])
{
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = INFINITY;
        high[axis] = -INFINITY;
    }
}

static void grow_bounds(float low[3], float high[3], const float by_low[3], const float by_high[3])
{
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = fminf(low[axis], by_low[axis]);
        high[axis] = fmaxf(high[axis], by_high[axis]);
    }
}

/* Those that are bounded on all sides. */
static void grow_by_media(const air_snapshot *snapshot, float low[3], float high[3])
{
    for (size_t i = 0; i < snapshot->media.count; ++i) {
        const air_medium *medium = &snapshot->media.media[i];
        if (vec3_is_finite(vec3_load(medium->bounds_min)) &&
            vec3_is_finite(vec3_load(medium->bounds_max)))
            grow_bounds(low, high, medium->bounds_min, medium->bounds_max);
    }
}

/* Meshes, and those media that are bounded on all sides. */
static void set_bounds(air_snapshot *snapshot)
{
    const struct air_shared *shared = snapshot->shared;
    float *low = snapshot->bounds_min, *high = snapshot->bounds_max;
    empty_bounds(low, high);
    for (size_t i = 0; i < snapshot->mesh_count; ++i) {
        const air_world_mesh *world =
            ((air_mesh_record *)shared->held[AIR_OBJECT_MESH][i].record)->world;
        grow_bounds(low, high, world->bounds_min, world->bounds_max);
    }
    grow_by_media(snapshot, low, high);
}

static air_camera camera_form(const air_camera_record *record, air_handle handle)
{
    const air_camera_desc *desc = &record->desc;
    air_camera camera = {.name = record->base.name,
                         .kind = desc->kind,
                         .fov_y_rad = desc->fov_y_rad,
                         .half_height = desc->half_height,
                         .aspect = desc->aspect,
                         .mirrored = desc->mirrored,
                         .near_distance = desc->near_distance,
                         .lens_radius = desc->lens_radius,
                         .focus_distance = desc->focus_distance,
                         .film = desc->film,
                         .handle = handle,
                         .framed = handle == AIR_NONE};
    memcpy(camera.to_world, desc->to_world, sizeof camera.to_world);
    return camera;
}

static air_status set_cameras(air_snapshot *snapshot)
{
    struct air_shared *shared = snapshot->shared;
    const size_t count = shared->held_count[AIR_OBJECT_CAMERA];
    snapshot->camera_in_file = count > 0;
    snapshot->camera_count = count > 0 ? count : 1;
    snapshot->cameras =
        air_allocate(snapshot->context, snapshot->camera_count, sizeof *snapshot->cameras);
    if (snapshot->cameras == NULL)
        return air_fail_memory(snapshot->context, "cameras");
    for (size_t i = 0; i < count; ++i) {
        const air_held *held = &shared->held[AIR_OBJECT_CAMERA][i];
        snapshot->cameras[i] = camera_form((const air_camera_record *)held->record, held->handle);
    }
    if (count > 0)
        return AIR_OK;
    air_camera_desc desc;
    air_camera_frame(snapshot->bounds_min, snapshot->bounds_max, &desc);
    const air_status status = air_camera_record_create(snapshot->context, &desc, &shared->framed);
    if (status == AIR_OK)
        snapshot->cameras[0] = camera_form((const air_camera_record *)shared->framed, AIR_NONE);
    return status;
}

static air_status set_source(const air_scene *scene, air_snapshot *snapshot)
{
    air_context *context = snapshot->context;
    snapshot->light_units = scene->light_units;
    snapshot->emissive_units = scene->emissive_units;
    snapshot->source = air_string_copy(context, scene->source);
    snapshot->warnings = air_allocate(context, scene->warning_count, sizeof(char *));
    if (snapshot->source == NULL || snapshot->warnings == NULL)
        return air_fail_memory(context, "snapshot");
    for (size_t i = 0; i < scene->warning_count; ++i) {
        snapshot->warnings[i] = air_string_copy(context, scene->warnings[i]);
        if (snapshot->warnings[i] == NULL)
            return air_fail_memory(context, "snapshot");
        ++snapshot->warning_count;
    }
    return AIR_OK;
}

static air_status fill_snapshot(const air_scene *scene, air_snapshot *snapshot)
{
    air_status status = AIR_OK;
    if ((status = hold_records(scene, snapshot)) != AIR_OK ||
        (status = set_materials(snapshot)) != AIR_OK || (status = set_meshes(snapshot)) != AIR_OK ||
        (status = air_snapshot_set_accelerator(snapshot, scene->last)) != AIR_OK ||
        (status = air_snapshot_set_media(snapshot, scene->last)) != AIR_OK)
        return status;
    set_bounds(snapshot);
    if ((status = air_snapshot_set_lights(snapshot, scene->last)) != AIR_OK ||
        (status = air_snapshot_set_shadows(snapshot, scene->last)) != AIR_OK ||
        (status = set_cameras(snapshot)) != AIR_OK)
        return status;
    return set_source(scene, snapshot);
}

air_status air_scene_commit(air_scene *scene, air_snapshot **out_snapshot, uint32_t *out_dirty)
{
    if (scene == NULL || out_snapshot == NULL)
        return AIR_ERROR_ARGUMENT;
    restore_records(scene);
    air_snapshot *snapshot = air_allocate(scene->context, 1, sizeof *snapshot);
    if (snapshot == NULL)
        return air_fail_memory(scene->context, "snapshot");
    snapshot->context = scene->context;
    atomic_init(&snapshot->references, 1);
    snapshot->shared = air_allocate(scene->context, 1, sizeof *snapshot->shared);
    const air_status status = snapshot->shared == NULL ? air_fail_memory(scene->context, "snapshot")
                                                       : fill_snapshot(scene, snapshot);
    if (status != AIR_OK) {
        air_snapshot_release(snapshot);
        return status;
    }
    if (out_dirty != NULL)
        *out_dirty = air_snapshot_dirty(scene->last, snapshot);
    air_snapshot_release(scene->last);
    air_snapshot_retain(snapshot);
    scene->last = snapshot;
    *out_snapshot = snapshot;
    return AIR_OK;
}

/* ---- looking ---- */

size_t air_snapshot_camera(const air_snapshot *snapshot, air_handle handle)
{
    if (handle == AIR_NONE)
        return 0;
    return air_shared_find(snapshot->shared, AIR_OBJECT_CAMERA, handle);
}

air_status air_snapshot_camera_desc(const air_snapshot *snapshot, air_handle camera,
                                    air_camera_desc *out_desc)
{
    if (snapshot == NULL || out_desc == NULL)
        return AIR_ERROR_ARGUMENT;
    const size_t index = air_snapshot_camera(snapshot, camera);
    if (index == SIZE_MAX)
        return air_fail(snapshot->context, AIR_ERROR_ARGUMENT,
                        "the handle %" PRIu32 " names no camera in this snapshot", camera);
    const air_camera *form = &snapshot->cameras[index];
    *out_desc = (air_camera_desc){.name = form->name,
                                  .kind = form->kind,
                                  .fov_y_rad = form->fov_y_rad,
                                  .half_height = form->half_height,
                                  .mirrored = form->mirrored,
                                  .near_distance = form->near_distance,
                                  .lens_radius = form->lens_radius,
                                  .focus_distance = form->focus_distance,
                                  .film = form->film,
                                  .aspect = form->aspect};
    memcpy(out_desc->to_world, form->to_world, sizeof out_desc->to_world);
    return AIR_OK;
}

/* Is there anything that sends light? Surfaces that only show themselves (unlit) count where there
 * are no others. */
static bool has_light(const air_snapshot *snapshot)
{
    size_t unlit_count = 0;
    if (snapshot->lights.count > 0)
        return true;
    for (size_t i = 0; i < snapshot->media.count; ++i) {
        if (!vec3_is_zero(snapshot->media.media[i].emission))
            return true;
    }
    for (size_t i = 0; i < snapshot->mesh_count; ++i) {
        const air_material *material = &snapshot->materials[snapshot->meshes[i]->material];
        if (material->unlit)
            ++unlit_count;
        else if (!vec3_is_zero(material->emission))
            return true;
    }
    return unlit_count > 0 && unlit_count == snapshot->mesh_count;
}

void air_snapshot_info(const air_snapshot *snapshot, air_scene_info *out_info)
{
    *out_info =
        (air_scene_info){.triangle_count = snapshot->triangle_count,
                         .mesh_count = snapshot->mesh_count,
                         .material_count = snapshot->material_count - 1,
                         .texture_count = snapshot->texture_count,
                         .light_count = snapshot->lights.explicit_count,
                         .emissive_triangle_count = air_light_triangle_count(&snapshot->lights),
                         .medium_count = snapshot->media.count,
                         .camera_count = snapshot->camera_in_file ? snapshot->camera_count : 0,
                         .camera_in_file = snapshot->camera_in_file,
                         .light_present = has_light(snapshot)};
    memcpy(out_info->bounds_min, snapshot->bounds_min, sizeof out_info->bounds_min);
    memcpy(out_info->bounds_max, snapshot->bounds_max, sizeof out_info->bounds_max);
    empty_bounds(out_info->media_min, out_info->media_max);
    grow_by_media(snapshot, out_info->media_min, out_info->media_max);
}
