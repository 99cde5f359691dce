/* exponentials.h: exp(-x) and -log(1 - y) of double without branches, so that the compiler makes
 * lanes of loops around them. Relative errors below 1e-12 (tests/test_collimated_draw.c). */
#ifndef AIR_COLLIMATED_EXPONENTIALS_H
#define AIR_COLLIMATED_EXPONENTIALS_H

#include <stdbool.h>

#include "core/bits.h"

/* Both values are computed: a branch around arithmetic, which might trap, would end the lanes. */
static inline double air_double_select(bool which, double yes, double no)
{
    const uint64_t mask = -(uint64_t)which;
    return air_double_from_bits((air_double_bits(yes) & mask) | (air_double_bits(no) & ~mask));
}

/* exp(-x), x >= 0; 0 from 700 on. exp(-x) = 2^n exp(r), |r| <= ln 2 / 2, the latter by its Taylor
 * polynomial of degree 10: r^11/11! < 3e-13. Adding 1.5 2^52 rounds to an integer, which is left in
 * the low bits. */
static inline double air_decay(double x)
{
    const bool seen = x < 700.0;
    const double inside = air_double_select(seen, x, 700.0);
    const double shifted = inside * -1.4426950408889634 + 0x1.8p52, n = shifted - 0x1.8p52;
    const double r = (-inside - n * 0x1.62e42fee00000p-1) - n * 0x1.a39ef35793c76p-33;
    const double r2 = r * r, r4 = r2 * r2;
    const double p01 = 1.0 + r, p23 = 1.0 / 2.0 + r * (1.0 / 6.0);
    const double p45 = 1.0 / 24.0 + r * (1.0 / 120.0), p67 = 1.0 / 720.0 + r * (1.0 / 5040.0);
    const double p89 = 1.0 / 40320.0 + r * (1.0 / 362880.0) + r2 * (1.0 / 3628800.0);
    const double p = (p01 + r2 * p23) + r4 * ((p45 + r2 * p67) + r4 * p89);
    const double power = air_double_from_bits((air_double_bits(shifted) + 1023u) << 52);
    return air_double_select(seen, p * power, 0.0);
}

/* -log(1 - y), 0 <= y < 1. 1 - y = 2^n m, m in [1/sqrt 2, sqrt 2); log m = 2 atanh(s), s =
 * (m-1)/(m+1), |s| < 0.1716: the series to s^15 leaves a share of s^16/17 < 4e-14. With n = 0 m - 1
 * is -y itself, which keeps its digits. */
static inline double air_neg_log1m_double(double y)
{
    const uint64_t root_half = 0x3fe6a09e667f3bcdu, bias = (uint64_t)1024 << 52;
    const uint64_t bits = air_double_bits(1.0 - y), e = (bits - root_half + bias) >> 52;
    const double n = air_double_from_bits(e | 0x4330000000000000u) - (0x1p52 + 1024.0);
    const double m = air_double_from_bits(bits - (e << 52) + bias);
    const double f = air_double_select(n == 0.0, -y, m - 1.0), s = f / (2.0 + f);
    const double q = s * s, q2 = q * q, q4 = q2 * q2;
    const double p01 = 2.0 + q * (2.0 / 3.0), p23 = 2.0 / 5.0 + q * (2.0 / 7.0);
    const double p45 = 2.0 / 9.0 + q * (2.0 / 11.0), p67 = 2.0 / 13.0 + q * (2.0 / 15.0);
    const double p = (p01 + q2 * p23) + q4 * (p45 + q2 * p67);
    return n * -0.69314718055994531 - s * p;
}

#endif
