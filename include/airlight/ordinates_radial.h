/* ordinates_radial.h: light carried outwards from a point, a lamp or a small patch of surface,
 * through shells around it, step by step [Elek2014, sec. 6], as corrected in
 * src/ordinates/README.md.
 *
 * A grid has n x n directions, the cells of the octahedral square, and shells of which each is as
 * deep as its cells are wide. At a cell the principal direction d points away from the light; a
 * step sends the cell's power on to the shells in front and behind and sideways. Kernels over
 * arrays: no scene, no threads, no allocation. Functions of different arrays may run at once.
 *
 * Units: metres, 1/m, W. One colour channel. Cell (u, v) of shell k is entry (k * n + v) * n + u of
 * every array. Axes are the caller's; positions are relative to the light. */
#ifndef AIRLIGHT_ORDINATES_RADIAL_H
#define AIRLIGHT_ORDINATES_RADIAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/ordinates.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    AIR_RADIAL_DIRECTIONS_MIN = 4,
    AIR_RADIAL_DIRECTIONS_MAX = 128,
    AIR_RADIAL_SHELLS_MIN = 2,
    AIR_RADIAL_SHELLS_MAX = 256
};

typedef struct air_radial_grid {
    uint32_t directions; /* n, even, so that every cell's edges are arcs of great circles */
    uint32_t shells;     /* K; the first must begin no further in than 1e-12 R */
    float radius_m;      /* R: where the last shell ends; 1e-15..1e15 */
} air_radial_grid;

/* ---- geometry; arguments are not checked but by assert ---- */

/* Where shell k begins: R rho^(k - K), rho = 1 + sqrt(4 pi) / n; k in [0, K], K: R. */
AIR_API double air_radial_radius(const air_radial_grid *grid, uint32_t k);

/* The direction of the centre of cell (u, v), unit. The square [-1, 1]^2 is an octahedron unfolded:
 * its centre is +z, its corners -z, the middles of its edges +-x, +-y. */
AIR_API void air_radial_direction(uint32_t n, uint32_t u, uint32_t v, double out_direction[3]);

/* Solid angles of the n * n cells, sr: exact to rounding, 4 pi together. */
AIR_API void air_radial_solid_angles(uint32_t n, double *out_solid_angles);

/* The volume of a cell of this solid angle in shell k, m^3. */
AIR_API double air_radial_volume(const air_radial_grid *grid, uint32_t k, double solid_angle);

/* The cell v * n + u beyond an edge of (u, v); sides are u - 1, u + 1, v - 1, v + 1. Each edge of
 * the square is glued to itself, turned round: (x, 1) is (-x, 1). So the square is no torus. */
AIR_API uint32_t air_radial_neighbour(uint32_t n, uint32_t u, uint32_t v, int side);

/* The length of that edge on the unit sphere, rad. The face between the two cells has the area arc
 * (r_o^2 - r_i^2) / 2. */
AIR_API double air_radial_arc(uint32_t n, uint32_t u, uint32_t v, int side);

/* The cell that looks the opposite way; exactly so. */
AIR_API uint32_t air_radial_opposite(uint32_t n, uint32_t u, uint32_t v);

/* The four cells whose centres surround a direction (any length but 0) and their bilinear weights
 * (>= 0, sum 1). Around +-x and +-y, where only two cells meet, each may come twice. */
AIR_API void air_radial_surrounding(uint32_t n, const double direction[3], uint32_t out_cells[4],
                                    double out_weights[4]);

/* ---- light ---- */

/* Intensities of a patch of surface that reflects diffusely about the unit normal, W/sr, n * n of
 * them: proportional to max(0, normal.d), 1 W together. */
AIR_API void air_radial_cosine_lobe(uint32_t n, const float normal[3], float *out_intensity);

/* What the grid starts with. Borrowed. */
typedef struct air_radial_light {
    const float *intensity;  /* n * n, W/sr, >= 0; NULL: 1 everywhere */
    const float *visibility; /* per cell, in [0, 1]: the share of the beam that surfaces let through
                                to it; NULL: 1. What they hide is gone. */
    float lobe; /* mean cosine of the beam to d: 1 for a point, less for one light that stands for
                   many; in [0, 1] */
} air_radial_light;

/* ---- propagation ---- */

typedef struct air_radial_cells {
    air_radial_grid grid;
    const float *sigma_s, *sigma_a; /* 1/m, >= 0, finite */
    const float *g;                 /* mean cosine of scattering, in (-1, 1) */
} air_radial_cells;

/* How light moves from direction to direction within a shell. Either way a field that is the same
 * in all directions stays so. */
typedef enum air_radial_lateral {
    AIR_RADIAL_SPREAD = 0, /* as straight paths between turns do: diffusion over the sphere, by the
                              distance for which light keeps going sideways */
    AIR_RADIAL_SIDES = 1   /* the stencil's side shares, to the four neighbours by shared arc: moves
                              light by one cell a step whatever the medium, far too little */
} air_radial_lateral;

typedef struct air_radial_params {
    air_ordinates_stencil stencil; /* CM or LITERAL; default CM */
    air_ordinates_decay decay;     /* default POISSON */
    air_ordinates_start start;     /* FIRST_SCATTER or BOUNDARY; default FIRST_SCATTER */
    air_radial_lateral lateral;    /* default SPREAD; LITERAL needs SIDES */
    bool curvature;  /* straight paths turn radial, those out of the ball inside the first shell
                        too; default true; not with LITERAL (ignored) */
    uint32_t steps;  /* at most; 1..AIR_ORDINATES_STEPS_MAX; default 128 */
    double residual; /* ends when no more than this share of what came in is under way; >= 0;
                        default 1e-3 */
} air_radial_params;

AIR_API void air_radial_params_default(air_radial_params *params);

/* Where the power went, W: in = out + absorbed + hidden + residual, to 1e-12 of it. */
typedef struct air_radial_books {
    double in;
    double out;      /* beyond R, the beam's rest included */
    double absorbed; /* by the medium */
    double hidden;   /* by surfaces (visibility) */
    double residual; /* still under way */
    uint32_t steps;  /* taken */
} air_radial_books;

/* What is wanted; the caller's arrays, one number per cell but where said; NULL: not wanted. */
typedef struct air_radial_results {
    float *fluence;           /* W/m^2: with FIRST_SCATTER what was scattered, else everything */
    float *beam;              /* FIRST_SCATTER: fluence of the unscattered beam; else 0 */
    const float *view_cosine; /* d.v, v the unit vector from the cell to the observer; in */
    float *seen;      /* needs view_cosine: phase-weighted fluence, W/(m^2 sr): times sigma_s
                         the radiance that a metre of the cell sends there, the beam's included */
    size_t bins;      /* of the cosine to d, even on [-1, 1] */
    float *binned;    /* bins per cell: fluence by direction, without the beam */
    float *energy;    /* E at the end, W */
    float *asymmetry; /* a at the end */
    air_radial_books *books;
} air_radial_results;

/* Bytes of scratch that a run needs, aligned to 8; 0: the grid is out of range. */
AIR_API size_t air_radial_scratch(const air_radial_grid *grid);

/* Runs, in doubles. light NULL: 1 W/sr everywhere, a beam. AIR_ERROR_ARGUMENT: a size, parameter,
 * coefficient or intensity is out of range; results are then untouched. The context only hears the
 * sentence about it and may be NULL. [Elek2014, eqs. 1-8, sec. 6] */
AIR_API air_status air_radial_run(air_context *context, const air_radial_cells *cells,
                                  const air_radial_light *light, const air_radial_params *params,
                                  void *scratch, const air_radial_results *results);

/* ---- looking up ---- */

/* Values of a grid (such as fluence) at count points relative to the light, m: bilinear between
 * centres of directions, linear in log r between those of shells, constant from the innermost
 * centre inwards (fluence grows no more there: 1/r^2 ends at about r_0) and from the outermost
 * outwards, 0 beyond R. Coordinates are finite; out may be one of their arrays. */
AIR_API void air_radial_look_up(const air_radial_grid *grid, const float *values, size_t count,
                                const float *x, const float *y, const float *z, float *out);

#ifdef __cplusplus
}
#endif
#endif
