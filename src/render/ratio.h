/* ratio.h: what one sample brings to the three sums of a ratio estimator. */
#ifndef AIR_RENDER_RATIO_H
#define AIR_RENDER_RATIO_H

#include "core/vec.h"

typedef struct air_ratio_sample {
    air_vec3 analytic, unoccluded, occluded;
} air_ratio_sample;

/* Apart, since what hides a lamp from a surface is not what hides it from the fog before it. */
typedef struct air_lane_ratios {
    air_ratio_sample volume, surface;
} air_lane_ratios;

#endif
