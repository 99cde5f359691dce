/* random_geometry.h: random numbers, directions and frames in doubles. */
#ifndef AIR_TESTS_RANDOM_GEOMETRY_H
#define AIR_TESTS_RANDOM_GEOMETRY_H

#include <math.h>

#include "core/random.h"

/* [0, 1), 53 bits */
static inline double random_unit(air_rng *rng)
{
    const uint64_t high = air_rng_next(rng) >> 5, low = air_rng_next(rng) >> 6;
    return (double)(high << 26 | low) * 0x1p-53;
}

static inline double random_between(air_rng *rng, double low, double high)
{
    return low + (high - low) * random_unit(rng);
}

static inline double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = a[j] * b[k] - a[k] * b[j];
    }
}

static inline void normalise(double v[3])
{
    const double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) {
        v[i] /= length;
    }
}

static inline void random_direction(air_rng *rng, double out[3])
{
    do {
        for (int i = 0; i < 3; i++) {
            out[i] = random_between(rng, -1.0, 1.0);
        }
    } while (!(dot(out, out) > 1e-3 && dot(out, out) < 1.0));
    normalise(out);
}

/* Three orthonormal rows, right-handed. */
static inline void random_frame(air_rng *rng, double out[3][3])
{
    random_direction(rng, out[0]);
    double other[3];
    do {
        random_direction(rng, other);
        cross(out[0], other, out[1]);
    } while (dot(out[1], out[1]) < 1e-2);
    normalise(out[1]);
    cross(out[0], out[1], out[2]);
}

#endif
