/* quadrature.h: rules for integrals over an interval. */
#ifndef AIR_CORE_QUADRATURE_H
#define AIR_CORE_QUADRATURE_H

#include <stddef.h>

/* Gauss-Legendre on [-1, 1]: count nodes in rising order and their weights, exact for polynomials
 * of degree 2 count - 1. The arrays are the caller's. */
void air_gauss_legendre(size_t count, double *out_nodes, double *out_weights);

#endif
