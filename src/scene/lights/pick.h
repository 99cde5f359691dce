/* pick.h: with which probability each light is chosen. */
#ifndef AIR_SCENE_LIGHTS_PICK_H
#define AIR_SCENE_LIGHTS_PICK_H

#include "scene/lights/light_table.h"

/* Fills table->cdf from the lights' flux. A share of the choices is dealt out evenly among the
 * explicit lights, with all emissive triangles together as one more, so that a lamp is not starved
 * by a sun that hardly comes in. Lights that give nothing have probability 0. */
air_status air_pick_build(air_context *context, air_light_table *table);

/* The flux of a light, W, as the mean over the channels; of lights at infinity what passes the disk
 * around the scene, or the windows if that is less. */
double air_light_flux(const air_light_table *table, const air_light *light);

#endif
