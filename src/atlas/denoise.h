/* denoise.h: noise out of texels, over surfaces instead of over the page.
 *
 * Non-local means [Rousselle2012] with the texels' own variances: two texels are averaged where
 * their neighbourhoods differ by no more than their noise explains, so what has converged stays and
 * the edges of shadows do. Neighbours are of one chart, close in space, and face alike. */
#ifndef AIR_ATLAS_DENOISE_H
#define AIR_ATLAS_DENOISE_H

#include "atlas/surface.h"
#include "core/host.h"

enum { AIR_ATLAS_DENOISE_PLANES = 16 };

/* Planes of width * height; borrowed. */
typedef struct air_atlas_guides {
    size_t width, height;
    const uint32_t *charts;   /* AIR_NO_CHART: free, takes no part */
    const float *position[3]; /* metres */
    const float *normal[3];   /* need not be unit */
    const float *area;        /* covered, (0, 1]: the texel's weight for others; NULL: 1 */
} air_atlas_guides;

/* Planes filtered with the same weights, which are made from all of them: colours, and layers of
 * light of the same texels too. The more planes with noise of their own, the better neighbourhoods
 * can be told apart; that is worth more than the edges of one layer cost another
 * (test_atlas_denoise.c). variance[k]: of the mean that planes[k] holds, >= 0. */
typedef struct air_atlas_layer {
    float *const *planes;
    const float *const *variance;
    size_t plane_count; /* 1 to AIR_ATLAS_DENOISE_PLANES */
} air_atlas_layer;

typedef struct air_atlas_denoise_params {
    uint32_t radius;         /* texels searched on each side, 1 to 20; default 5 */
    double strength;         /* so many standard deviations count as 1, > 0; default 0.8 */
    double normal_angle_rad; /* between neighbours' normals at most, (0, pi]; default 25 degrees */
    double plane_distance;   /* texels that a neighbour may lie off a texel's plane; default 1 */
} air_atlas_denoise_params;

void air_atlas_denoise_params_default(air_atlas_denoise_params *params);

/* Filters in place, outliers first (outliers.h). Texels with numbers that are not finite take no
 * part. Parallel over bands of rows, deterministic. Time: (2 radius + 1)^2 times about 15 ns a
 * texel and processor for three planes; memory: two floats per texel and plane, and six.
 * AIR_ERROR_ARGUMENT: a parameter, size or count out of range. */
air_status air_atlas_denoise(air_context *context, const air_atlas_guides *guides,
                             const air_atlas_denoise_params *params, const air_atlas_layer *layer);

#endif
