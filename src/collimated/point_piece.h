/* point_piece.h: one piece of a point light's profile. Offsets u are from the foot, u = t - foot.
 */
#ifndef AIR_COLLIMATED_POINT_PIECE_H
#define AIR_COLLIMATED_POINT_PIECE_H

#include <math.h>

#include "airlight/point.h"

/* Metres inside the medium, camera to point to light: E of the specification. */
static inline double air_point_length(const air_point_profile *profile,
                                      const air_point_piece *piece, double u)
{
    const double r = sqrt(profile->height * profile->height + u * u);
    const double n = fmax(piece->no - piece->nv * (profile->foot + u), 0.0);
    const double share = n + piece->c > 0.0 ? n / (n + piece->c) : 1.0;
    return (profile->foot - profile->begin) + u + r * share;
}

/* The falloff of KHR_lights_punctual; scale 0 for what has none. */
static inline double air_point_falloff(const air_point_profile *profile, double u)
{
    if (profile->falloff_scale == 0.0) {
        return 1.0;
    }
    const double r = sqrt(profile->height * profile->height + u * u);
    const double cosine = r > 0.0 ? (profile->axis_foot + profile->axis_slope * u) / r : 1.0;
    const double x = cosine * profile->falloff_scale + profile->falloff_offset;
    const double clamped = fmin(fmax(x, 0.0), 1.0);
    return clamped * clamped;
}

/* The integral of 1/r^2: the angle that the light sees the piece under, over the height. It has a
 * limit where the height is 0 and the light beside the piece. */
static inline double air_point_angle(double height, double u0, double u1)
{
    return height > 0.0 ? atan2(height * (u1 - u0), height * height + u0 * u1) / height
                        : 1.0 / u0 - 1.0 / u1;
}

static inline double air_point_piece_angle(const air_point_profile *profile,
                                           const air_point_piece *piece)
{
    return air_point_angle(profile->height, piece->t0 - profile->foot, piece->t1 - profile->foot);
}

/* The offset after a share of the angle, by the addition theorem of the tangent: finite differences
 * of angles near pi/2 never occur. angle: air_point_piece_angle. */
static inline double air_point_offset(double height, double u0, double angle, double share)
{
    const double slope = height > 0.0 ? tan(share * angle * height) / height : share * angle;
    return (u0 + height * height * slope) / (1.0 - u0 * slope);
}

static inline double air_point_piece_offset(const air_point_profile *profile,
                                            const air_point_piece *piece, double share)
{
    return air_point_offset(profile->height, piece->t0 - profile->foot,
                            air_point_piece_angle(profile, piece), share);
}

/* The integral over the piece times exp(least_depth). */
double air_point_piece_integral(const air_point_profile *profile, const air_point_piece *piece);

#endif
