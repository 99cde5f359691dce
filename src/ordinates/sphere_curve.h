/* sphere_curve.h: a curve through the whole sphere whose pieces of equal length have equal solid
 * angle and are compact: Hilbert's, on the square that the equal-area octahedral map gives
 * [Clarberg2008]. */
#ifndef AIR_ORDINATES_SPHERE_CURVE_H
#define AIR_ORDINATES_SPHERE_CURVE_H

#include <math.h>
#include <stdint.h>

#include "core/vec.h"

enum { SPHERE_CURVE_BITS = 16 }; /* of each coordinate of the square */

/* Where along Hilbert's curve (x, y) is: all of 32 bits, each once. */
static inline uint32_t sphere_curve_square(uint32_t x, uint32_t y)
{
    uint32_t place = 0;
    for (uint32_t s = 1u << (SPHERE_CURVE_BITS - 1); s > 0; s >>= 1) {
        const uint32_t right = (x & s) != 0, upper = (y & s) != 0;
        place = (place << 2) | ((3 * right) ^ upper);
        if (!upper) { /* turn the quarter so that its curve joins its neighbours' */
            const uint32_t flip = right ? (1u << SPHERE_CURVE_BITS) - 1 : 0;
            const uint32_t keep = x ^ flip;
            x = y ^ flip;
            y = keep;
        }
    }
    return place;
}

/* The direction with cosine `up` to the pole and longitude `turns` quarters of a circle, in [0, 4).
 * The upper hemisphere is the diamond within the square, the lower one is folded into its corners.
 */
static inline uint32_t sphere_curve_place(double up, double turns)
{
    const double radius = sqrt(double_max(0.0, 1.0 - fabs(up)));
    const int quarter = (int)turns & 3;
    const double part = radius * double_min(1.0, turns - floor(turns));
    const double ahead = quarter & 1 ? part : radius - part; /* |x| + |y| = radius */
    double x = up < 0.0 ? 1.0 - (radius - ahead) : ahead;
    double y = up < 0.0 ? 1.0 - ahead : radius - ahead;
    x = quarter == 1 || quarter == 2 ? -x : x;
    y = quarter >= 2 ? -y : y;
    const double side = 1u << SPHERE_CURVE_BITS;
    const uint32_t column = (uint32_t)double_min(0.5 * (x + 1.0) * side, side - 1.0);
    const uint32_t row = (uint32_t)double_min(0.5 * (y + 1.0) * side, side - 1.0);
    return sphere_curve_square(column, row);
}

#endif
