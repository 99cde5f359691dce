/* glow.h: photons as they leave the media: light that was scattered in the cells, on its
 * way to surfaces. */
#ifndef AIR_RENDER_ORDINATES_GLOW_H
#define AIR_RENDER_ORDINATES_GLOW_H

#include "render/ordinates/photons.h"
#include "render/ordinates/state.h"

typedef struct ord_glow {
    const ord_space *space;       /* its extinction counts the peaks of phase functions as none */
    const float *true_extinction; /* likewise laid out */
    const air_dom_phase *phase;
    int bands;
    const float *moments; /* of all light in the cells (ordinates_dom.h) */
} ord_glow;

/* Shoots photons and follows them as ord_photons_shoot does, without end. */
air_status ord_photons_glow(const ord_glow *glow, ord_photons *out);

/* What all cells scatter, of three channels, W. */
void ord_glow_power(const ord_glow *glow, double out[3]);

/* Surfaces light the media, these the surfaces, and so on, each time less: from what one time
 * added to the first's power, the factors on what it added that stand for all times. */
void ord_glow_factors(const double first[3], const double both[3], float out[3]);

/* after becomes before + factors (after - before): numbers in fours. */
void ord_glow_extend(const float *before, const float factors[3], size_t fours, float *after);

/* What there was before surfaces sent back light that media had scattered to them. */
typedef struct ord_earlier {
    float *moments;  /* of scattered light */
    float *all;      /* room for those of all light */
    float **shown;   /* ord_medium.light, by medium */
    double power[3]; /* room for ord_glow_power */
    size_t fours;    /* in moments and in all */
} ord_earlier;

/* A copy of what there is now; `harmonics` moments per cell. Whatever comes back, out is to be
 * finished. */
air_status ord_earlier_keep(const air_with_ordinates *with, const air_dom *dom, size_t harmonics,
                            ord_earlier *out);
void ord_earlier_finish(const air_with_ordinates *with, ord_earlier *earlier);

#endif
