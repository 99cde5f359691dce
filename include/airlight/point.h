/* point.h: single scattering of point and spot lights in a homogeneous convex medium.
 *
 * A kernel like collimated.h, whose media and conventions it shares: a ray is origin + t dir with
 * dir unit, lengths in metres; no allocation per ray, thread-safe. The light may be outside the
 * medium, inside it or on its boundary; only the part of its way inside attenuates. With r the
 * distance from a point at t to the light and d(t) the part of it inside the medium, the integrand
 * is falloff exp(-sigma_t (t - a + d(t))) / r^2, a where the ray comes in: times intensity, sigma_s
 * and phase function it is radiance. It has no elementary integral. The ray is cut into pieces,
 * between which another face is the nearest to the light and on which the integrand is smooth in
 * the equi-angular variable [Kulla2012]; each takes Gauss-Legendre quadrature of 10 points.
 * Relative error of an integral: below 1e-10; 1e-9 where the light is within 1e-5 of a face
 * (src/collimated/README-point.md). */
#ifndef AIRLIGHT_POINT_H
#define AIRLIGHT_POINT_H

#include <stdbool.h>
#include <stddef.h>

#include "airlight/collimated.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct air_point_light {
    double position[3];
    bool is_spot;   /* false: the rest is not read */
    double axis[3]; /* unit, the way the light travels */
    /* 0 <= inner <= outer <= pi/2. Nothing beyond outer; in between the falloff of
     * KHR_lights_punctual, a square of what is linear in the cosine and rises over 0.001 of it at
     * least. */
    double inner_cone_rad, outer_cone_rad;
} air_point_light;

/* A piece [t0, t1]; d = r N / (N + c), N = no - nv t, for the face that the light comes in through.
 */
typedef struct air_point_piece {
    double t0, t1;
    double no, nv, c;
    double integral; /* times exp(least_depth) */
    double before;   /* the sum of those before */
} air_point_piece;

enum { AIR_POINT_MAX_PIECES = 384 };

/* The integrand along one ray. Its integral is exp(-least_depth) * scaled: kept apart, so that
 * sampling works where the integral underflows. */
typedef struct air_point_profile {
    air_point_piece *pieces; /* the caller's array */
    size_t capacity;         /* its length, at least AIR_POINT_MAX_PIECES; the caller's too */
    size_t count;            /* 0: no light, or infinitely much */
    double least_depth;
    double scaled;       /* INFINITY where the light itself lies on the ray, within rounding */
    double begin;        /* a */
    double foot, height; /* t of the point nearest to the light, and its distance from it */
    double sigma_t;
    double axis_foot, axis_slope; /* spot: the axis times light-to-point, at the foot and per t */
    double falloff_scale, falloff_offset;
} air_point_profile;

/* The profile up to the first surface at t_max (which may be INFINITY). sigma_t: 1/m, >= 0. What is
 * not finite (but t_max) gives an empty profile, never NaN. Where pieces run out (none of the
 * measured cases needs more than half), the last ones are coarse. */
AIR_API void air_point_profile_make(const air_collimated_medium *medium,
                                    const air_point_light *light, double sigma_t,
                                    const double origin[3], const double dir[3], double t_max,
                                    air_point_profile *profile);

/* The integral, 1/m. INFINITY iff the light lies on the ray's lit stretch inside the medium. */
AIR_API double air_point_integral(const air_point_profile *profile);
/* Its logarithm; -INFINITY for an empty profile; no underflow. */
AIR_API double air_point_log_integral(const air_point_profile *profile);
/* The integral over [begin, end] only, for stretches that are not in shadow; INFINITY wherever
 * that of the whole is. */
AIR_API double air_point_partial_integral(const air_point_profile *profile, double begin,
                                          double end);
/* The integrand at t, 1/m^2; 0 outside the pieces. */
AIR_API double air_point_integrand(const air_point_profile *profile, double t);

/* t with a density close to integrand over integral: a piece in proportion to its integral, in it
 * equi-angular. u in [0, 1). The profile must have pieces. Averages of integrand / pdf times
 * visibility are unbiased; over averages of integrand / pdf, times the integral, they are the ratio
 * estimator. */
AIR_API double air_point_sample(const air_point_profile *profile, double u);
AIR_API double air_point_sample_pdf(const air_point_profile *profile, double t);

/* The stretch of a ray within [begin, end] that a spot's outer cone lights; all of it for a point
 * light; false if none. */
AIR_API bool air_point_cone_interval(const air_point_light *light, const double origin[3],
                                     const double dir[3], double begin, double end,
                                     air_interval *out);

#ifdef __cplusplus
}
#endif
#endif
