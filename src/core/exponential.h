/* exponential.h: exp, 1 - exp(-x) and -log(1 - y) of float, inline, for the path tracer's inner loop.
 *
 * Calls into the C library were 15 % of the time of a picture of haze; these are half of that. Largest relative errors, over all
 * floats of the stated ranges: air_exp 1.1e-7, air_loss 1.6e-7, air_neg_log1m 2.4e-7 (tests/test_core_exponential.c). */
#ifndef AIR_CORE_EXPONENTIAL_H
#define AIR_CORE_EXPONENTIAL_H

#include <stdint.h>
#include <string.h>

static inline float air_float_from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline uint32_t air_float_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* exp(x) for x <= 0; 0 below -87. x = n ln 2 + r with |r| <= ln 2 / 2, then the Taylor polynomial of degree 7, whose
 * remainder r^8/8! is below 6e-9. */
static inline float air_exp(float x)
{
    if (!(x > -87.0f)) {
        return x != x ? x : 0.0f;
    }
    const float n = (float)(int32_t)(x * 1.44269504f - 0.5f);
    const float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
    float p = 1.0f / 5040.0f;
    p = p * r + 1.0f / 720.0f;
    p = p * r + 1.0f / 120.0f;
    p = p * r + 1.0f / 24.0f;
    p = p * r + 1.0f / 6.0f;
    p = p * r + 0.5f;
    p = p * r * r + r + 1.0f;
    return p * air_float_from_bits((uint32_t)((int32_t)n + 127) << 23);
}

/* 1 - exp(-x) for x >= 0. Below 1/2 the Taylor polynomial of degree 8 (remainder x^9/9!, relative 1e-8), above without
 * cancellation worth speaking of. */
static inline float air_loss(float x)
{
    if (x > 0.5f) {
        return 1.0f - air_exp(-x);
    }
    float p = -1.0f / 40320.0f;
    p = p * x + 1.0f / 5040.0f;
    p = p * x - 1.0f / 720.0f;
    p = p * x + 1.0f / 120.0f;
    p = p * x - 1.0f / 24.0f;
    p = p * x + 1.0f / 6.0f;
    p = p * x - 0.5f;
    return p * x * x + x;
}

/* -log(1 - y) for 0 <= y < 1. With 1 - y = 2^n m, m in [1/sqrt 2, sqrt 2), log m = 2 atanh(s), s = (m-1)/(m+1), |s| < 0.172:
 * the series to s^9 leaves s^11/11 below 4e-10. Near y = 0, where 1 - y loses digits, s comes from y itself. */
static inline float air_neg_log1m(float y)
{
    float s, n = 0.0f;
    if (y < 0.25f) {
        s = y / (2.0f - y);
    } else {
        const float z = 1.0f - y;
        const uint32_t bits = air_float_bits(z) - 0x3f3504f3u; /* bits of 1/sqrt 2 */
        const int32_t exponent = (int32_t)bits >> 23;
        const float m = air_float_from_bits((bits & 0x007fffffu) + 0x3f3504f3u);
        n = (float)exponent;
        s = (1.0f - m) / (1.0f + m);
    }
    const float q = s * s;
    float p = 2.0f / 9.0f;
    p = p * q + 2.0f / 7.0f;
    p = p * q + 2.0f / 5.0f;
    p = p * q + 2.0f / 3.0f;
    return (p * q * s + 2.0f * s) - n * 0.693147181f;
}

#endif
