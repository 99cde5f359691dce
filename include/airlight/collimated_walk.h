/* collimated_walk.h: multiple scattering of light from infinity in one homogeneous convex medium
 * [Velinov2021, sec. 6].
 *
 * A kernel, as collimated.h. A walk starts at the camera and scatters up to a number of times; at
 * every event the light is connected directly, and the integral along the whole segment serves the
 * ratio estimators. Surfaces absorb: they end segments and throw shadows, no light comes from them.
 * Reflected light would be added to the plain estimate only.
 *
 * Grey: one extinction for all channels. For a coloured medium one walk per channel is right, or
 * distances of one channel and weights of all (not done here). */
#ifndef AIRLIGHT_COLLIMATED_WALK_H
#define AIRLIGHT_COLLIMATED_WALK_H

#include "airlight/collimated.h"
#include "airlight/medium.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How the distance of an event is drawn. With whole-volume distances every event gives its analytic
 * value times visibility, but the walk goes on with weights that grow as exp(sigma_t d), d the
 * distance of the event from the boundary towards the light: noisy deep inside. The mixture takes
 * either with chance 1/2 and weighs by the balance heuristic, so its weights stay below twice those
 * by extinction. */
typedef enum air_collimated_distance {
    AIR_COLLIMATED_DISTANCE_UNIFORM = AIR_COLLIMATED_RM,    /* plain: RM; ratio: REES */
    AIR_COLLIMATED_DISTANCE_EXTINCTION = AIR_COLLIMATED_DS, /* truncated to the segment; DS, REDS */
    AIR_COLLIMATED_DISTANCE_WHOLE_VOLUME = AIR_COLLIMATED_WVDS, /* WVDS */
    AIR_COLLIMATED_DISTANCE_MIXTURE = 3,                        /* of the two before */
    AIR_COLLIMATED_DISTANCE_COUNT = 4
} air_collimated_distance;

/* A phase function that depends on the angle only; cos_theta is between the directions of travel
 * before and after. */
typedef struct air_collimated_phase {
    double (*eval)(void *user, double cos_theta); /* 1/sr */
    double (*sample)(void *user, double u);       /* cos_theta with density 2 pi eval; u in [0,1) */
    void *user;
} air_collimated_phase;

/* What surrounds the walk. */
typedef struct air_collimated_surroundings {
    /* The distance to the first opaque surface, INFINITY if there is none. NULL: no surfaces. */
    double (*surface)(void *user, const double origin[3], const double dir[3]);
    /* Does something opaque lie between the point and the light? NULL: nothing does. */
    bool (*occluded)(void *user, const double point[3]);
    void *user;
} air_collimated_surroundings;

typedef struct air_collimated_walk_params {
    const air_collimated_medium *medium; /* borrowed */
    double to_light[3];
    double sigma_t, sigma_s; /* 1/m, 0 <= sigma_s <= sigma_t */
    double irradiance;       /* E_perp, across the light, before the medium: W/m^2 */
    air_phase phase;
    const air_collimated_phase *own_phase; /* borrowed; NULL: phase above */
    air_collimated_distance distance;
    size_t max_events; /* scattering events at most; 1: single scattering */
    /* From the second event on, walks of a throughput below this go on with chance throughput /
     * roulette; 0: never by chance. */
    double roulette;
    air_collimated_surroundings surroundings;
} air_collimated_walk_params;

/* No medium yet; light from +y, sigma_t = sigma_s = 0, irradiance 1, isotropic, MIXTURE, 64 events,
 * roulette 1/4, no surroundings. */
AIR_API void air_collimated_walk_params_default(air_collimated_walk_params *params);

/* AIR_ERROR_ARGUMENT (told to context, which may be NULL) names what is out of range. */
AIR_API air_status air_collimated_walk_check(air_context *context,
                                             const air_collimated_walk_params *params);

/* One walk along origin + t dir: the sums over its events, in units of radiance; occluded is also
 * the plain estimate of scattered radiance. random gives numbers in [0, 1): per event one for the
 * distance, then, if the walk goes on, one for roulette where it applies, two for the direction.
 * params must have passed the check. Thread-safe as far as the callbacks are. */
AIR_API air_collimated_sums air_collimated_walk(const air_collimated_walk_params *params,
                                                const double origin[3], const double dir[3],
                                                double (*random)(void *user), void *random_user);

#ifdef __cplusplus
}
#endif
#endif
