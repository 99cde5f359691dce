/* shares.h: shares and moments of Henyey-Greenstein lobes [Henyey1941] that leave a cell by each of
 * its sides, exact and fast. */
#ifndef AIR_ORDINATES_SHARES_H
#define AIR_ORDINATES_SHARES_H

#include <math.h>

#include "airlight/ordinates.h"
#include "core/vec.h"

/* F(a) = Pe(a^2) + a Po(a^2), share of the cone ahead, from a^0 on; the cone behind has F(-a). Off
 * by 3.5e-5 at most; F(1) = 1 and F(-1) = 0 to the digits given. */
static const float ordinates_front[12] = {
    0.146480045f,  0.37498883f,   0.43939282f,  0.327874563f, 0.131286944f,   -0.120385977f,
    -0.397949336f, -0.286539782f, 0.219930475f, 0.286264992f, -0.0391409477f, -0.0822026253f};

/* Its mean cosine times the share, likewise, off by 2.6e-5; behind -MF(-a). */
static const float ordinates_front_mean[12] = {
    0.125024915f,  0.323230861f,  0.388743383f, 0.308754431f, 0.152139833f, -0.0514072829f,
    -0.279803258f, -0.228016672f, 0.133860547f, 0.203274078f, -0.01996542f, -0.055835416f};

/* The even and the odd half: f(a) and f(-a) are their sum and difference. */
static inline float ordinates_halves(const float c[12], float a, float *out_odd)
{
    const float a2 = a * a;
    float even = c[10], odd = c[11];
    for (int i = 8; i >= 0; i -= 2) {
        even = even * a2 + c[i];
        odd = odd * a2 + c[i + 1];
    }
    *out_odd = odd * a;
    return even;
}

/* Mean path through a cube of edge 1 from step to step of light of mean cosine a: the mean of
 * 1/(|x| + |y| + |z|), fitted to 7e-3 in w = sqrt(1 - a^2). What the fit gives is the definition.
 */
static const float ordinates_path_fit[3] = {-0.28407042f, -0.4765254f, 0.43737931f};
static inline double ordinates_path(double a)
{
    const double w = sqrt(double_max(0.0, 1.0 - a * a));
    return 1.0 + w * (-0.28407042 + w * (-0.4765254 + w * 0.43737931));
}

/* The lobe's share of directions whose cosine to its axis is at most mu: (1-a^2)/(2a) (1/s -
 * 1/(1+a)), s = |axis - a direction|, over a common denominator, in which a cancels. */
static inline double ordinates_cumulative(double a, double mu)
{
    if (mu <= -1.0 || mu >= 1.0) {
        return mu < 0.0 ? 0.0 : 1.0;
    }
    const double s = sqrt(1.0 + a * a - 2.0 * a * mu);
    return (1.0 - a) * (1.0 + mu) / (s * (1.0 + a + s));
}

/* No phase function is as sharp as a beam; those of g are kept this far from it. */
#define ORDINATES_SHARPEST 0.995
static inline double ordinates_dull(double g)
{
    return double_min(double_max(g, -ORDINATES_SHARPEST), ORDINATES_SHARPEST);
}

/* 1/sr, |a| <= ORDINATES_SHARPEST */
static inline double ordinates_phase(double a, double mu)
{
    const double s2 = 1.0 + a * a - 2.0 * a * mu;
    return (1.0 - a * a) / (4.0 * AIR_PI * s2 * sqrt(s2));
}

/* What leaves through each face of a cube by how far directions lead across it: z+/(|x|+|y|+|z|) of
 * each direction through the face ahead. For six lobes, whose axes are all alike. */
typedef struct ordinates_upwind {
    double front, side, back;     /* front + 4 side + back = 1 */
    double front_mean, back_mean; /* the mean cosine carried: to the axis, and to its opposite */
    double side_axial;            /* cosine to the axis that a side carries */
    double side_lateral;          /* and to the side's own normal */
    double path;                  /* mean of 1/(|x|+|y|+|z|) */
} ordinates_upwind;

/* Rows over t = sqrt(1 - |a|), since near 1 shares go as t^2 log t; interpolated linearly. Errors:
 * tests/test_ordinates_shares.c. */
enum { ORDINATES_ROWS = 257, ORDINATES_COLUMNS = 5 };
typedef struct ordinates_upwind_row {
    double v[ORDINATES_COLUMNS]; /* F(|a|), F(-|a|), MF(|a|), MF(-|a|), path */
} ordinates_upwind_row;

/* Fills ORDINATES_ROWS rows. */
void ordinates_upwind_tabulate(ordinates_upwind_row *out_rows);
ordinates_upwind ordinates_upwind_at(const ordinates_upwind_row *rows, double a);

#endif
