/* pieces.h: one piece of a profile: its integral, its part, its sum with the others. */
#ifndef AIR_COLLIMATED_PIECES_H
#define AIR_COLLIMATED_PIECES_H

#include <math.h>

#include "airlight/collimated.h"

/* What lies this far in optical depth behind a point adds nothing to an integral that holds the
 * point: exp(-800) is 0 in double. It ends stretches without end. */
#define AIR_COLLIMATED_OPAQUE 800.0

/* phi(x) = (1 - exp(-x))/x, the mean of exp over [-x, 0]; x >= 0. Below 0.7, where the difference
 * would cancel, exp(-x/2) sinh(y)/y with y = x/2: the series left out after y^12 starts at y^14/15!
 * < 4e-19. Relative error below 4 epsilon (tests/test_collimated_profile.c). */
static inline double air_mean_transmittance(double x)
{
    if (x < 0.7) {
        const double q = 0.25 * x * x, q2 = q * q;
        const double sinhc =
            (1.0 + q * (1.0 / 6.0)) + q2 * (1.0 / 120.0 + q * (1.0 / 5040.0)) +
            q2 * q2 * (1.0 / 362880.0 + q * (1.0 / 39916800.0) + q2 * (1.0 / 6227020800.0));
        return exp(-0.5 * x) * sinhc;
    }
    return x < 40.0 ? (1.0 - exp(-x)) / x : 1.0 / x; /* exp(-40) is below half an epsilon */
}

static inline double air_piece_length(const air_collimated_piece *p) { return p->t1 - p->t0; }

/* Of all pieces together. */
static inline double air_profile_length(const air_collimated_profile *profile)
{
    double total = 0.0;
    for (size_t i = 0; i < profile->count; i++) {
        total += air_piece_length(&profile->pieces[i]);
    }
    return total;
}

static inline double air_piece_interpolate(double at0, double at1, double s)
{
    return at0 + (at1 - at0) * s;
}

static inline double air_piece_depth(const air_collimated_piece *p, double t)
{
    return air_piece_interpolate(p->depth0, p->depth1, (t - p->t0) / (p->t1 - p->t0));
}

/* The integral of weight exp(least_depth - depth) over a piece. Integrated from its thinner end, so
 * that nothing overflows. */
static inline double air_piece_integral(const air_collimated_piece *p, double least_depth)
{
    const double least = p->depth0 < p->depth1 ? p->depth0 : p->depth1;
    const double x = fabs(p->depth1 - p->depth0);
    const double thin = least == least_depth ? 1.0 : exp(least_depth - least);
    return p->weight * (p->t1 - p->t0) * thin * air_mean_transmittance(x);
}

/* The part of a piece within [begin, end], which it must meet. */
static inline air_collimated_piece air_piece_part(const air_collimated_piece *p, double begin,
                                                  double end)
{
    air_collimated_piece part = *p;
    const double length = p->t1 - p->t0;
    if (begin > p->t0) {
        const double s = (begin - p->t0) / length;
        part.t0 = begin;
        part.depth0 = air_piece_interpolate(p->depth0, p->depth1, s);
        part.camera0 = air_piece_interpolate(p->camera0, p->camera1, s);
    }
    if (end < p->t1) {
        const double s = (end - p->t0) / length;
        part.t1 = end;
        part.depth1 = air_piece_interpolate(p->depth0, p->depth1, s);
        part.camera1 = air_piece_interpolate(p->camera0, p->camera1, s);
    }
    return part;
}

static inline void air_profile_clear(air_collimated_profile *profile)
{
    profile->count = 0;
    profile->least_depth = 0.0;
    profile->scaled = 0.0;
}

/* least_depth, the sums before each piece and scaled, from everything else. A profile whose
 * integral is 0 or not finite becomes empty. */
static inline void air_profile_sum(air_collimated_profile *profile)
{
    double least = INFINITY, sum = 0.0;
    for (size_t i = 0; i < profile->count; i++) {
        const air_collimated_piece *p = &profile->pieces[i];
        least = p->depth0 < least ? p->depth0 : least;
        least = p->depth1 < least ? p->depth1 : least;
    }
    for (size_t i = 0; i < profile->count; i++) {
        profile->pieces[i].before = sum;
        sum += air_piece_integral(&profile->pieces[i], least);
    }
    profile->least_depth = least;
    profile->scaled = sum;
    if (!(sum > 0.0 && sum < INFINITY)) {
        air_profile_clear(profile);
    }
}

#endif
