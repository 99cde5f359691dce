/* denoise.h: noise out of texels, over surfaces instead of over the page.
 *
 * Non-local means with the texels' own variances: two texels are averaged where their
 * neighbourhoods differ by no more than their noise explains, so what has converged stays.
 * Neighbours are of one chart, close in space, and face alike. */
#ifndef AIR_ATLAS_DENOISE_H
#define AIR_ATLAS_DENOISE_H

#include "atlas/surface.h"
#include "core/host.h"

/* Planes of width * height; borrowed. */
typedef struct air_atlas_guides {
    size_t width, height;
    const uint32_t *charts;   /* AIR_NO_CHART: free, takes no part */
    const float *position[3]; /* metres */
    const float *normal[3];   /* need not be unit */
    const float *area;        /* covered, (0, 1]; NULL: 1 */
} air_atlas_guides;

/* One layer: planes filtered with the same weights, made from all of them. variance[k]: of the mean
 * that planes[k] holds, >= 0. */
typedef struct air_atlas_layer {
    float *const *planes;
    const float *const *variance;
    size_t plane_count; /* 1 to 16 */
} air_atlas_layer;

typedef struct air_atlas_denoise_params {
    uint32_t radius; /* texels searched on each side, 1 to 20; default 7 */
    double strength; /* of the filter: differences are measured in strength times the noise's
                        standard deviation; > 0; default 0.6 */
    double normal_angle_rad; /* weights are 0 beyond, (0, pi]; default 25 degrees */
    double plane_distance;   /* texels that a neighbour may lie off the texel's plane; default 1 */
} air_atlas_denoise_params;

void air_atlas_denoise_params_default(air_atlas_denoise_params *params);

/* Filters in place. Values that are not finite take no part. Parallel over rows, deterministic.
 * AIR_ERROR_ARGUMENT: a parameter out of range. */
air_status air_atlas_denoise(air_context *context, const air_atlas_guides *guides,
                             const air_atlas_denoise_params *params, const air_atlas_layer *layer);

#endif
