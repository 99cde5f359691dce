/* steps_math.h: what a step computes of many cells at once, for the instruction set of the
 * including file. */
#ifndef AIR_ORDINATES_STEPS_MATH_H
#define AIR_ORDINATES_STEPS_MATH_H

#include "ordinates/shares.h"
#include "ordinates/steps_pair.h"

/* 2^n, n in the low bits of a float near 1.5 2^23. */
static inline lanes lanes_power_of_2(lanes shifted)
{
    return (lanes)(((lane_ints)shifted << 23) + (lane_ints)lanes_all(1.0f));
}

/* exp(-x) and, to full relative accuracy, 1 - exp(-x) for x >= 0, as air_transmittance_and_loss
 * [core/exponential.h]; beyond 86 as there. Below 2^22 in size, what is added leaves the nearest
 * integer in the low bits. */
static inline pair pair_transmittance(pair x, pair *out_loss)
{
    const pair magic = pair_all(0x1.8p23f), one = pair_all(1.0f),
               least = pair_min(x, pair_all(86.0f));
    const pair shifted = pair_nmadd(least, pair_all(1.44269504f), magic);
    const pair n = pair_sub(shifted, magic);
    const pair high = pair_nmadd(n, pair_all(0.693359375f), pair_sub(pair_all(0.0f), least));
    const pair r = pair_madd(n, pair_all(2.12194440e-4f), high), r2 = pair_mul(r, r);
    const pair p23 = pair_madd(r, pair_all(1.0f / 6.0f), pair_all(0.5f));
    const pair p45 = pair_madd(r, pair_all(1.0f / 120.0f), pair_all(1.0f / 24.0f));
    const pair p67 = pair_madd(r, pair_all(1.0f / 5040.0f), pair_all(1.0f / 720.0f));
    const pair p = pair_madd(r2, pair_madd(r2, pair_madd(r2, p67, p45), p23), r);
    const pair power = {lanes_power_of_2(shifted.a), lanes_power_of_2(shifted.b)};
    *out_loss = pair_nmadd(p, power, pair_sub(one, power));
    return pair_madd(p, power, power);
}

/* A guess doubled by Newton's rule. x >= 1e-36. */
static inline pair pair_inverse(pair x)
{
    const pair y = pair_rough_inverse(x);
    return pair_madd(y, pair_nmadd(x, y, pair_all(1.0f)), y);
}

/* y^3 of y = x^(-1/2): a guess y with x y^2 = 1 - d is made exact by (1-d)^(-3/2) = 1 + 3d/2, but
 * for 15 d^2/8, 1e-6 where d is 7e-4 at most. */
static inline pair pair_inverse_root_cubed(pair x)
{
    const pair y = pair_rough_inverse_root(x), y2 = pair_mul(y, y), y3 = pair_mul(y2, y);
    return pair_mul(y3, pair_nmadd(pair_mul(x, y2), pair_all(1.5f), pair_all(2.5f)));
}

/* sqrt(x), x >= 1e-36. */
static inline pair pair_root(pair x)
{
    const pair y = pair_rough_inverse_root(x), root = pair_mul(x, y);
    const pair off = pair_nmadd(root, pair_mul(y, pair_all(0.5f)), pair_all(0.5f));
    return pair_madd(root, off, root);
}

/* ordinates_halves */
static inline pair pair_halves(const float c[12], pair a, pair *out_odd)
{
    const pair a2 = pair_mul(a, a);
    pair even = pair_all(c[10]), odd = pair_all(c[11]);
    for (int i = 8; i >= 0; i -= 2) {
        even = pair_madd(even, a2, pair_all(c[i]));
        odd = pair_madd(odd, a2, pair_all(c[i + 1]));
    }
    *out_odd = pair_mul(odd, a);
    return even;
}

/* ordinates_path */
static inline pair pair_path(pair a)
{
    const float *const c = ordinates_path_fit;
    const pair one = pair_all(1.0f);
    const pair w = pair_root(pair_max(pair_nmadd(a, a, one), pair_all(1e-14f)));
    const pair c12 = pair_madd(w, pair_all(c[2]), pair_all(c[1]));
    return pair_madd(w, pair_madd(w, c12, pair_all(c[0])), one);
}

/* exp(-x), 0 <= x <= 1/8, off by 9e-8 at most; exp(0) = 1. Below 0 from 2 on. */
static inline pair pair_short_exp(pair x)
{
    const pair c23 = pair_nmadd(x, pair_all(0.1570036f), pair_all(0.4993085f));
    return pair_nmadd(x, pair_nmadd(x, c23, pair_all(0.99998587f)), pair_all(1.0f));
}

/* 4 pi times the phase function of mean cosine x, |x| <= ORDINATES_SHARPEST, view = 2 d.v. */
static inline pair pair_phase(pair x, pair view)
{
    const pair one = pair_all(1.0f);
    const pair cube = pair_inverse_root_cubed(pair_madd(x, pair_sub(x, view), one));
    return pair_mul(pair_nmadd(x, x, one), cube);
}

#endif
