/* emissive.h: emissive meshes as light table entries. */
#ifndef AIR_SCENE_LIGHTS_EMISSIVE_H
#define AIR_SCENE_LIGHTS_EMISSIVE_H

#include "scene/lights/light_table.h"
#include "scene/snapshot.h"

/* Fills one entry per triangle, or that of a quadric. vertices: 3 per entry, memory that the
 * entries keep; certain: the number 1, likewise (the cdf of a polygon of one triangle). */
void air_emissive_build(const air_mesh *mesh, const air_material *material, uint32_t owner,
                        air_vec3 *vertices, float *certain, air_light *entries);

/* The mean of the radiance over an entry's surface, as a weight. */
air_vec3 air_emissive_mean(const air_light *light);

#endif
