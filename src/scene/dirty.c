/* What changed between two snapshots of a scene. */
#include "scene/shared.h"

static bool handles_equal(const struct air_shared *a, const struct air_shared *b,
                          air_object_kind kind)
{
    if (a->held_count[kind] != b->held_count[kind])
        return false;
    for (size_t i = 0; i < a->held_count[kind]; ++i) {
        if (a->held[kind][i].handle != b->held[kind][i].handle)
            return false;
    }
    return true;
}

static bool objects_equal(const struct air_shared *a, const struct air_shared *b,
                          air_object_kind kind)
{
    if (!handles_equal(a, b, kind))
        return false;
    for (size_t i = 0; i < a->held_count[kind]; ++i) {
        if (!air_record_equal(kind, a->held[kind][i].record, b->held[kind][i].record))
            return false;
    }
    return true;
}

/* The camera that commit made moves with the bounds. */
static bool cameras_equal(const struct air_shared *a, const struct air_shared *b)
{
    if (a->framed != NULL && b->framed != NULL)
        return air_record_equal(AIR_OBJECT_CAMERA, a->framed, b->framed);
    return a->framed == b->framed && objects_equal(a, b, AIR_OBJECT_CAMERA);
}

static bool emitters_equal(const air_lights_part *a, const air_lights_part *b)
{
    if (a == b)
        return true;
    if (a->emitter_count != b->emitter_count)
        return false;
    for (size_t i = 0; i < a->emitter_count; ++i) {
        if (!air_emitter_equal(&a->emitters[i], &b->emitters[i]))
            return false;
    }
    return true;
}

/* Of media with equal descriptions: grids are replaced under their handles. */
static bool grids_equal(const air_media *a, const air_media *b)
{
    for (size_t i = 0; i < a->count; ++i) {
        if (a->media[i].density_grid != b->media[i].density_grid ||
            a->media[i].albedo_grid != b->media[i].albedo_grid ||
            a->media[i].emission_grid != b->media[i].emission_grid)
            return false;
    }
    return true;
}

/* What changed of a mesh: new arrays or flags are geometry, and then a new place is no news. */
static uint32_t mesh_dirty(const air_mesh_record *a, const air_mesh_record *b)
{
    uint32_t dirty = 0;
    if (a == b)
        return dirty;
    if (a->camera_visible != b->camera_visible || a->casts_shadow != b->casts_shadow ||
        a->flip_normals != b->flip_normals || !air_geometry_equal(a->geometry, b->geometry))
        dirty |= AIR_DIRTY_GEOMETRY;
    else if (!air_mesh_place_equal(a, b))
        dirty |= AIR_DIRTY_TRANSFORM;
    if (a->material != b->material)
        dirty |= AIR_DIRTY_MATERIAL;
    return dirty;
}

uint32_t air_snapshot_dirty(const air_snapshot *previous, const air_snapshot *next)
{
    if (previous == NULL)
        return AIR_DIRTY_CAMERA | AIR_DIRTY_LIGHT | AIR_DIRTY_MEDIUM | AIR_DIRTY_TRANSFORM |
               AIR_DIRTY_GEOMETRY | AIR_DIRTY_MATERIAL;
    const struct air_shared *a = previous->shared, *b = next->shared;
    uint32_t dirty = 0;
    if (!cameras_equal(a, b))
        dirty |= AIR_DIRTY_CAMERA;
    if (!objects_equal(a, b, AIR_OBJECT_LIGHT) || !emitters_equal(a->lights, b->lights))
        dirty |= AIR_DIRTY_LIGHT;
    if (!objects_equal(a, b, AIR_OBJECT_MEDIUM) || !grids_equal(&previous->media, &next->media))
        dirty |= AIR_DIRTY_MEDIUM;
    if (!objects_equal(a, b, AIR_OBJECT_MATERIAL))
        dirty |= AIR_DIRTY_MATERIAL;
    if (!handles_equal(a, b, AIR_OBJECT_MESH))
        return dirty | AIR_DIRTY_GEOMETRY;
    for (size_t i = 0; i < a->held_count[AIR_OBJECT_MESH]; ++i)
        dirty |= mesh_dirty((const air_mesh_record *)a->held[AIR_OBJECT_MESH][i].record,
                            (const air_mesh_record *)b->held[AIR_OBJECT_MESH][i].record);
    return dirty;
}
