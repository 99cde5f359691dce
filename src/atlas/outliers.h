/* outliers.h: light that by chance a few texels found for all of their surroundings.
 *
 * A path that is rare and bright (a firefly) gives one texel the light that many should have had a
 * little of. A filter by neighbourhoods finds nothing like such a texel, or by its variance
 * everything, and then shows the window that it searched. So these texels are told by their noise,
 * they get what their neighbours have, and what they had more is spread over the surroundings:
 * smoothly, none of it lost. */
#ifndef AIR_ATLAS_OUTLIERS_H
#define AIR_ATLAS_OUTLIERS_H

#include <stdbool.h>

#include "atlas/surface.h"

enum { AIR_OUTLIER_RADIUS = 14 /* texels that their light is spread over, on each side */ };

/* Planes of width * height, borrowed. */
typedef struct air_outlier_surface {
    size_t width, height;
    const uint32_t *charts;   /* AIR_NO_CHART: takes no part */
    const float *position[3]; /* metres */
    const float *normal[3];   /* unit */
    const float *area;        /* covered; NULL: 1 */
    const float *spacing;     /* metres from a texel to the next */
    float least_cosine, plane_distance;
} air_outlier_surface;

/* Is a texel of a plane an outlier? Of the others within two texels at most a sixth come within
 * three of their deviations of its value or have half of its deviation; and three of its own
 * explain what it has more, so that what is bright and certain is none. */
bool air_outlier_is(const air_outlier_surface *surface, const float *values, const float *variance,
                    size_t texel);

/* What an outlier had more than its neighbours. */
typedef struct air_outlier {
    size_t texel;
    float light; /* by the area covered */
} air_outlier;

/* Texels of a plane whose marks have the bit become their neighbours' mean, and what they had more
 * is spread. list: room for all of them. */
void air_outliers_spread(const air_outlier_surface *surface, const uint16_t *marks, uint16_t bit,
                         air_outlier *list, float *values);

#endif
