/* edge.h: the phase function integrated along a polygon's edges: the formulas, without pointers, so
 * that versions for other instruction sets can have the same.
 *
 * gamma = |g|, the axis is the phase function's peak, c a direction's cosine to it, and
 * r = sqrt(1 + gamma^2 - 2 gamma c). From the peak down to c the phase function integrates to
 *     G+ = (1 + gamma) (1 - c) / (2 pi r (r + 1 - gamma)),
 * from the far pole up to c to -G-, G+ - G- = 1/(2 pi). By Stokes' theorem a region's share is the
 * integral of G+ (or, if it has not the peak inside, of G-) over the azimuth along its outline; on
 * a great circle with unit normal n the azimuth grows by h du/(1 - c^2), h = axis.n, u being the
 * arc. Above the horizon G+ is taken and below it G-: both quotients below are smooth there. The
 * arcs along the horizon that close the two parts add (G+ - G-) times their angle. */
#ifndef AIR_AREALIGHT_EDGE_H
#define AIR_AREALIGHT_EDGE_H

#include <math.h>

#include "core/vec.h"

/* r, without cancellation in a sharp peak; below_peak is 1 - c. */
static inline double air_edge_r(double gamma, double below_peak)
{
    return sqrt((1.0 - gamma) * (1.0 - gamma) + 2.0 * gamma * below_peak);
}

/* G+ / (1 - c^2) */
static inline double air_edge_near(double gamma, double c, double r)
{
    return (1.0 + gamma) / (2.0 * AIR_PI * r * (r + (1.0 - gamma)) * (1.0 + c));
}

/* G- / (1 - c^2) */
static inline double air_edge_far(double gamma, double c, double r)
{
    return -(1.0 - gamma) / (2.0 * AIR_PI * r * (r + (1.0 + gamma)) * (1.0 - c));
}

/* Derivatives at c = 0 as quotients by the values there, r being that at 0. */
static inline double air_edge_near_slope(double gamma, double r)
{
    return gamma / (r * r) + gamma / (r * (r + (1.0 - gamma))) - 1.0;
}

static inline double air_edge_far_slope(double gamma, double r)
{
    return gamma / (r * r) + gamma / (r * (r + (1.0 + gamma))) + 1.0;
}

/* On an edge c = c0 cos u and r = q sqrt(1 + (sin(u/2)/kappa)^2). q^2: */
static inline double air_edge_least_square(double gamma, double c0, double h)
{
    return (1.0 - gamma) * (1.0 - gamma) + 2.0 * gamma * h * h / (1.0 + c0);
}

/* kappa, the half width of the edge's peak; at most 10, where there is no peak to speak of. */
static inline double air_edge_kappa(double gamma, double c0, double least_square)
{
    const double broad = 10.0, below = 4.0 * gamma * c0;
    return least_square < broad * broad * below ? sqrt(least_square / below) : broad;
}

/* The integrand over v, sin(u/2) = kappa sinh v, that makes the peak as broad as the rest: G+ /
 * (1 - c^2) times du/dv. */
static inline double air_edge_near_stretched(double gamma, double c0, double q, double kappa,
                                             double sinh_v, double cosh_v)
{
    const double sin_half = kappa * sinh_v, square = sin_half * sin_half;
    const double c = c0 * (1.0 - 2.0 * square);
    return air_edge_near(gamma, c, q * cosh_v) * 2.0 * kappa * cosh_v / sqrt(1.0 - square);
}

#endif
