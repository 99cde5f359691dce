/* field.h: the coefficients of a medium at a point, and closed forms for exponential density along
 * a ray. */
#ifndef AIR_SCENE_MEDIA_FIELD_H
#define AIR_SCENE_MEDIA_FIELD_H

#include "scene/media/media.h"

typedef struct air_coefficients {
    air_vec3 sigma_s, sigma_t; /* 1/m */
    air_vec3 emission;         /* W/(m^3 sr) */
} air_coefficients;

/* The coefficients of a medium in one of its regions at a world point inside it. All scale with the
 * density and its detail, emission too; an albedo grid shares sigma_t out between scattering and
 * absorption, an emission grid multiplies emission. Thread-safe. */
air_coefficients air_medium_coefficients(const air_medium *medium, const air_region *region,
                                         air_vec3 point);

/* Likewise at density 1, whatever it is there. */
air_coefficients air_medium_full_coefficients(const air_medium *medium, air_vec3 point);

/* The same as air_medium_coefficients at AIR_LOOKS points at most, which is faster where there is
 * detail, for looks that are width_m apart (metres, >= 0): without what of the detail is too fine
 * for them (air_detail_noise). */
enum { AIR_LOOKS = 32 };
void air_medium_coefficients_run(const air_medium *medium, const air_region *region,
                                 const air_vec3 *points, size_t count, float width_m,
                                 air_coefficients *out);

/* The integral over t of an exponential medium's density at origin + t dir, from t0 to t1 >= t0; t1
 * may be INFINITY. */
float air_exponential_depth(const air_medium *medium, air_vec3 origin, air_vec3 dir, float t0,
                            float t1);

/* The largest density of an exponential medium on that part of the ray. */
float air_exponential_max(const air_medium *medium, air_vec3 origin, air_vec3 dir, float t0,
                          float t1);

/* The end of a piece of the ray from t0 on in which the density changes by about a factor e, or is
 * constant, or nothing. Always beyond t0; may be INFINITY. */
float air_exponential_piece(const air_medium *medium, air_vec3 origin, air_vec3 dir, float t0);

#endif
