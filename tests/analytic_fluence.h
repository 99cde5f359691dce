/* analytic_fluence.h: fluence around an isotropic point source in an infinite homogeneous medium
 * with isotropic scattering, per number of scatterings and in total; a truth for volumetric path
 * tracers.
 *
 * With lengths in mean free paths the fluence after k scatterings is a spherical convolution, in
 * Fourier space (atan q / q)^(k+1). Pulling the inverse transform's contour round the cut that
 * begins at q = i gives a monotone integral without oscillation [Case1967]:
 *
 *     Phi_k(r) = 2/(pi r) Int_1^inf s Im[A(s)^(k+1)] e^(-s r) ds,    A(s) = (atanh(1/s) + i pi/2) /
 * s,
 *
 * the sum over all k with albedo a has A / (1 - a A) instead of A^(k+1), plus the residue at the
 * discrete eigenvalue (the diffusion mode). All functions assume a radiant intensity of 1 W/sr;
 * fluence is in W/m^2. */
#ifndef ANALYTIC_FLUENCE_H
#define ANALYTIC_FLUENCE_H

#include <math.h>

static const double fluence_pi = 3.14159265358979323846;

/* s Im[f(A(s))] at s = 1 + e, where f is the power k + 1, or, for k < 0, A / (1 - albedo A). */
static inline double fluence_integrand(double e, int k, double albedo)
{
    const double s = 1.0 + e;
    const double re = 0.5 * log1p(2.0 / e) / s, im = 0.5 * fluence_pi / s;
    if (k >= 0)
        return s * pow(hypot(re, im), k + 1) * sin((k + 1) * atan2(im, re));
    const double gap = 1.0 - albedo * re, turn = albedo * im;
    return s * im / (gap * gap + turn * turn);
}

/* Int_1^inf s Im[f(A)] e^(-s r) ds. The integrand has powers of ln e at e = 0: dyadic panels in e,
 * from 1e-35 (below it less than 1e-32 is left) to where e^(-e r) has fallen to e^-45. */
static inline double fluence_cut_integral(double r, int k, double albedo)
{
    static const double node[8] = {0.0950125098376374, 0.2816035507792589, 0.4580167776572274,
                                   0.6178762444026438, 0.7554044083550030, 0.8656312023878318,
                                   0.9445750230732326, 0.9894009349916499};
    static const double weight[8] = {0.1894506104550685, 0.1826034150449236, 0.1691565193950025,
                                     0.1495959888165767, 0.1246289712555339, 0.0951585116824928,
                                     0.0622535239386479, 0.0271524594117541};
    const double end = 45.0 / r;
    double sum = 0.0;
    for (double e0 = 1e-35; e0 < end; e0 *= 2.0) {
        const double e1 = fmin(2.0 * e0, end), mid = 0.5 * (e0 + e1), half = 0.5 * (e1 - e0);
        for (int i = 0; i < 16; ++i) {
            const double e = mid + (i < 8 ? -half : half) * node[i & 7];
            sum += half * weight[i & 7] * fluence_integrand(e, k, albedo) * exp(-e * r);
        }
    }
    return sum * exp(-r);
}

/* kappa with albedo atanh(kappa)/kappa = 1, 0 < albedo < 1; bisection. */
static inline double fluence_eigenvalue(double albedo)
{
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 100; ++i) {
        const double mid = 0.5 * (low + high);
        if (albedo * atanh(mid) < mid)
            low = mid;
        else
            high = mid;
    }
    return 0.5 * (low + high);
}

/* Fluence at distance d of light scattered exactly k >= 0 times. The powers of ln e cancel ever
 * more: good to 1e-10 relative for k <= 9, to 1e-6 for k <= 14, useless from k = 18. */
static inline double fluence_of_bounce(int k, double sigma_s, double sigma_a, double d)
{
    const double sigma_t = sigma_s + sigma_a, r = sigma_t * d;
    return pow(sigma_s / sigma_t, k) * sigma_t * sigma_t * 2.0 / (fluence_pi * r) *
           fluence_cut_integral(r, k, 1.0);
}

/* Fluence at distance d of light scattered any number of times, 0 included; sigma_s > 0. */
static inline double fluence_of_all_bounces(double sigma_s, double sigma_a, double d)
{
    const double sigma_t = sigma_s + sigma_a, r = sigma_t * d, albedo = sigma_s / sigma_t;
    double mode = 3.0 / r;
    if (sigma_a > 0.0) {
        const double kappa = fluence_eigenvalue(albedo);
        const double slope = (1.0 / (1.0 - kappa * kappa) - atanh(kappa) / kappa) / kappa;
        mode = 2.0 * kappa * exp(-kappa * r) / (r * albedo * albedo * slope);
    }
    return sigma_t * sigma_t *
           (mode + 2.0 / (fluence_pi * r) * fluence_cut_integral(r, -1, albedo));
}

#endif
