/* half_space.h: Chandrasekhar's H function of isotropic scattering [Chandrasekhar1960]: what a half
 * space of one albedo, without a boundary that bends light, sends back. */
#ifndef AIR_TESTS_HALF_SPACE_H
#define AIR_TESTS_HALF_SPACE_H

#include <math.h>

#include "core/quadrature.h"
#include "core/vec.h"

/* H(mu) = 1/(sqrt(1 - albedo) + albedo/2 integral of x H(x)/(x + mu) over (0, 1)), iterated. */
static inline double half_space_h(double albedo, double mu)
{
    enum { NODES = 32 };
    double x[NODES], w[NODES], h[NODES + 1];
    air_gauss_legendre(NODES, x, w);
    for (int i = 0; i <= NODES; i++) {
        h[i] = 1.0;
    }
    for (int round = 0; round < 200; round++) {
        for (int i = 0; i <= NODES; i++) {
            const double from = i < NODES ? 0.5 * (1.0 + x[i]) : mu;
            double sum = 0.0;
            for (int k = 0; k < NODES; k++) {
                const double at = 0.5 * (1.0 + x[k]);
                sum += 0.5 * w[k] * at * h[k] / (at + from);
            }
            h[i] = 1.0 / (sqrt(1.0 - albedo) + 0.5 * albedo * sum);
        }
    }
    return h[NODES];
}

/* Radiance towards mu of light that comes along one direction, mu0 its cosine, over its irradiance
 * across that direction. */
static inline double half_space_of_beam(double albedo, double mu0, double mu)
{
    const double h = half_space_h(albedo, mu) * half_space_h(albedo, mu0);
    return albedo * h * mu0 / (4.0 * AIR_PI * (mu + mu0));
}

/* Radiance towards mu under an even sky of radiance 1. */
static inline double half_space_of_sky(double albedo, double mu)
{
    return 1.0 - sqrt(1.0 - albedo) * half_space_h(albedo, mu);
}

#endif
