/* cdf.h: choosing one of many by cumulative probabilities: i is chosen by u in [cdf[i-1], cdf[i]);
 * the last is 1. */
#ifndef AIR_SCENE_LIGHTS_CDF_H
#define AIR_SCENE_LIGHTS_CDF_H

#include <stddef.h>

#include "core/vec.h"

static inline float air_cdf_start(const float *cdf, size_t i) { return i > 0 ? cdf[i - 1] : 0.0f; }

/* u in [0, 1) comes back as where it lay within the interval, again in [0, 1). */
static inline size_t air_cdf_choose(const float *cdf, size_t count, float *u)
{
    size_t low = 0, high = count - 1;
    if (count == 1) {
        return 0;
    }
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (cdf[middle] > *u) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    const float start = air_cdf_start(cdf, low);
    *u = float_min((*u - start) / (cdf[low] - start), 0x1.fffffep-1f);
    return low;
}

#endif
