/* tracking.h: what cannot be had in closed form: delta tracking for collisions, ratio tracking for
 * transmittance and for the emission of varying media, both with local majorants (bricks of the
 * grids, maxima of exponential media; of detailed media these times the most that detail makes of
 * them).
 *
 * One majorant serves all channels, so coloured media need no extra pdf: the choice between real
 * and null collision is made with a probability of its own and every channel is weighted ("spectral
 * tracking" [Kutz2017]). */
#ifndef AIR_PATH_TRACKING_H
#define AIR_PATH_TRACKING_H

#include "core/random.h"
#include "path/ray_media.h"

/* An unbiased estimate, per channel, of the transmittance of the ray from its origin to t
 * [Novak2014]. */
air_vec3 air_track_transmittance(const air_ray_media *ray, float t, air_rng *rng);

/* An unbiased estimate of the radiance that emissive media of the whole ray send to its origin. */
air_vec3 air_track_emission(const air_ray_media *ray, air_rng *rng);

typedef struct air_collision {
    bool happened;
    float t;
    size_t segment;
    /* Of the path's throughput. A collision is still to be multiplied by sigma_s times the phase
     * function; without one this is the weight of what lies at the end of the ray. */
    air_vec3 weight;
} air_collision;

/* Delta tracking along the whole ray. throughput steers the choice between real and null collisions
 * in coloured media. */
air_collision air_track_collision(const air_ray_media *ray, air_vec3 throughput, air_rng *rng);

#endif
