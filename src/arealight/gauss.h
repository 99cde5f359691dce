/* gauss.h: Gauss-Legendre rules, the small ones from a table. */
#ifndef AIR_AREALIGHT_GAUSS_H
#define AIR_AREALIGHT_GAUSS_H

#include <stddef.h>

/* As air_gauss_legendre: count >= 1 nodes in (-1, 1), rising, and their weights. Up to 32 they are
 * copied: to find the roots anew for each polygon would take as long as its integral. */
void air_area_gauss(size_t count, double *out_nodes, double *out_weights);

#endif
