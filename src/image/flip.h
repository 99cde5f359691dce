/* flip.h: FLIP, the perceived difference of two pictures when one flips between them
 * [Andersson2020, Andersson2021]. */
#ifndef AIR_IMAGE_FLIP_H
#define AIR_IMAGE_FLIP_H

#include "core/host.h"

/* Two pictures of width x height, three planes of linear R,G,B each. LDR-FLIP is symmetric;
 * HDR-FLIP takes its exposures from the reference. */
typedef struct air_flip_pair {
    const float *reference[3];
    const float *test[3];
    size_t width, height;
    float pixels_per_degree; /* [1, 1000] */
} air_flip_pair;

/* LDR-FLIP of display-linear pictures in [0,1] into out_map, width*height values in [0,1]. */
air_status air_flip_ldr(air_context *context, const air_flip_pair *pair, float *out_map);

/* HDR-FLIP of scene-linear pictures: the largest LDR-FLIP over a range of exposures. Negative
 * values count as 0. */
air_status air_flip_hdr(air_context *context, const air_flip_pair *pair, float *out_map);

/* The first and last exposure (stops) and their number that HDR-FLIP takes for this reference. */
air_status air_flip_exposures(air_context *context, const float *const reference[3],
                              size_t pixel_count, double *out_start, double *out_stop,
                              size_t *out_count);

#endif
