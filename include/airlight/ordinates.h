/* ordinates.h: light carried through a grid along one direction, step by step [Elek2014], as
 * corrected in src/ordinates/README.md.
 *
 * One direction of travel d, one colour channel. Each cell holds the power E that is under way in
 * it and the mean cosine a of its directions to d; a step sends it on to the six neighbours.
 * Kernels over arrays: no scene, no threads, no allocation. Functions of different arrays may run
 * at once.
 *
 * Units: metres, 1/m. Light of irradiance 1 W/m^2 on a plane across d enters through the face k =
 * 0; results scale with it. Fluence is the integral of radiance over all directions. */
#ifndef AIRLIGHT_ORDINATES_H
#define AIRLIGHT_ORDINATES_H

#include <stddef.h>

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How a step shares a cell's power out. */
typedef enum air_ordinates_stencil {
    AIR_ORDINATES_LITERAL =
        0, /* the paper's: what arrives is one lobe again; only ever a few steps */
    AIR_ORDINATES_CM =
        1, /* conditional moments: what leaves by each side has its own mean cosine */
    AIR_ORDINATES_SIX = 2 /* six lobes per cell, one along each axis */
} air_ordinates_stencil;

/* How the mean cosine falls over an optical distance tau of scattering. */
typedef enum air_ordinates_decay {
    AIR_ORDINATES_DECAY_POISSON = 0, /* exp(-(1-g) tau): exact for every distribution */
    AIR_ORDINATES_DECAY_PAPER = 1    /* g^tau [Elek2014, eq. 4] */
} air_ordinates_decay;

/* What the grid begins with. */
typedef enum air_ordinates_start {
    AIR_ORDINATES_FIRST_SCATTER =
        0,                      /* what the unscattered beam loses by scattering, in every cell */
    AIR_ORDINATES_BOUNDARY = 1, /* the beam itself, in the first slice */
    AIR_ORDINATES_ALL_CELLS = 2 /* the beam, absorbed but not scattered, in every cell: the paper's
                                   text; it invents light and its books do not balance */
} air_ordinates_start;

/* Cubic cells; cell (i, j, k) is entry (k * size[1] + j) * size[0] + i of every array; k runs along
 * d. Borrowed. */
typedef struct air_ordinates_cells {
    size_t size[3];                 /* 1..AIR_ORDINATES_SIZE_MAX each */
    float cell_m;                   /* edge of a cell, > 0 */
    const float *sigma_s, *sigma_a; /* >= 0, finite */
    const float *g;                 /* mean cosine of scattering, in (-1, 1) */
    const float *entry; /* size[0] * size[1] factors >= 0 on what enters each cell of the first
                           slice; NULL: 1 */
} air_ordinates_cells;

enum { AIR_ORDINATES_SIZE_MAX = 512, AIR_ORDINATES_STEPS_MAX = 4096 };

typedef struct air_ordinates_params {
    air_ordinates_stencil stencil; /* default CM */
    air_ordinates_decay decay;     /* default POISSON */
    air_ordinates_start start;     /* default FIRST_SCATTER */
    uint32_t steps;                /* at most; 1..AIR_ORDINATES_STEPS_MAX; default 32 */
    double residual; /* ends when no more than this share of what came in is under way; >= 0;
                        default 1e-3 */
    float lobe; /* mean cosine of the light that enters: 1 a beam, less for light that stands for
                   a patch of sky; in [0, 1]; default 1 */
} air_ordinates_params;

AIR_API void air_ordinates_params_default(air_ordinates_params *params);

/* Where the power went, W: in = sum of out + absorbed + residual, to 1e-12 of it in doubles, 1e-5
 * in floats (not so with ALL_CELLS). */
typedef struct air_ordinates_books {
    double in;
    double out[6]; /* through the faces -i, +i, -j, +j, -k, +k */
    double absorbed;
    double residual; /* still under way */
    uint32_t steps;  /* taken */
} air_ordinates_books;

/* What is wanted; the caller's arrays, one number per cell but where said; NULL: not wanted. */
typedef struct air_ordinates_results {
    /* Of light that the cells carried: with FIRST_SCATTER what was scattered, else everything. */
    float *fluence;
    float *beam; /* FIRST_SCATTER: fluence of the unscattered beam; else 0 */

    /* In: d.v in [-1, 1], v the unit vector from the cell to the observer. */
    const float *view_cosine;
    /* Needs view_cosine: phase-weighted fluence, W/(m^2 sr): times sigma_s it is the radiance that
     * a metre of the cell sends to the observer, the beam's included. */
    float *seen;

    size_t bins;      /* of the cosine to d, even on [-1, 1]; at least 1 where binned is wanted */
    float *binned;    /* bins per cell: fluence by direction, without the beam */
    float *energy;    /* E at the end, W */
    float *asymmetry; /* a at the end; SIX: of all lobes together */
    air_ordinates_books *books;
} air_ordinates_results;

/* Bytes of scratch that a run needs, aligned to 64 bytes; 0: the run would be refused. */
AIR_API size_t air_ordinates_scratch(const air_ordinates_cells *cells,
                                     const air_ordinates_params *params);

/* Runs. The context chooses the instruction set and hears what is wrong; NULL is legal. AIR_CPU_C
 * computes in doubles, others in floats side by side, within 3.5e-5 of a cell's power in each share
 * and step. SIX, and runs that want bins, are computed in doubles by all of them: CM then takes
 * some 40 times as long, SIX hundreds of times. AIR_ERROR_ARGUMENT: a size, parameter or
 * coefficient is out of range, scratch is not aligned; results are then untouched. [Elek2014, eqs.
 * 1-8] */
AIR_API air_status air_ordinates_run(air_context *context, const air_ordinates_cells *cells,
                                     const air_ordinates_params *params, void *scratch,
                                     const air_ordinates_results *results);

/* ---- the formulas ---- */

/* Shares of a Henyey-Greenstein lobe about +k of mean cosine a, in [-1, 1], that leave through the
 * cone ahead (45 degrees), each of four side patches, and the cone behind; and the mean cosine to
 * +k that each of the three carries, times its share. front + 4 side + back = 1; front_mean + 4
 * side_mean + back_mean = a. [Elek2014, eqs. 1-3], in a form without singularities. */
typedef struct air_ordinates_shares {
    double front, side, back;
    double front_mean, side_mean, back_mean;
} air_ordinates_shares;
AIR_API air_ordinates_shares air_ordinates_shares_of(double a);

#ifdef __cplusplus
}
#endif
#endif
