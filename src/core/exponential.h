/* exponential.h: exp(-x), 1 - exp(-x) and -log(1 - y) of float, inline, for the path tracer's inner
 * loop.
 *
 * Calls into the C library were 15 % of the time of a picture of haze; these are half of that.
 * Largest relative errors, over all floats of the stated ranges: air_exp 1e-7,
 * air_transmittance_and_loss 2e-7, air_neg_log1m 2.4e-7 (tests/test_core_exponential.c). */
#ifndef AIR_CORE_EXPONENTIAL_H
#define AIR_CORE_EXPONENTIAL_H

#include "core/bits.h"

/* exp(x) - 1 = 2^n (p + 1) - 1 with x = n ln 2 + r, |r| <= ln 2 / 2, and p = exp(r) - 1 by its
 * Taylor polynomial of degree 7, whose remainder r^8/8! is below 6e-9. Gives p; *power is 2^n. -87
 * < x <= 0. */
static inline float air_exp_parts(float x, float *power)
{
    const float n = (float)(int32_t)(x * 1.44269504f - 0.5f);
    const float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    const float r2 = r * r; /* pairs of terms side by side: half the latency of Horner's rule */
    const float p23 = 0.5f + r * (1.0f / 6.0f);
    const float p45 = 1.0f / 24.0f + r * (1.0f / 120.0f);
    const float p67 = 1.0f / 720.0f + r * (1.0f / 5040.0f);
    *power = air_float_from_bits((uint32_t)((int32_t)n + 127) << 23);
    return r + r2 * (p23 + r2 * (p45 + r2 * p67));
}

/* exp(x) for x <= 0; 0 below -87. */
static inline float air_exp(float x)
{
    if (!(x > -87.0f)) {
        return x != x ? x : 0.0f;
    }
    float power;
    const float p = air_exp_parts(x, &power);
    return (p + 1.0f) * power;
}

/* exp(-x) and 1 - exp(-x) for x >= 0, both to full relative accuracy: with n = 0 the latter is -p
 * itself, with n <= -1 it is at least 0.29 and nothing cancels. */
static inline void air_transmittance_and_loss(float x, float *transmittance, float *loss)
{
    if (!(x < 87.0f)) {
        *transmittance = x != x ? x : 0.0f;
        *loss = 1.0f - *transmittance;
        return;
    }
    float power;
    const float p = air_exp_parts(-x, &power);
    *transmittance = (p + 1.0f) * power;
    *loss = (1.0f - power) - p * power;
}

/* -log(1 - y) for 0 <= y < 1. With 1 - y = 2^n m, m in [1/sqrt 2, sqrt 2), log m = 2 atanh(s), s =
 * (m-1)/(m+1), |s| < 0.172: the series to s^9 leaves s^11/11 below 4e-10. Near y = 0, where 1 - y
 * loses digits, s comes from y itself. */
static inline float air_neg_log1m(float y)
{
    const float z = 1.0f - y;
    const uint32_t bits = air_float_bits(z) - 0x3f3504f3u; /* bits of 1/sqrt 2 */
    const float n = (float)((int32_t)bits >> 23);          /* 0 near y = 0 */
    const float m = air_float_from_bits((bits & 0x007fffffu) + 0x3f3504f3u);
    const float less = 1.0f - m, more = 1.0f + m, whole = 2.0f - y;
    const float s = (y < 0.25f ? y : less) / (y < 0.25f ? whole : more);
    const float q = s * s;
    float p = 2.0f / 9.0f;
    p = p * q + 2.0f / 7.0f;
    p = p * q + 2.0f / 5.0f;
    p = p * q + 2.0f / 3.0f;
    return (p * q * s + 2.0f * s) - n * 0.693147181f;
}

#endif
