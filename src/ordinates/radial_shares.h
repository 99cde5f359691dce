/* radial_shares.h: what a Henyey-Greenstein lobe sends forwards, sideways and backwards, in closed
 * forms that loops over arrays vectorise: no branches, no calls but sqrt.
 *
 * [Elek2014, eqs. 1-3] with cones of 45 degrees, c = cos(pi/4), t = a^2. The distribution function
 * has the distances s1, s2 = sqrt(1 + t -+ 2 a c) at c and -c. Sums and differences of front and
 * back depend on them through w = s1 s2 = sqrt(1 + t^2) and s = s1 + s2 = sqrt(2 (1 + t + w)) only,
 * and in these all that is 0/0 at a = 0 or |a| = 1 cancels:
 *
 *     side = 2 c (1-t) / (w s)                 side_mean = side 2 a / s^2
 *     front - back = a path                    path = (1 - (1-t) s / (2w)) / t
 *     front_mean - back_mean = ((1+t) path - (1-t) (1 + t/(1+w)) / (s+2)) / 2  */
#ifndef AIR_ORDINATES_RADIAL_SHARES_H
#define AIR_ORDINATES_RADIAL_SHARES_H

#include <stdint.h>
#include <string.h>

#include "core/vec.h"

/* side: all four patches together. *_mean: what each carries of the mean cosine. path: across a
 * cell as deep as 1, the mean path that agrees with the stencil's momentum: 1 for a beam, 3/4 for
 * isotropic light. */
typedef struct radial_shares {
    double front, side, back;
    double front_mean, side_mean, back_mean;
    double path;
} radial_shares;

/* max(0, x). A comparison with a constant tempts the compiler to a branch, and then no loop is
 * vectorised. */
static inline double radial_positive(double x) { return 0.5 * (x + fabs(x)); }

static inline double radial_path(double a)
{
    const double t = a * a, w = sqrt(1.0 + t * t), s = sqrt(2.0 * (1.0 + t + w)), rest = 1.0 - t;
    const double inverse = 1.0 / ((1.0 + w) * w * (2.0 * w + rest * s));
    return ((1.0 + w) * (3.0 + (2.0 - t) * t) - rest * rest * t) * inverse;
}

/* The same to 2e-5, exact for a beam, without roots and division: for distances of decay. */
static inline double radial_path_fit(double a)
{
    const double t = a * a, t2 = t * t;
    const double low = 0.25000504 - 0.40541187 * t, high = 0.41071124 - 0.16584002 * t;
    return 1.0 + (t - 1.0) * ((low - 0.16646332 * t2) + t * t2 * high);
}

static inline radial_shares radial_shares_of(double a)
{
    const double c = 0.70710678118654752440;
    const double t = a * a, w = sqrt(1.0 + t * t), s = sqrt(2.0 * (1.0 + t + w)), rest = 1.0 - t;
    const double p = 1.0 + w, q = w * (2.0 * w + rest * s), u = s + 2.0;
    const double inverse = 1.0 / (p * q * u), inverse_sw = 1.0 / (s * w);
    const double inverse_s = inverse_sw * w;
    radial_shares r;
    r.path = (p * (3.0 + (2.0 - t) * t) - rest * rest * t) * (inverse * u);
    r.side = 2.0 * c * rest * inverse_sw;
    r.back = radial_positive(0.5 * (1.0 - r.side - a * r.path));
    r.front = radial_positive(1.0 - r.side - r.back);
    r.side_mean = r.side * 2.0 * a * inverse_s * inverse_s;
    const double odd = 0.5 * ((1.0 + t) * r.path - rest * (p + t) * (inverse * q));
    r.front_mean = 0.5 * (a - r.side_mean + odd);
    r.back_mean = 0.5 * (a - r.side_mean - odd);
    return r;
}

/* exp(-x) for 0 <= x <= 700, relative error 3e-10, 1 at 0: -x = k ln 2 + f, |f| <= ln 2 / 2, and
 * the Taylor polynomial of degree 8 (the rest is f^9/9! = 2e-10), in pairs of terms, as Horner's
 * rule would wait for itself. Adding 1.5 * 2^52 rounds to an integer and leaves it in the low bits.
 */
static inline double radial_exp(double x)
{
    const double magic = 0x1.8p52;
    const double shifted = magic - x * 1.44269504088896340736;
    const double k = shifted - magic;
    const double f = (-x - k * 0x1.62e42fefa3800p-1) - k * 0x1.ef35793c76730p-45;
    const double f2 = f * f, f4 = f2 * f2;
    const double p23 = 0.5 + f * (1.0 / 6.0), p45 = 1.0 / 24.0 + f * (1.0 / 120.0);
    const double p67 = 1.0 / 720.0 + f * (1.0 / 5040.0);
    const double p = (1.0 + f) + f2 * ((p23 + f2 * p45) + f4 * (p67 + f2 * (1.0 / 40320.0)));
    uint64_t bits;
    double power;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023u) << 52;
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

/* [Henyey1941], |a| < 1. */
static inline double radial_lobe(double a, double cosine)
{
    const double d = 1.0 + a * a - 2.0 * a * cosine;
    return (1.0 - a * a) / (4.0 * AIR_PI * d * sqrt(d));
}

/* The share of such a lobe below a cosine, |a| < 1: (1-a) (1+m) / (s (1+a+s)), s as in eq. 1 at m;
 * the printed form is 0/0 at a = 0. [Elek2014, eq. 1] */
static inline double radial_lobe_below(double a, double cosine)
{
    const double s = sqrt(1.0 + a * a - 2.0 * a * cosine);
    return (1.0 - a) * (1.0 + cosine) / (s * (1.0 + a + s));
}

#endif
