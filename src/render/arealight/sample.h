/* sample.h: samples of what lamps send, for visibility: a distance along the camera ray
 * (or the surface it met) and a point of the lamp, with all that arrives if nothing is in between.
 */
#ifndef AIR_RENDER_AREALIGHT_SAMPLE_H
#define AIR_RENDER_AREALIGHT_SAMPLE_H

#include "render/arealight/state.h"

/* A way of light: from the lamp to a point, and to the camera. */
typedef struct area_sample {
    double point[3], source[3]; /* where it is scattered or reflected, and a point of the lamp */
    air_vec3 value;             /* what arrives over the density it was drawn with; 0: none */
    air_vec3 highlight;         /* the same of a surface's highlight, which value leaves out */
} area_sample;

/* A camera ray, and the surface it ends on if any; media in scratch->media. */
typedef struct area_ray {
    double origin[3], dir[3], t_max;
    const air_surface *surface;
    air_vec3 camera_transmittance; /* up to the surface */
} area_ray;

/* u: a number for the distance (volume) and two for the point, in [0, 1). */
area_sample air_area_sample_volume(const air_with_arealight *with, const air_area_scratch *scratch,
                                   const area_lamp *lamp, const area_ray *ray, const double u[3]);
area_sample air_area_sample_surface(const air_with_arealight *with, const area_lamp *lamp,
                                    const area_ray *ray, const double u[2]);

/* Volume-RIS: distances by extinction [Lin2021]. */
area_sample air_area_sample_extinction(const air_with_arealight *with,
                                       const air_area_scratch *scratch, const area_lamp *lamp,
                                       const area_ray *ray, const double u[3]);

#endif
