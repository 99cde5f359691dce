/* fluence.h: fluences of the point light after k isotropic events, as functions of the distance. */
#ifndef AIR_IMPULSE_FLUENCE_H
#define AIR_IMPULSE_FLUENCE_H

#include "airlight/impulse_quadrature.h"

/* out[k] = exp(r) Phi_k(r), 0 <= k <= k_max. */
void impulse_fluences_scaled(int k_max, double r, double *out);

/* Far away the total of all orders falls off as exp(-kappa r)/r; kappa from 1 (alpha = 0) to 0. */
double impulse_diffusion_rate(double alpha);

/* ---- positive functions of the distance, by interpolation ---- */

enum { CURVE_POINTS = 176, CURVE_TAPS = 6 };

/* Knots: ln r from ln 1e-5 by steps of 0.09, to 69. */
double impulse_curve_distance(int i);

/* Where a distance lies: the same for all curves. */
typedef struct impulse_curve_place {
    int first;
    double weights[CURVE_TAPS];
} impulse_curve_place;

/* Beyond the ends the end's panel is continued. */
impulse_curve_place impulse_curve_find(double r);

static inline double impulse_curve_at(const double *curve, const impulse_curve_place *place)
{
    double sum = 0.0;
    for (int i = 0; i < CURVE_TAPS; i++) {
        sum += place->weights[i] * curve[place->first + i];
    }
    return sum;
}

#endif
