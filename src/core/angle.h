/* angle.h: sines, cosines and angles of float, inline, for the path tracer's inner loop.
 *
 * Largest errors over the stated ranges: air_sincos_eighth and air_sincos_turn 1.2e-7, absolute;
 * air_plane_angle 3e-7, relative (tests/test_core_angle.c). */
#ifndef AIR_CORE_ANGLE_H
#define AIR_CORE_ANGLE_H

#include "core/bits.h"
#include "core/vec.h"

/* |x| <= pi/4: the Taylor series, whose remainders x^11/11! and x^10/10! are below 2e-9 and 3e-8.
 */
static inline void air_sincos_eighth(float x, float *out_sin, float *out_cos)
{
    const float x2 = x * x, x4 = x2 * x2; /* pairs of terms side by side, as in exponential.h */
    const float s =
        (-1.0f / 6.0f + x2 * (1.0f / 120.0f)) + x4 * (-1.0f / 5040.0f + x2 * (1.0f / 362880.0f));
    const float c = (-0.5f + x2 * (1.0f / 24.0f)) + x4 * (-1.0f / 720.0f + x2 * (1.0f / 40320.0f));
    *out_sin = x + x * x2 * s;
    *out_cos = 1.0f + x2 * c;
}

/* Of an angle in turns, 0 <= turn <= 1: quarters are taken off without an error. */
static inline void air_sincos_turn(float turn, float *out_sin, float *out_cos)
{
    const int quarter = (int)(4.0f * turn + 0.5f);
    float s, c;
    air_sincos_eighth(2.0f * AIR_PI_F * (turn - 0.25f * (float)quarter), &s, &c);
    /* by bits: as jumps, which angles at random take at random, they cost more than all the rest */
    const uint32_t odd = 0u - ((uint32_t)quarter & 1u);
    const uint32_t swap = (air_float_bits(s) ^ air_float_bits(c)) & odd;
    const uint32_t sine = air_float_bits(s) ^ swap, cosine = air_float_bits(c) ^ swap;
    *out_sin = air_float_from_bits(sine ^ ((uint32_t)quarter & 2u) << 30);
    *out_cos = air_float_from_bits(cosine ^ ((uint32_t)(quarter + 1) & 2u) << 30);
}

/* The same in doubles, off by 3e-16: remainders x^17/17! and x^18/18! are below 5e-17. */
static inline void air_sincos_turn64(double turn, double *out_sin, double *out_cos)
{
    const int quarter = (int)(4.0 * turn + 0.5);
    const double x = 2.0 * AIR_PI * (turn - 0.25 * (double)quarter);
    const double x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
    const double s =
        ((-1.0 / 6.0 + x2 * (1.0 / 120.0)) + x4 * (-1.0 / 5040.0 + x2 * (1.0 / 362880.0))) +
        x8 * ((-1.0 / 39916800.0 + x2 * (1.0 / 6227020800.0)) - x4 * (1.0 / 1307674368000.0));
    const double c = ((-0.5 + x2 * (1.0 / 24.0)) + x4 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))) +
                     x8 * ((-1.0 / 3628800.0 + x2 * (1.0 / 479001600.0)) +
                           x4 * (-1.0 / 87178291200.0 + x2 * (1.0 / 20922789888000.0)));
    const double sine = x + x * x2 * s, cosine = 1.0 + x2 * c;
    const uint64_t swap = (air_double_bits(sine) ^ air_double_bits(cosine)) &
                          (0u - ((uint64_t)(uint32_t)quarter & 1u));
    const uint64_t across = air_double_bits(sine) ^ swap, along = air_double_bits(cosine) ^ swap;
    *out_sin = air_double_from_bits(across ^ ((uint64_t)(uint32_t)quarter & 2u) << 62);
    *out_cos = air_double_from_bits(along ^ ((uint64_t)(uint32_t)(quarter + 1) & 2u) << 62);
}

/* The angle, in [0, pi], of the plane's vector (x, y), y >= 0, not both 0. Folded to [0, pi/4],
 * then turned back by pi/8 at most: atan(t) = pi/4 + atan((t - 1) / (t + 1)). atan(t)/t for t <=
 * tan(pi/8) as in lanes_angle.h. */
static inline float air_plane_angle(float x, float y)
{
    const float a = fabsf(x);
    const bool steep = y > a;
    const float less = steep ? a : y, more = steep ? y : a;
    const bool wide = less > 0.414213562f * more;
    const float difference = less - more, total = less + more;
    const float t = (wide ? difference : less) / (wide ? total : more), t2 = t * t;
    float sum = -0.0602630526f;
    sum = sum * t2 + 0.105698288f;
    sum = sum * t2 - 0.142395326f;
    sum = sum * t2 + 0.19998183f;
    sum = sum * t2 - 0.333333069f;
    const float small = (wide ? 0.25f * AIR_PI_F : 0.0f) + (t + t * t2 * sum);
    const float rest = 0.5f * AIR_PI_F - small, acute = steep ? rest : small;
    const float obtuse = AIR_PI_F - acute;
    return x < 0.0f ? obtuse : acute;
}

#endif
