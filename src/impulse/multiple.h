/* multiple.h: responses after two or more isotropic events, without random numbers.
 *
 * Radiance of order k is the line integral of the fluence of order k - 1 over 4 pi. All is scaled
 * by exp(distance), as coefficients and fluences then hardly vary. */
#ifndef AIR_IMPULSE_MULTIPLE_H
#define AIR_IMPULSE_MULTIPLE_H

#include "impulse/fluence.h"
#include "impulse/graded.h"
#include "impulse/single.h"

enum {
    IMPULSE_K = AIR_IMPULSE_BOUNCES_MAX,
    TABLES_ANGLES_MAX = 91,
    CLAMPED_BANDS = 7,  /* bands of a clamped cosine up to 10: 0, 1, 2, 4, 6, 8, 10 */
    MULTIPLE_ORDER = 3, /* of area responses after two or more events */
    MULTIPLE_COUNT = 6
};

/* The band of the i-th number that a clamped cosine has. */
static inline int clamped_band(int i) { return i < 2 ? i : 2 * i - 2; }

/* Below 3e-5 for k = 2, 2e-4 for k = 20. */
static inline impulse_quality impulse_quality_multiple(void)
{
    return (impulse_quality){.rule = graded_rule_make(10), .levels = 12, .cut = 25.0};
}

/* Fluences of the point light on a logarithmic axis: ln(r exp(r) Phi_k), k = 0..k_max, and the
 * point's zonal coefficients of the clamped cosine's bands by Phi_k, k = 1..k_max. */
typedef struct impulse_curves {
    int k_max;
    double fluence[IMPULSE_K + 1][CURVE_POINTS];
    double ratio[IMPULSE_K + 1][CLAMPED_BANDS][CURVE_POINTS];
} impulse_curves;

/* The fluences alone. */
void impulse_curves_fluences(int k_max, impulse_curves *out);
/* After that, the ratios at knot i. */
void impulse_curves_ratios(impulse_curves *self, int i);

/* out[k] = exp(r) Phi_k(r), 0 <= k <= k_max. */
void impulse_curves_at(const impulse_curves *self, int k_max, double r, double *out);

/* exp(d) times the point's coefficients of order k: out[k * stride + l], k_min <= k <= k_max, from
 * fluences of k_min - 1 to k_max - 1. */
void impulse_point_multiple(const impulse_quality *quality, const impulse_curves *curves, double d,
                            int k_min, int k_max, int order, double *out, int stride);

/* exp(d) times the area patch's, for `count` angles theta_s: out[(k * count + angle) * stride + c],
 * 2 <= k <= k_max, c of MULTIPLE_COUNT mirrored coefficients. */
void impulse_area_multiple(const impulse_quality *quality, const impulse_curves *curves, double d,
                           int k_max, const double *theta_s, int count, double *out, int stride);

/* ---- half space ---- */

enum { HALF_NODES = 6, HALF_PANELS = 54, HALF_COUNT = HALF_NODES * HALF_PANELS };

/* Fluences below the boundary for E0 = 1, as polynomials on panels that become smaller towards it,
 * to a depth of 40. */
typedef struct impulse_half_space {
    int k_max;
    double edges[HALF_PANELS + 1];
    double fluence[IMPULSE_K + 1][HALF_COUNT];
} impulse_half_space;

/* matrix: HALF_COUNT^2 doubles of scratch. */
void impulse_half_space_solve(int k_max, impulse_half_space *out, double *matrix);

/* exp(tau) times the coefficients of order k: out[k * stride + l], 2 <= k <= k_max. */
void impulse_directional_multiple(const impulse_half_space *self, double tau, int k_min, int k_max,
                                  int order, double *out, int stride);

#endif
