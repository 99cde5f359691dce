/* distance.h: where along a closed ray the next medium event happens.
 *
 * Two techniques, combined by the one-sample balance heuristic: in proportion to extinction times
 * transmittance (of a channel chosen by throughput, all three entering the density), truncated to
 * the ray; and equi-angular about a point on a light [Kulla2012]. */
#ifndef AIR_PATH_DISTANCE_H
#define AIR_PATH_DISTANCE_H

#include "path/ray_media.h"

/* Share of the samples that are equi-angular where a light offers a point: those of u below it. */
#define AIR_EQUIANGULAR_SHARE 0.5f

typedef struct air_distance {
    float t;
    size_t segment;
    air_vec3 weight; /* transmittance to t over the density of t, given that an event happens */
    float extinction_share; /* the density by extinction alone over the density of t */
} air_distance;

/* The probability of an event anywhere on the ray under the first technique, channels weighted as
 * throughput has them. */
float air_distance_event_probability(const air_ray_media *ray, air_vec3 throughput);

/* u in [0,1). light: a point to be equi-angular about, or NULL. The ray must be closed and its
 * optical depth positive. False if the
 * sampled point holds no medium, or if the equi-angular technique was asked for and the light lies
 * on the ray. */
bool air_distance_sample(const air_ray_media *ray, air_vec3 throughput, const air_vec3 *light,
                         float u, air_distance *out);

/* Density of air_distance_sample at t. */
float air_distance_sample_pdf(const air_ray_media *ray, air_vec3 throughput, const air_vec3 *light,
                              float t);

#endif
