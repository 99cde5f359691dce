/* aim.h: directions towards media that are elsewhere. Half of the directions that ask for light by
 * one event go there, or media that fill little of what a receiver sees would be met by few. */
#ifndef AIR_PATH_AIM_H
#define AIR_PATH_AIM_H

#include "scene/media/media.h"

enum { AIR_AIM_MOST = 8 };

/* Cones about the bounding spheres of media. */
typedef struct air_aim {
    size_t count;
    float share; /* of directions to be drawn here: a half, 0 without cones */
    struct {
        air_vec3 axis;
        float opening; /* 1 - cos */
    } cones[AIR_AIM_MOST];
} air_aim;

/* Media whose spheres a point is in have no cone, nor have those after the eighth. */
air_aim air_aim_make(const air_media *media, air_vec3 from);

/* A cone by chance, a direction in it evenly. u in [0, 1). */
air_vec3 air_aim_sample(const air_aim *aim, const float u[3]);
float air_aim_sample_pdf(const air_aim *aim, air_vec3 dir);

#endif
