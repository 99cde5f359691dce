/* radial.h: what the parts of the radial kernel share: its tables and its memory. */
#ifndef AIR_ORDINATES_RADIAL_H
#define AIR_ORDINATES_RADIAL_H

#include "airlight/ordinates_radial.h"

/* Tables of n * n directions, in the caller's scratch. */
typedef struct radial_mesh {
    size_t n, count; /* count = n * n */
    double *omega;   /* solid angles */
    uint32_t *opposite;
    /* SIDES: which part of the lateral power of neighbour[s] comes here, and what stays */
    uint32_t *neighbour[4];
    double *from[4], *stay;
    /* SPREAD: the cells in families of rings and chains, and the conductances (per unit of
     * diffusivity) from each to the next. Families 0 and 1: the square's columns close to n/2 rings
     * of 2n cells, column i upwards, then column n-1-i downwards, and so do its rows; cell q of
     * ring p is entry q * n/2 + p. Family 2: cells of one height z, chains of m in each quadrant;
     * entry t of the eight chains of both hemispheres side by side, first m = 1, up to n/2 - 1,
     * then the four of the equator. */
    uint32_t *order[3];
    double *link[3];
} radial_mesh;

/* One shell's sources: power W and power times mean cosine P that leave each cell. */
typedef struct radial_flux {
    double *front, *side, *back;
    double *front_mean, *side_mean, *back_mean;
} radial_flux;

/* A run in progress. Arrays of K n^2 doubles unless said. */
typedef struct radial_run {
    const air_radial_cells *cells;
    const air_radial_params *params;
    const air_radial_results *results;
    radial_mesh mesh;
    double lobe;          /* of the beam */
    bool curved;          /* CM with curvature */
    bool absorbing;       /* anywhere */
    double *energy;       /* E */
    double *mean;         /* a */
    double *scatter_half; /* optical distances, of the decay and of absorption, of half a cell */
    double *absorb_half;
    double *ease; /* of going sideways: mobility = ease l (1 - a^2), l of a cell as deep as 1 */
    double *path; /* sum of E l */
    double *seen; /* sum of E l f_hg, and the beam's */
    radial_flux flux[3]; /* ring of shells; n^2 each */
    double *mobility;    /* n^2 */
    double *rings[5];    /* n^2 each: for radial_spread */
    air_radial_books books;
} radial_run;

/* ---- radial_geometry.c ---- */

double radial_ratio(uint32_t n); /* rho */
void radial_mesh_fill(radial_mesh *mesh, const air_radial_params *params);

/* ---- radial_start.c: E, a and the beam's share of the results ---- */

void radial_begin(radial_run *run, const air_radial_light *light);
/* Adds a shell's pass to the results: weight times E l. paths: of a cell as deep as 1. */
void radial_count(radial_run *run, uint32_t k, const double *paths, double weight);

/* ---- radial_step.c ---- */

/* One step of all shells; weight: how much of a path the state at its beginning counts. */
void radial_step(radial_run *run, double weight);

/* ---- radial_spread.c ---- */

/* Moves the power and momentum of one shell between directions by diffusion with run->mobility, the
 * diffusivity of a step over the solid angle, rad^2 / sr: one implicit step per family of rings. */
void radial_spread(radial_run *run, double *energy, double *momentum);

#endif
