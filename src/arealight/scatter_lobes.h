/* scatter_lobes.h: the phase function as two lobes, one in each hemisphere about its peak. */
#ifndef AIR_AREALIGHT_SCATTER_LOBES_H
#define AIR_AREALIGHT_SCATTER_LOBES_H

#include <math.h>

#include "airlight/arealight.h"

/* [0] the half about the peak, [1] the other: its share of the whole, stretching and mixture. */
typedef struct air_lobe_halves {
    double share[2], s[2], w[2];
} air_lobe_halves;

/* What the peak's half has of the whole of Henyey and Greenstein's function [KT2025, a_u]. */
static inline double air_near_share(double gamma)
{
    const double r = sqrt(1.0 + gamma * gamma);
    return (1.0 + gamma) / (r * (r + 1.0 - gamma));
}

air_lobe_halves air_lobe_halves_make(const air_area_lobe *lobe, double gamma);

#endif
