/* The parts of a snapshot that are costly to make: accelerator, media, light table. */
#include "scene/grid_record.h"
#include "scene/lights/light_build.h"
#include "scene/media/media_build.h"
#include "scene/shared.h"
#include "scene/texture.h"

/* The object that a handle names, checked when the reference was made; NULL for AIR_NONE. */
static const air_record *named_record(const air_snapshot *snapshot, air_object_kind kind,
                                      air_handle handle)
{
    const size_t index = air_shared_find(snapshot->shared, kind, handle);
    return index == SIZE_MAX ? NULL : snapshot->shared->held[kind][index].record;
}

/* ---- accelerator ---- */

static void destroy_accelerator(air_record *record)
{
    air_accelerator_part *part = (air_accelerator_part *)record;
    if (part->accelerator != NULL)
        part->destroy(part->accelerator);
    for (size_t i = 0; part->worlds != NULL && i < part->count; ++i)
        air_record_release((air_record *)part->worlds[i]);
    air_free(record->context, part->worlds);
    air_free(record->context, part->meshes);
}

static air_ray_mesh ray_mesh(const air_mesh *mesh)
{
    const air_quadric *quadric = mesh->quadric;
    return (air_ray_mesh){.positions = mesh->positions,
                          .vertex_count = mesh->vertex_count,
                          .indices = mesh->indices,
                          .triangle_count = mesh->triangle_count,
                          .mask = mesh->mask,
                          .shape = quadric != NULL ? quadric->shape : AIR_RAY_TRIANGLES,
                          .to_world = quadric != NULL ? quadric->to_world : NULL};
}

/* Was the part built from these very arrays and masks? */
static bool accelerator_fits(const air_accelerator_part *part, const air_mesh *meshes, size_t count)
{
    if (part == NULL || part->count != count)
        return false;
    for (size_t i = 0; i < count; ++i) {
        const air_ray_mesh mesh = ray_mesh(&meshes[i]);
        if (part->meshes[i].positions != mesh.positions ||
            part->meshes[i].indices != mesh.indices || part->meshes[i].to_world != mesh.to_world ||
            part->meshes[i].mask != mesh.mask)
            return false;
    }
    return true;
}

static air_status build_accelerator(const air_snapshot *snapshot, air_accelerator_part *part)
{
    air_context *context = snapshot->context;
    const struct air_shared *shared = snapshot->shared;
    const air_ray_backend *backend = air_context_ray_backend(context);
    part->count = snapshot->mesh_count;
    part->destroy = backend->destroy;
    part->meshes = air_allocate(context, part->count, sizeof *part->meshes);
    part->worlds = air_allocate(context, part->count, sizeof(air_world_mesh *));
    if (part->meshes == NULL || part->worlds == NULL)
        return air_fail_memory(context, "accelerator");
    for (size_t i = 0; i < part->count; ++i) {
        part->meshes[i] = ray_mesh(&shared->meshes[i]);
        part->worlds[i] = ((air_mesh_record *)shared->held[AIR_OBJECT_MESH][i].record)->world;
        air_record_retain(&part->worlds[i]->base);
    }
    return backend->build(backend->user, context, part->meshes, part->count, &part->accelerator);
}

air_status air_snapshot_set_accelerator(air_snapshot *snapshot, const air_snapshot *previous)
{
    struct air_shared *shared = snapshot->shared;
    air_accelerator_part *part = previous != NULL ? previous->shared->accelerator : NULL;
    if (snapshot->mesh_count == 0)
        return AIR_OK;
    if (accelerator_fits(part, shared->meshes, snapshot->mesh_count)) {
        air_record_retain(&part->base);
        shared->accelerator = part;
    } else {
        shared->accelerator =
            air_record_create(snapshot->context, sizeof *part, destroy_accelerator, NULL);
        if (shared->accelerator == NULL)
            return AIR_ERROR_MEMORY;
        const air_status status = build_accelerator(snapshot, shared->accelerator);
        if (status != AIR_OK)
            return status;
    }
    snapshot->accelerator = shared->accelerator->accelerator;
    return AIR_OK;
}

/* ---- media ---- */

static void destroy_media(air_record *record)
{
    air_media_part *part = (air_media_part *)record;
    air_media_finish(record->context, &part->media);
    for (size_t i = 0; part->sources != NULL && i < part->count; ++i)
        air_record_release((air_record *)part->sources[i]);
    air_free(record->context, part->sources);
}

static const air_grid *named_grid(const air_snapshot *snapshot, air_handle handle)
{
    const air_record *record = named_record(snapshot, AIR_OBJECT_GRID, handle);
    return record == NULL ? NULL : ((const air_grid_record *)record)->grid;
}

/* Does a medium look at the grids that its description names in this snapshot? */
static bool grids_fit(const air_snapshot *snapshot, const air_density *density,
                      const air_medium *medium)
{
    return density->kind != AIR_DENSITY_GRID ||
           (medium->density_grid == named_grid(snapshot, density->grid) &&
            medium->albedo_grid == named_grid(snapshot, density->albedo_grid) &&
            medium->emission_grid == named_grid(snapshot, density->emission_grid));
}

static bool media_fit(const air_snapshot *snapshot, const air_media_part *part)
{
    const air_held *held = snapshot->shared->held[AIR_OBJECT_MEDIUM];
    if (part == NULL || part->count != snapshot->shared->held_count[AIR_OBJECT_MEDIUM])
        return false;
    for (size_t i = 0; i < part->count; ++i) {
        if (&part->sources[i]->base != held[i].record ||
            !grids_fit(snapshot, &part->sources[i]->desc.density, &part->media.media[i]))
            return false;
    }
    return true;
}

static air_status build_media(const air_snapshot *snapshot, air_media_part *part)
{
    air_context *context = snapshot->context;
    const air_held *held = snapshot->shared->held[AIR_OBJECT_MEDIUM];
    const size_t count = snapshot->shared->held_count[AIR_OBJECT_MEDIUM];
    air_medium_source *sources = air_allocate(context, count, sizeof *sources);
    air_status status = AIR_OK;
    part->sources = air_allocate(context, count, sizeof(air_medium_record *));
    if (sources == NULL || part->sources == NULL) {
        status = air_fail_memory(context, "media");
        goto cleanup;
    }
    part->count = count;
    for (size_t i = 0; i < count; ++i) {
        air_medium_record *record = (air_medium_record *)held[i].record;
        const air_density *density = &record->desc.density;
        const bool gridded = density->kind == AIR_DENSITY_GRID;
        air_record_retain(&record->base);
        part->sources[i] = record;
        sources[i].desc = &record->desc;
        sources[i].density_grid = gridded ? named_grid(snapshot, density->grid) : NULL;
        sources[i].albedo_grid = gridded ? named_grid(snapshot, density->albedo_grid) : NULL;
        sources[i].emission_grid = gridded ? named_grid(snapshot, density->emission_grid) : NULL;
    }
    status = air_media_build(context, sources, count, &part->media);
cleanup:
    air_free(context, sources);
    return status;
}

air_status air_snapshot_set_media(air_snapshot *snapshot, const air_snapshot *previous)
{
    struct air_shared *shared = snapshot->shared;
    air_media_part *part = previous != NULL ? previous->shared->media : NULL;
    if (media_fit(snapshot, part)) {
        air_record_retain(&part->base);
        shared->media = part;
    } else {
        shared->media = air_record_create(snapshot->context, sizeof *part, destroy_media, NULL);
        if (shared->media == NULL)
            return AIR_ERROR_MEMORY;
        const air_status status = build_media(snapshot, shared->media);
        if (status != AIR_OK)
            return status;
    }
    snapshot->media = shared->media->media;
    return AIR_OK;
}

/* ---- lights ---- */

static void destroy_lights(air_record *record)
{
    air_lights_part *part = (air_lights_part *)record;
    air_light_table_finish(record->context, &part->table);
    for (size_t i = 0; i < part->count; ++i)
        air_record_release((air_record *)part->sources[i]);
    for (size_t i = 0; i < part->emitter_count; ++i) {
        air_record_release((air_record *)part->emitters[i].mesh);
        air_record_release((air_record *)part->emitters[i].material);
    }
    air_free(record->context, part->emitters);
    air_free(record->context, part->sources);
}

/* Fills what a light table is made from. */
static air_status collect_sources(const air_snapshot *snapshot, air_lights_part *part)
{
    const struct air_shared *shared = snapshot->shared;
    const air_held *lights = shared->held[AIR_OBJECT_LIGHT],
                   *meshes = shared->held[AIR_OBJECT_MESH];
    const size_t light_count = shared->held_count[AIR_OBJECT_LIGHT];
    part->sources = air_allocate(snapshot->context, light_count, sizeof(air_light_record *));
    part->emitters = air_allocate(snapshot->context, snapshot->mesh_count, sizeof *part->emitters);
    if (part->sources == NULL || part->emitters == NULL)
        return air_fail_memory(snapshot->context, "lights");
    for (; part->count < light_count; ++part->count) {
        air_record_retain(lights[part->count].record);
        part->sources[part->count] = (air_light_record *)lights[part->count].record;
    }
    for (size_t i = 0; i < snapshot->mesh_count; ++i) {
        const uint32_t material = shared->meshes[i].material;
        if (!air_material_is_emitter(&snapshot->materials[material]))
            continue;
        air_emitter *emitter = &part->emitters[part->emitter_count++];
        emitter->mesh = (air_mesh_record *)meshes[i].record;
        emitter->material =
            (air_material_record *)shared->held[AIR_OBJECT_MATERIAL][material - 1].record;
        emitter->mask = shared->meshes[i].mask;
        air_record_retain(&emitter->mesh->base);
        air_record_retain(&emitter->material->base);
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        part->bounds_min[axis] = snapshot->bounds_min[axis];
        part->bounds_max[axis] = snapshot->bounds_max[axis];
    }
    return AIR_OK;
}

/* Do two collections of sources give the same table? */
static bool lights_fit(const air_lights_part *a, const air_lights_part *b)
{
    if (a == NULL || a->count != b->count || a->emitter_count != b->emitter_count ||
        !air_bytes_equal(a->bounds_min, b->bounds_min, sizeof a->bounds_min) ||
        !air_bytes_equal(a->bounds_max, b->bounds_max, sizeof a->bounds_max))
        return false;
    for (size_t i = 0; i < a->count; ++i) {
        if (a->sources[i] != b->sources[i])
            return false;
    }
    for (size_t i = 0; i < a->emitter_count; ++i) {
        if (!air_emitter_equal(&a->emitters[i], &b->emitters[i]))
            return false;
    }
    return true;
}

static air_status build_lights(const air_snapshot *snapshot, air_lights_part *part)
{
    air_context *context = snapshot->context;
    air_light_source *sources = air_allocate(context, part->count, sizeof *sources);
    uint32_t *first_entries = air_allocate(context, snapshot->mesh_count, sizeof *first_entries);
    air_status status = AIR_OK;
    if (sources == NULL || first_entries == NULL) {
        status = air_fail_memory(context, "lights");
        goto cleanup;
    }
    for (size_t i = 0; i < part->count; ++i) {
        const air_light_desc *desc = &part->sources[i]->desc;
        air_link links[AIR_MAX_LINKS];
        const bool linked = air_light_links(desc, links) > 0;
        const air_record *image =
            linked ? named_record(snapshot, AIR_OBJECT_TEXTURE, desc->image) : NULL;
        sources[i].desc = desc;
        sources[i].image = image == NULL ? NULL : &((const air_texture_record *)image)->texture;
    }
    status = air_light_table_build(context, sources, part->count, snapshot->meshes,
                                   snapshot->mesh_count, snapshot->materials, part->bounds_min,
                                   part->bounds_max, &part->table, first_entries);
    for (size_t i = 0, emitter = 0; status == AIR_OK && i < snapshot->mesh_count; ++i) {
        if (air_material_is_emitter(&snapshot->materials[snapshot->meshes[i]->material]))
            part->emitters[emitter++].first_entry = first_entries[i];
    }
cleanup:
    air_free(context, first_entries);
    air_free(context, sources);
    return status;
}

/* Says in the meshes and in the snapshot what the part holds. */
static void use_lights(air_snapshot *snapshot)
{
    const air_lights_part *part = snapshot->shared->lights;
    size_t emitter = 0;
    for (size_t i = 0; i < snapshot->mesh_count; ++i) {
        air_mesh *mesh = &snapshot->shared->meshes[i];
        if (air_material_is_emitter(&snapshot->materials[mesh->material]))
            mesh->first_emitter = part->emitters[emitter++].first_entry;
    }
    snapshot->lights = part->table;
}

air_status air_snapshot_set_lights(air_snapshot *snapshot, const air_snapshot *previous)
{
    air_lights_part *fresh =
        air_record_create(snapshot->context, sizeof *fresh, destroy_lights, NULL);
    if (fresh == NULL)
        return AIR_ERROR_MEMORY;
    air_lights_part *old = previous != NULL ? previous->shared->lights : NULL;
    snapshot->shared->lights = fresh;
    air_status status = collect_sources(snapshot, fresh);
    if (status != AIR_OK)
        return status;
    if (lights_fit(old, fresh)) {
        air_record_retain(&old->base);
        snapshot->shared->lights = old;
        air_record_release(&fresh->base);
    } else {
        status = build_lights(snapshot, fresh);
        if (status != AIR_OK)
            return status;
    }
    use_lights(snapshot);
    return AIR_OK;
}
