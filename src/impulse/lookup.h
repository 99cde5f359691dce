/* lookup.h: what a medium's rule asks of the tables. */
#ifndef AIR_IMPULSE_LOOKUP_H
#define AIR_IMPULSE_LOOKUP_H

#include "impulse/tables.h"

/* Events first..last: the first of the medium sigma_t, albedo, g; those from the second on of the
 * reduced, isotropic one. residual: the first is of the reduced one, too, and there is an excess.
 */
typedef struct impulse_sum {
    double sigma_t, albedo, g;
    double reduced_sigma_t, reduced_albedo;
    int first, last;
    bool residual;
} impulse_sum;

impulse_sum impulse_sum_of(const air_impulse_params *params, const air_impulse_medium *medium,
                           int first, int last);

/* The medium whose events the sum has, when its excess is taken apart: under the residual rule the
 * reduced, isotropic one. */
air_impulse_medium impulse_sum_medium(const impulse_sum *sum, const air_impulse_medium *medium);

/* What the reduced medium's unscattered light has more than the medium's, from direction l: an
 * irradiance across l. 0 but for the residual rule. */
double impulse_sum_excess(const impulse_sum *sum, const air_impulse_medium *medium,
                          air_impulse_emitter emitter, double distance, double cos_s);

#endif
