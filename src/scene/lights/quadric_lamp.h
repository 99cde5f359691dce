/* quadric_lamp.h: emissive spheres, cylinders and disks as light table entries, one for each.
 *
 * Spheres, and what maps make of them, are drawn uniformly in the solid angle that they fill before
 * the map as seen from a point outside: exactly the visible half, however near or far. From inside,
 * and of the other shapes, points are drawn by area. */
#ifndef AIR_SCENE_LIGHTS_QUADRIC_LAMP_H
#define AIR_SCENE_LIGHTS_QUADRIC_LAMP_H

#include "scene/lights/light_table.h"
#include "scene/snapshot.h"

/* Fills the entry of a mesh that is a quadric, and that the entry borrows. */
void air_quadric_lamp_build(const air_mesh *mesh, const air_material *material, uint32_t owner,
                            air_light *out);

/* The mean of the radiance over its area, as a weight. */
air_vec3 air_quadric_lamp_mean(const air_light *light);

/* See light_table.h; of the table only how places on spheres are drawn is looked at. */
void air_quadric_lamp_sample(const air_light *light, const air_light_table *table, float u1,
                             float u2, air_light_point *out);
bool air_quadric_lamp_connect(const air_light *light, const air_light_table *table,
                              const air_light_point *light_point, air_vec3 point,
                              air_connection *out);
float air_quadric_lamp_hit_pdf(const air_light *light, const air_light_table *table, air_vec3 from,
                               air_vec3 dir, float distance);

#endif
