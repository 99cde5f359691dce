/* dilate.h: texels that no triangle touches get the value of the nearest one that has one. */
#ifndef AIR_ATLAS_DILATE_H
#define AIR_ATLAS_DILATE_H

#include "atlas/surface.h"
#include "core/host.h"

/* Texels [x, x + width) x [y, y + height) are those of one chart and its padding: free ones among
 * them take values of this chart only. */
typedef struct air_dilate_gutter {
    uint32_t x, y, width, height;
    uint32_t chart;
} air_dilate_gutter;

typedef struct air_dilate_params {
    double radius;   /* texels between centres that values travel, >= 0; default 4 */
    bool everything; /* fill all that is free, however far; default false */
    const air_dilate_gutter *gutters; /* disjoint; borrowed; NULL: the nearest chart whichever */
    size_t gutter_count;
} air_dilate_params;

void air_dilate_params_default(air_dilate_params *params);

/* charts: width * height (coverage.h: air_coverage_planes), AIR_NO_CHART where a texel is free.
 * planes: plane_count planes of width * height floats; free texels within reach are overwritten by
 * the nearest covered one's values, all planes by the same (of several equally near, the one in the
 * upper row, then the leftmost). Others are left alone. Exact, parallel, deterministic; time and
 * 8 bytes of memory per texel. AIR_ERROR_ARGUMENT: a size of 0 or above 65536, a gutter that leaves
 * the page, a radius that is negative or not a number. */
air_status air_dilate(air_context *context, size_t width, size_t height, const uint32_t *charts,
                      const air_dilate_params *params, float *const *planes, size_t plane_count);

#endif
