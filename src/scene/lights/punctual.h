/* punctual.h: lights that only shadow rays can find: point, spot, projector, collimated. */
#ifndef AIR_SCENE_LIGHTS_PUNCTUAL_H
#define AIR_SCENE_LIGHTS_PUNCTUAL_H

#include "scene/lights/light_table.h"

/* Sets the falloff between two cone angles. */
void air_spot_set_cone(air_light *light, air_spot_shape falloff, double inner_cone_rad,
                       double outer_cone_rad);
/* Intensity as a share of that on the axis, at the cosine between the axis and a direction away
 * from the light. */
float air_spot_falloff(const air_light *light, float cosine);
/* The integral of the falloff over all directions, sr. */
double air_spot_solid_angle(const air_light *light);
/* 1 - the cosine of the outer cone. */
float air_spot_opening(const air_light *light);

/* Sets the picture (NULL: a white square) and its place from a description. */
void air_projector_set(air_light *light, const air_light_desc *desc,
                       const struct air_texture *image);
/* Intensity over color towards a unit direction away from the light. */
air_vec3 air_projector_share(const air_light *light, air_vec3 dir);
/* The integral of the share over all directions, sr. */
air_vec3 air_projector_solid_angle(const air_light *light);

/* Copies the windows of a collimated light whose frame is set. */
air_status air_windows_build(air_context *context, const air_gobo_window *windows, size_t count,
                             air_light *light);
void air_windows_finish(air_context *context, air_light *light);
/* What the windows are across the light, m^2, overlaps counted twice. */
double air_windows_area(const air_light *light);

void air_punctual_sample(const air_light *light, air_light_point *out);
/* Point, spot and projector. */
bool air_punctual_connect(const air_light *light, air_vec3 point, air_connection *out);
bool air_collimated_connect(const air_light *light, air_vec3 point, air_connection *out);

#endif
