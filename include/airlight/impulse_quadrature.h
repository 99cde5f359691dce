/* impulse_quadrature.h: light that a homogeneous medium scatters towards a point, by quadrature
 * [Dubouchet2019, as corrected in src/impulse/README.md].
 *
 * Conventions, here and in impulse.h. The receiver x is at the origin; l is the unit direction from
 * it TO the emitter at distance d, and the axis of harmonics. A direction w points away from x,
 * towards where radiance comes from; theta is its angle to l. Area emitters: n_s is the patch's
 * normal, theta_s the angle between n_s and -l (0: the patch faces x), and phi the azimuth about l,
 * 0 on the side of n_s. tau = sigma_t d. Phase functions are Henyey and Greenstein's, g > 0
 * forward.
 *
 * Responses are of the canonical medium: sigma_t = 1, single-scattering albedo 1, lengths in mean
 * free paths, and emitters of unit strength: intensity I0 = 1 (point), max(0, cos) (area patch),
 * irradiance E0 = 1 across l (directional; the medium begins at a plane across l at distance d from
 * x and is infinite on all other sides). In a medium of albedo alpha, after k events:
 *
 *     point, area:   alpha^k sigma_t^2 f_k(sigma_t d) I0         directional: alpha^k f_k E0
 *
 * Light that was not scattered is in none of these. Zonal coefficients c_l belong to y_l =
 * sqrt((2l+1)/(4 pi)) P_l(cos theta); those of area emitters c_lm, 0 <= m <= l, at l*(l+1)/2 + m,
 * to y_lm(theta, phi) = y_lm(theta, 0) cos(m phi), real harmonics without Condon and Shortley's
 * phase. The fluence is sqrt(4 pi) c_0.
 *
 * Double precision, no allocation; every function may be called from any thread. Arguments outside
 * their stated ranges give NaN or nonsense, never a crash. */
#ifndef AIRLIGHT_IMPULSE_QUADRATURE_H
#define AIRLIGHT_IMPULSE_QUADRATURE_H

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    AIR_IMPULSE_ORDER = 11,      /* bands 0..10 */
    AIR_IMPULSE_SH_COUNT = 66,   /* mirrored coefficients of that order */
    AIR_IMPULSE_BOUNCES_MAX = 20 /* events that fluences are sound for */
};

/* ---- one event; tau > 0, -1 < g < 1, 1 <= order <= 11 ---- */

/* order coefficients; error of the vector below 1e-7 for tau from 1e-4 to 30 and |g| <= 0.95. */
AIR_API void air_impulse_point(double tau, double g, int order, double *out_zh);
AIR_API void air_impulse_directional(double tau, double g, int order, double *out_zh);

/* order*(order+1)/2 coefficients for theta_s in [0, pi]; some ms. */
AIR_API void air_impulse_area(double tau, double theta_s, double g, int order, double *out_sh);

/* ---- radiance along a direction, in units of length of one's own ---- */

/* Point light of intensity 1 at distance d in direction l, cosine = w.l: radiance at x from the
 * piece t0 <= t <= t1 of the ray x + t w (t1 may be INFINITY), with the medium between. Infinite
 * where the piece meets the light. */
AIR_API double air_impulse_point_ray(double sigma_s, double sigma_t, double g, double d,
                                     double cosine, double t0, double t1);

/* Directional light, E0 = 1 across l, in a half space whose boundary's outward normal is n (n.l >
 * 0), x at depth h below it: the whole ray. The medium may end at t_end (INFINITY: nowhere), where
 * only the view ray is cut. */
AIR_API double air_impulse_slab_ray(double sigma_s, double sigma_t, double g, const double l[3],
                                    const double n[3], double h, const double w[3], double t_end);

/* The irradiance of that, whole rays, on a receiver of unit normal r; alpha = sigma_s/sigma_t. */
AIR_API double air_impulse_slab_irradiance(double alpha, double g, const double l[3],
                                           const double n[3], double tau_h, const double r[3]);

/* ---- many events, isotropic; 1 <= k <= AIR_IMPULSE_BOUNCES_MAX ---- */

/* Fluence of exactly k events at distance r > 0 from the point light; k = 0 is exp(-r)/r^2.
 * Relative error below 1e-9 for r from 1e-3 to 60. */
AIR_API double air_impulse_point_fluence(int k, double r);

/* Of all orders beyond `after` (>= 0) events, weighted by alpha^k: the sum over k > after of
 * alpha^k air_impulse_point_fluence(k, r) for 0 < alpha <= 1. With after = 0 all that is
 * scattered. */
AIR_API double air_impulse_point_fluence_rest(int after, double alpha, double r);

/* Fluence of exactly k >= 1 events at distance r from an area patch, theta_s from its normal. For k
 * >= 2 by reciprocity, bands 0..10 of the irradiance that a point light gives. Some 20 ms. */
AIR_API double air_impulse_area_fluence(int k, double r, double theta_s);

/* Fluences out[0..k_max] of the directional light at depth tau in (0, 20]; relative error below
 * 1e-5. Takes some 40 ms, and memory while it runs: AIR_ERROR_MEMORY. */
AIR_API air_status air_impulse_directional_fluences(air_context *context, int k_max, double tau,
                                                    double *out);

#ifdef __cplusplus
}
#endif
#endif
