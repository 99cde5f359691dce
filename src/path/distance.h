/* distance.h: where along a closed ray the next medium event happens.
 *
 * Two techniques, combined by the one-sample balance heuristic: in proportion to extinction times
 * transmittance (of a channel chosen by throughput, all three entering the density), truncated to
 * the ray; and one that follows the light that will be asked for: equi-angular about a point on it
 * [Kulla2012], or, for a light from infinity, in proportion to what it would send along the ray if
 * nothing were in between (whole-volume sampling, [Velinov2021]). */
#ifndef AIR_PATH_DISTANCE_H
#define AIR_PATH_DISTANCE_H

#include "airlight/collimated.h"
#include "path/ray_media.h"

/* What a light offers for distances to follow: one of the two. */
typedef struct air_distance_guide {
    const air_vec3 *point;                 /* on the light */
    const air_collimated_profile *profile; /* along this ray, not empty */
    float share; /* of the samples that follow the light: those of u below it; in (0, 1] */
} air_distance_guide;

typedef struct air_distance {
    float t;
    size_t segment;
    air_vec3 weight; /* transmittance to t over the density of t, given that an event happens */
    float extinction_share; /* the density by extinction alone over the density of t */
} air_distance;

/* The probability of an event anywhere on the ray under the first technique, channels weighted as
 * throughput has them. */
float air_distance_event_probability(const air_ray_media *ray, air_vec3 throughput);

/* u in [0,1). guide: NULL for extinction alone. The ray must be closed and its optical depth
 * positive. False if the sampled point holds no medium, or if the equi-angular technique was asked
 * for and the light lies on the ray. */
bool air_distance_sample(const air_ray_media *ray, air_vec3 throughput,
                         const air_distance_guide *guide, float u, air_distance *out);

/* Density of air_distance_sample at t. */
float air_distance_sample_pdf(const air_ray_media *ray, air_vec3 throughput,
                              const air_distance_guide *guide, float t);

#endif
