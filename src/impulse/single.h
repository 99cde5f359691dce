/* single.h: responses after one event, for many asymmetries at once.
 *
 * Results are scaled so that they hardly vary: f_1 tau exp(tau) for point and area, f_1 exp(tau)
 * for directional emitters. */
#ifndef AIR_IMPULSE_SINGLE_H
#define AIR_IMPULSE_SINGLE_H

#include "airlight/impulse_quadrature.h"
#include "core/harmonics.h"
#include "impulse/graded.h"

/* How fine: Gauss nodes of a panel, halvings towards an end, and the optical depth beyond which
 * nothing is looked for. */
typedef struct impulse_quality {
    graded_rule rule;
    int levels;
    double cut;
} impulse_quality;

impulse_quality impulse_quality_fine(void);  /* below 1e-7 */
impulse_quality impulse_quality_table(void); /* below 1e-5 */

/* The phase function at the cosine of the scattering angle. */
double impulse_phase(double g, double cosine);

/* Levels of halving that resolve the peak of g at an end of [0, pi]; at least `least`. */
int impulse_peak_levels(double g, int least);

/* out[i * stride + l] for g[i]. */
void impulse_point_scaled(const impulse_quality *quality, double tau, const double *g, int g_count,
                          int order, double *out, int stride);
void impulse_directional_scaled(const impulse_quality *quality, double tau, const double *g,
                                int g_count, int order, double *out, int stride);

/* The inner integral of (A1) over theta for one gamma, times exp(tau): out[i * stride + lm] for
 * g[i], up to AIR_IMPULSE_G_MAX of them, mirrored coefficients of factors->order. */
void impulse_area_inner(const impulse_quality *quality, const air_sh_factors *factors, double tau,
                        double gamma, const double *g, int g_count, double *out, int stride);

/* The integrals of cos(m phi) max(0, a + b cos phi) over a turn for 0 <= m < order; b >= 0. */
void impulse_clamped_moments(double a, double b, int order, double *out);

/* The two angles gamma, rising, between which the clamp cuts a part of the turn, for a = cos
 * theta_s cos gamma and b = sin theta_s sin gamma: where |a| = b. */
void impulse_clamp_cuts(double theta_s, double out[2]);

#endif
