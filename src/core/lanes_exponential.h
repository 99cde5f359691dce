/* lanes_exponential.h: exp, 1 - exp(-x) and log of many doubles at once.
 *
 * exponential.h in double. Largest relative errors over the stated ranges, for every instruction
 * set (tests/test_core_lanes_exponential.c): air_lanes_exp 2.5e-16, air_lanes_transmittance 2.5e-16
 * and its loss 4e-16, air_lanes_log 4e-16. */
#ifndef AIR_CORE_LANES_EXPONENTIAL_H
#define AIR_CORE_LANES_EXPONENTIAL_H

#include "core/lanes.h"

/* Added to a double below 2^51 in size it leaves the nearest integer in the low bits. */
#define LANES_ROUNDING 0x1.8p52

/* 2^n, n + LANES_ROUNDING given; -1023 < n < 1024. The low 12 bits of the sum are shifted into sign
 * and exponent, whose bias is added. */
static inline lanes lanes_power_of_2(lanes shifted_n)
{
    return (lanes)(((lane_bits)shifted_n << 52) + ((lane_bits)lanes_all(1.0)));
}

/* exp(x) - 1 = 2^n (p + 1) - 1 with x = n ln 2 + r, |r| <= ln 2 / 2, ln 2 in two parts of which the
 * first has 21 zero bits at its end, so that n times it is exact. Gives p = exp(r) - 1 by its
 * Taylor polynomial of degree 13, whose remainder r^14/14! is below 4.2e-18, relatively to r below
 * 1.2e-17; and n + LANES_ROUNDING. */
static inline lanes lanes_exp_parts(lanes x, lanes *out_shifted_n)
{
    const lanes shifted = lanes_madd(x, lanes_all(0x1.71547652b82fep0), lanes_all(LANES_ROUNDING));
    const lanes n = shifted - LANES_ROUNDING;
    const lanes r = lanes_madd(n, lanes_all(-0x1.a39ef35793c76p-33),
                               lanes_madd(n, lanes_all(-0x1.62e42feep-1), x));
    const lanes r2 = r * r, r4 = r2 * r2; /* short chains instead of Horner's rule */
    const lanes p3 = lanes_madd(r, lanes_all(1.0 / 6.0), lanes_all(0.5));
    const lanes p5 = lanes_madd(r, lanes_all(1.0 / 120.0), lanes_all(1.0 / 24.0));
    const lanes p7 = lanes_madd(r, lanes_all(1.0 / 5040.0), lanes_all(1.0 / 720.0));
    const lanes p9 = lanes_madd(r, lanes_all(1.0 / 362880.0), lanes_all(1.0 / 40320.0));
    const lanes p11 = lanes_madd(r, lanes_all(1.0 / 39916800.0), lanes_all(1.0 / 3628800.0));
    const lanes p13 = lanes_madd(r, lanes_all(1.0 / 6227020800.0), lanes_all(1.0 / 479001600.0));
    const lanes low = lanes_madd(r2, p5, p3), middle = lanes_madd(r2, p9, p7),
                high = lanes_madd(r2, p13, p11);
    *out_shifted_n = shifted;
    return lanes_madd(r2, lanes_madd(r4, lanes_madd(r4, high, middle), low), r);
}

/* exp(x) for x <= 0, with gradual underflow; garbage for NaN. Two factors, since 2^n may be less
 * than the least normal number. */
static inline lanes air_lanes_exp(lanes x)
{
    lanes shifted_n;
    const lanes p = lanes_exp_parts(lanes_max(x, lanes_all(-1400.0)), &shifted_n);
    const lanes n = shifted_n - LANES_ROUNDING;
    const lanes shifted_half = lanes_madd(n, lanes_all(0.5), lanes_all(LANES_ROUNDING));
    const lanes half = shifted_half - LANES_ROUNDING;
    const lanes rest = lanes_power_of_2((n - half) + LANES_ROUNDING);
    return (p + 1.0) * lanes_power_of_2(shifted_half) * rest;
}

/* exp(-x) and, to full relative accuracy, 1 - exp(-x) for x >= 0: with n = 0 the latter is -p
 * itself, with n <= -1 it is at least 0.29 and nothing cancels. Above 708 exp(-x) stays what it is
 * there, 3e-308. */
static inline lanes air_lanes_transmittance(lanes x, lanes *out_loss)
{
    lanes shifted_n;
    const lanes p = lanes_exp_parts(-lanes_min(x, lanes_all(708.0)), &shifted_n);
    const lanes power = lanes_power_of_2(shifted_n);
    *out_loss = (1.0 - power) - p * power;
    return lanes_madd(p, power, power);
}

/* log(x) for positive finite x; garbage for others. With x = 2^n m, m in [1/sqrt 2, sqrt 2), log m
 * = 2 atanh(s), s = (m-1)/(m+1), s^2 < 0.0295: the series to s^21 leaves out s^22/23 < 2e-18 of
 * it. */
static inline lanes air_lanes_log(lanes x)
{
    const lane_mask subnormal = lanes_less(x, lanes_all(0x1p-1022));
    const lanes scaled = lanes_select(subnormal, x * 0x1p54, x);
    const lane_bits root = (lane_bits)lanes_all(0x1.6a09e667f3bcdp-1),
                    one = (lane_bits)lanes_all(1.0), magic = (lane_bits)lanes_all(LANES_ROUNDING);
    const lane_bits bits = (lane_bits)scaled + (one - root); /* n + 1023 in the exponent */
    const lanes m = (lanes)((bits & 0x000fffffffffffffull) + root);
    const lanes biased = (lanes)((bits >> 52) + magic) - LANES_ROUNDING;
    const lanes n = biased - lanes_select(subnormal, lanes_all(1077.0), lanes_all(1023.0));
    const lanes s = (m - 1.0) / (m + 1.0), q = s * s;
    lanes p = lanes_all(2.0 / 21.0);
    p = lanes_madd(p, q, lanes_all(2.0 / 19.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 17.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 15.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 13.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 11.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 9.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 7.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 5.0));
    p = lanes_madd(p, q, lanes_all(2.0 / 3.0));
    const lanes small = lanes_madd(n, lanes_all(0x1.a39ef35793c76p-33), p * q * s);
    return lanes_madd(n, lanes_all(0x1.62e42feep-1), lanes_madd(s, lanes_all(2.0), small));
}

#endif
