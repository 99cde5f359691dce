/* light_build.h: from light descriptions and emissive meshes to the light table of a snapshot. */
#ifndef AIR_SCENE_LIGHTS_LIGHT_BUILD_H
#define AIR_SCENE_LIGHTS_LIGHT_BUILD_H

#include "scene/lights/light_table.h"
#include "scene/snapshot.h"

/* A description with the texture that its image handle names, NULL where that is AIR_NONE. */
typedef struct air_light_source {
    const air_light_desc *desc;
    const struct air_texture *image;
} air_light_source;

/* Checks every field of a description; the image handle is not looked at. On failure
 * AIR_ERROR_ARGUMENT with a message that names the light and the field. */
air_status air_light_check(air_context *context, const air_light_desc *desc);

/* Makes the table from checked descriptions, then the triangles of those meshes whose material
 * emits (air_material_is_emitter in scene/material.h), mesh by mesh, every triangle of such a mesh
 * having an entry, a quadric one. Everything is copied except textures and quadrics, which are
 * borrowed and must outlive *out. Only positions, indices, uv, counts, quadric, material, mask (is
 * a shadow bit set?) and flip of a mesh are read. mesh_first_emitter: mesh_count numbers, the entry
 * of a mesh's triangle 0, UINT32_MAX for a mesh that does not emit. bounds_min > bounds_max:
 * nothing bounded. */
air_status air_light_table_build(air_context *context, const air_light_source *lights, size_t count,
                                 const air_mesh *const *meshes, size_t mesh_count,
                                 const air_material *materials, const float bounds_min[3],
                                 const float bounds_max[3], air_light_table *out,
                                 uint32_t *mesh_first_emitter);
void air_light_table_finish(air_context *context, air_light_table *table); /* all zero is legal */

#endif
