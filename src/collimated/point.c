/* point.c: the integrand of a point light along a ray, in pieces; its integral and samples. */
#include "airlight/point.h"

#include <float.h>
#include <math.h>

#include "collimated/point_piece.h"

double air_point_integral(const air_point_profile *profile)
{
    return profile->scaled > 0.0 && profile->scaled < INFINITY
               ? profile->scaled * exp(-profile->least_depth)
               : profile->scaled;
}

double air_point_log_integral(const air_point_profile *profile)
{
    return log(profile->scaled) - profile->least_depth;
}

/* The piece that holds t; count if none does. */
static size_t find_piece(const air_point_profile *profile, double t)
{
    size_t low = 0, high = profile->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (profile->pieces[middle].t1 < t) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < profile->count && t >= profile->pieces[low].t0 ? low : profile->count;
}

double air_point_partial_integral(const air_point_profile *profile, double begin, double end)
{
    if (!(profile->scaled < INFINITY)) {
        return profile->scaled;
    }
    double sum = 0.0;
    for (size_t i = 0; i < profile->count; i++) {
        air_point_piece part = profile->pieces[i];
        if (begin <= part.t0 && end >= part.t1) {
            sum += part.integral;
            continue;
        }
        part.t0 = fmax(part.t0, begin);
        part.t1 = fmin(part.t1, end);
        if (part.t0 < part.t1) {
            sum += air_point_piece_integral(profile, &part);
        }
    }
    return sum * exp(-profile->least_depth);
}

double air_point_integrand(const air_point_profile *profile, double t)
{
    const size_t i = find_piece(profile, t);
    if (i == profile->count) {
        return 0.0;
    }
    const double u = t - profile->foot;
    return air_point_falloff(profile, u) *
           exp(-profile->sigma_t * air_point_length(profile, &profile->pieces[i], u)) /
           (profile->height * profile->height + u * u);
}

double air_point_sample(const air_point_profile *profile, double u)
{
    const double wanted = u * profile->scaled;
    size_t low = 0, high = profile->count - 1;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        const air_point_piece *p = &profile->pieces[middle];
        if (p->before + p->integral > wanted) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    const air_point_piece *p = &profile->pieces[low];
    const double share = p->integral > 0.0 ? (wanted - p->before) / p->integral : 0.5;
    const double offset = air_point_piece_offset(profile, p, fmin(fmax(share, 0.0), 1.0));
    return fmin(fmax(profile->foot + offset, p->t0), p->t1);
}

double air_point_sample_pdf(const air_point_profile *profile, double t)
{
    const size_t i = find_piece(profile, t);
    if (i == profile->count) {
        return 0.0;
    }
    const air_point_piece *p = &profile->pieces[i];
    const double u = t - profile->foot, angle = air_point_piece_angle(profile, p);
    return angle > 0.0 ? p->integral / profile->scaled /
                             (angle * (profile->height * profile->height + u * u))
                       : 0.0;
}
