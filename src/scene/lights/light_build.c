/* light_build.c: the light table of a snapshot. */
#include "scene/lights/light_build.h"

#include <string.h>

#include "scene/lights/emissive.h"
#include "scene/lights/environment.h"
#include "scene/lights/pick.h"
#include "scene/lights/polygon.h"
#include "scene/lights/punctual.h"
#include "scene/material.h"

/* ---- explicit lights ---- */

static air_vec3 unit(const float dir[3])
{
    const air_vec3 v = vec3_load(dir);
    return vec3_normalize(vec3_scale(v, 1.0f / fmaxf(fabsf(v.x), fmaxf(fabsf(v.y), fabsf(v.z)))));
}

static air_status build_light(air_context *context, const air_light_source *source, uint32_t owner,
                              air_light *out)
{
    const air_light_desc *desc = source->desc;
    *out = (air_light){.name = air_string_copy(context, desc->name),
                       .kind = desc->kind,
                       .color = vec3_load(desc->color),
                       .one_sided = desc->one_sided,
                       .camera_visible = desc->camera_visible,
                       .casts_shadow = desc->casts_shadow,
                       .owner = owner};
    if (out->name == NULL) {
        return air_fail_memory(context, "lights");
    }
    switch (desc->kind) {
    case AIR_LIGHT_SPOT:
        out->dir = unit(desc->dir);
        air_spot_set_cone(out, desc->falloff, (double)desc->inner_cone_rad,
                          (double)desc->outer_cone_rad);
        out->position = vec3_load(desc->position);
        return AIR_OK;
    case AIR_LIGHT_POINT:
        out->position = vec3_load(desc->position);
        return AIR_OK;
    case AIR_LIGHT_PROJECTOR:
        air_projector_set(out, desc, source->image);
        return AIR_OK;
    case AIR_LIGHT_COLLIMATED:
        out->dir = unit(desc->dir);
        out->frame = frame_from_normal(out->dir);
        return desc->window_count > 0
                   ? air_windows_build(context, desc->windows, desc->window_count, out)
                   : AIR_OK;
    case AIR_LIGHT_POLYGON:
        return air_polygon_build(context, desc->vertices, desc->vertex_count, out);
    case AIR_LIGHT_ENVIRONMENT:
        return source->image != NULL ? air_environment_create(context, desc->name, source->image,
                                                              desc->to_world, &out->environment)
                                     : AIR_OK;
    }
    return AIR_ERROR_INTERNAL;
}

static air_status build_explicit(air_context *context, const air_light_source *lights, size_t count,
                                 air_light_table *table)
{
    table->environments = air_allocate(context, count, sizeof *table->environments);
    if (table->environments == NULL) {
        return air_fail_memory(context, "lights");
    }
    for (size_t i = 0; i < count; i++) {
        const air_status status = build_light(context, &lights[i], (uint32_t)i, &table->entries[i]);
        if (status != AIR_OK) {
            return status;
        }
        if (lights[i].desc->kind == AIR_LIGHT_ENVIRONMENT) {
            table->environments[table->environment_count++] = (uint32_t)i;
        }
    }
    return AIR_OK;
}

/* ---- emissive meshes ---- */

/* How many entries a mesh has: one per triangle, or one. */
static size_t entry_count(const air_mesh *mesh, const air_material *materials)
{
    const size_t surfaces = mesh->quadric != NULL ? 1 : mesh->triangle_count;
    return air_material_is_emitter(&materials[mesh->material]) ? surfaces : 0;
}

/* Surfaces with coverage too, which rays meet although they have no entry. */
static bool any_glows(const air_mesh *const *meshes, size_t mesh_count,
                      const air_material *materials)
{
    bool any = false;
    for (size_t i = 0; i < mesh_count; i++) {
        const air_material *material = &materials[meshes[i]->material];
        any = any || (!material->unlit && !vec3_is_zero(material->emission));
    }
    return any;
}

static size_t count_emissive(const air_mesh *const *meshes, size_t mesh_count,
                             const air_material *materials)
{
    size_t count = 0;
    for (size_t i = 0; i < mesh_count; i++) {
        count += entry_count(meshes[i], materials);
    }
    return count;
}

/* The entries behind the explicit ones. Their vertices are one block, which the first of them owns;
 * so is the cdf. */
static air_status build_emissive(air_context *context, const air_mesh *const *meshes,
                                 size_t mesh_count, const air_material *materials,
                                 air_light_table *table)
{
    const size_t count = table->count - table->explicit_count;
    air_vec3 *vertices = NULL;
    float *certain = NULL;
    if (count > 0) {
        vertices = air_allocate(context, count, 3 * sizeof *vertices);
        certain = air_allocate(context, 1, sizeof *certain);
        if (vertices == NULL || certain == NULL) {
            air_free(context, certain);
            air_free(context, vertices);
            return air_fail_memory(context, "emissive triangles");
        }
        *certain = 1.0f;
    }
    size_t next = table->explicit_count;
    for (size_t i = 0; i < mesh_count; i++) {
        const size_t entries = entry_count(meshes[i], materials);
        if (entries > 0) {
            air_emissive_build(
                meshes[i], &materials[meshes[i]->material], (uint32_t)table->explicit_count,
                vertices + 3 * (next - table->explicit_count), certain, &table->entries[next]);
            next += entries;
        }
    }
    return AIR_OK;
}

/* ---- what rays meet ---- */

static bool is_visible(const air_light *light)
{
    return light->kind == AIR_LIGHT_POLYGON && light->camera_visible;
}

static air_status allocate_visible(air_context *context, air_light_table *table,
                                   size_t *out_polygons)
{
    size_t polygons = 0, triangles = 0;
    for (size_t i = 0; i < table->explicit_count; i++) {
        if (is_visible(&table->entries[i])) {
            polygons++;
            triangles += table->entries[i].triangle_count;
        }
    }
    *out_polygons = polygons;
    if (polygons == 0) {
        return AIR_OK;
    }
    table->visible_entries = air_allocate(context, polygons, sizeof *table->visible_entries);
    table->visible_positions =
        air_allocate(context, 9 * triangles + 1, sizeof *table->visible_positions);
    table->visible_indices = air_allocate(context, 3 * triangles, sizeof *table->visible_indices);
    if (table->visible_entries == NULL || table->visible_positions == NULL ||
        table->visible_indices == NULL) {
        return air_fail_memory(context, "polygon lights");
    }
    return AIR_OK;
}

/* One mesh per light; triangles do not share vertices. */
static air_ray_mesh visible_mesh(const air_light *light, float *positions, uint32_t *indices)
{
    for (size_t i = 0; i < 3 * light->triangle_count; i++) {
        vec3_store(positions + 3 * i, light->triangles[i / 3][i % 3]);
        indices[i] = (uint32_t)i;
    }
    return (air_ray_mesh){.positions = positions,
                          .vertex_count = 3 * light->triangle_count,
                          .indices = indices,
                          .triangle_count = light->triangle_count,
                          .mask = UINT32_MAX};
}

static air_status build_visible(air_context *context, air_light_table *table)
{
    size_t polygons;
    const air_status status = allocate_visible(context, table, &polygons);
    if (status != AIR_OK || polygons == 0) {
        return status;
    }
    air_ray_mesh *meshes = air_allocate(context, polygons, sizeof *meshes);
    if (meshes == NULL) {
        return air_fail_memory(context, "polygon lights");
    }
    size_t mesh = 0, triangle = 0;
    for (size_t i = 0; i < table->explicit_count; i++) {
        const air_light *light = &table->entries[i];
        if (is_visible(light)) {
            meshes[mesh] = visible_mesh(light, table->visible_positions + 9 * triangle,
                                        table->visible_indices + 3 * triangle);
            table->visible_entries[mesh++] = (uint32_t)i;
            triangle += light->triangle_count;
        }
    }
    const air_ray_backend *backend = air_context_ray_backend(context);
    const air_status built =
        backend->build(backend->user, context, meshes, polygons, &table->visible_accelerator);
    air_free(context, meshes);
    return built;
}

/* ---- the table ---- */

static void set_scene_sphere(const float bounds_min[3], const float bounds_max[3],
                             air_light_table *table)
{
    const air_vec3 low = vec3_load(bounds_min), high = vec3_load(bounds_max);
    const float diagonal = vec3_length(vec3_sub(high, low));
    table->scene_center = vec3_set1(0.0f);
    table->scene_radius = 1.0f; /* nothing bounded, or a point: any size will do */
    if (low.x <= high.x && low.y <= high.y && low.z <= high.z && isfinite(diagonal)) {
        table->scene_center = vec3_scale(vec3_add(low, high), 0.5f);
        table->scene_radius = diagonal > 0.0f ? 0.5f * diagonal : 1.0f;
    }
}

air_status air_light_table_build(air_context *context, const air_light_source *lights, size_t count,
                                 const air_mesh *const *meshes, size_t mesh_count,
                                 const air_material *materials, const float bounds_min[3],
                                 const float bounds_max[3], air_light_table *out,
                                 uint32_t *mesh_first_emitter)
{
    const size_t emissive = count_emissive(meshes, mesh_count, materials);
    if (count > UINT32_MAX - 1 || emissive > UINT32_MAX - 1 - count) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%zu lights and %zu emissive surfaces, but a scene can have %u together",
                        count, emissive, UINT32_MAX - 1);
    }
    air_light_table table = {.explicit_count = count, .count = count + emissive};
    table.owner_count = count + (any_glows(meshes, mesh_count, materials) ? 1 : 0);
    set_scene_sphere(bounds_min, bounds_max, &table);
    air_status status = AIR_OK;
    table.entries = air_allocate(context, table.count, sizeof *table.entries);
    if (table.entries == NULL) {
        status = air_fail_memory(context, "lights");
    }
    if (status == AIR_OK) {
        status = build_explicit(context, lights, count, &table);
    }
    if (status == AIR_OK) {
        status = build_emissive(context, meshes, mesh_count, materials, &table);
    }
    if (status == AIR_OK) {
        status = air_pick_build(context, &table);
    }
    if (status == AIR_OK) {
        status = build_visible(context, &table);
    }
    if (status != AIR_OK) {
        air_light_table_finish(context, &table);
        return status;
    }
    uint32_t next = (uint32_t)count;
    for (size_t i = 0; i < mesh_count; i++) {
        const size_t entries = entry_count(meshes[i], materials);
        mesh_first_emitter[i] = entries > 0 ? next : UINT32_MAX;
        next += (uint32_t)entries;
    }
    *out = table;
    return AIR_OK;
}

void air_light_table_finish(air_context *context, air_light_table *table)
{
    if (table->visible_accelerator != NULL) {
        air_context_ray_backend(context)->destroy(table->visible_accelerator);
    }
    air_free(context, table->visible_indices);
    air_free(context, table->visible_positions);
    air_free(context, table->visible_entries);
    air_free(context, table->cdf);
    air_free(context, table->environments);
    for (size_t i = 0; table->entries != NULL && i < table->explicit_count; i++) {
        air_light *light = &table->entries[i];
        air_free(context, light->name);
        air_environment_destroy(context, light->environment);
        air_windows_finish(context, light);
        air_polygon_finish(context, light);
    }
    if (table->entries != NULL && table->count > table->explicit_count) {
        air_light *first = &table->entries[table->explicit_count];
        air_free(context, first->triangle_cdf);
        air_free(context, first->vertices);
    }
    air_free(context, table->entries);
    memset(table, 0, sizeof *table);
}
