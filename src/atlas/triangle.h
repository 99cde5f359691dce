/* triangle.h: areas of triangles on a page and in space, and which of them are none. */
#ifndef AIR_ATLAS_TRIANGLE_H
#define AIR_ATLAS_TRIANGLE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/triple.h"
#include "core/vec.h"

/* Positive where a, b, c is counterclockwise (y upwards). */
static inline double air_doubled_area(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* An area below 2^-40 of the longest side squared is that of rounding. NaN is flat. */
static inline bool air_triangle_is_flat(double doubled_area, double longest_squared)
{
    return !(doubled_area > 0x1p-40 * longest_squared) || !isfinite(doubled_area);
}

/* Across the triangle of three vertices, as long as twice its area. False where it is flat. */
static inline bool air_triangle_normal(const float *positions, const uint32_t vertices[3],
                                       double out[3])
{
    double p[3][3], side[3][3], longest = 0.0;
    for (int i = 0; i < 3; i++) {
        for (size_t k = 0; k < 3; k++) {
            p[i][k] = (double)positions[3 * (size_t)vertices[i] + k];
        }
    }
    for (int i = 0; i < 3; i++) {
        air_subtract3(p[(i + 1) % 3], p[i], side[i]);
        longest = double_max(longest, air_dot3(side[i], side[i]));
    }
    air_cross3(side[0], side[1], out);
    return !air_triangle_is_flat(air_length3(out), longest);
}

#endif
