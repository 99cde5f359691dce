/* rest.h: what orders beyond the tables' give, all together. */
#ifndef AIR_IMPULSE_REST_H
#define AIR_IMPULSE_REST_H

#include "impulse/multiple.h"

/* Isotropic; events k > after in a medium of this albedo. The curves' orders 0 and 1 are sums of
 * fluences: of k >= after - 1 and of k >= after, of which the line integrals make k > after. */
typedef struct impulse_rest {
    int after;
    double albedo;
    impulse_curves curves;
} impulse_rest;

/* NULL where there is no memory. On the context's threads. */
impulse_rest *impulse_rest_create(air_context *context, int after, double albedo);
void impulse_rest_destroy(air_context *context, impulse_rest *rest); /* NULL is legal */

/* Adds scale times the coefficients at tau, canonical as in impulse_quadrature.h. */
void impulse_rest_add_zonal(const impulse_rest *self, double tau, double scale, double *out_zh);
/* For `count` angles, MULTIPLE_COUNT coefficients each. */
void impulse_rest_area(const impulse_rest *self, double tau, double scale, const double *theta_s,
                       int count, double *out);

#endif
