/* ordinates_dom.h: light that is scattered many times in a box of cells, by discrete ordinates.
 *
 * Unscattered light is the caller's: as moments of its radiance in each cell, whatever lights it
 * comes from. One solution then serves all lights at once, for it is linear in them. Radiance is
 * followed along the directions of a product rule over the sphere, cell by cell; phase functions
 * are Legendre series of `bands` terms whose forward peak is left in the unscattered light
 * (delta-M, src/ordinates/README.md).
 *
 * Moments are coefficients of real spherical harmonics (src/core/harmonics.h) of directions of
 * TRAVEL in world axes, laid out moment l*l + l + m of cell (i, j, k), channel c:
 *
 *     [(((k * size[1] + j) * size[0] + i) * bands * bands + l*l + l + m) * 4 + c]
 *
 * with three channels; the fourth is 0. The fluence is moment 0 times sqrt(4 pi). */
#ifndef AIRLIGHT_ORDINATES_DOM_H
#define AIRLIGHT_ORDINATES_DOM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    AIR_DOM_SIZE_MAX = 512,
    AIR_DOM_BANDS_MAX = 10,
    AIR_DOM_POLAR_MAX = 64,
    AIR_DOM_DEPTH_MAX = 8,
    AIR_DOM_STRIDE = 4 /* floats per moment: three channels and a 0 */
};

typedef struct air_dom_params {
    size_t size[3];  /* cells along x, y, z: 1..AIR_DOM_SIZE_MAX */
    float cell_m[3]; /* edges of a cell, 1e-6 .. 1e6 */
    int bands;       /* of Legendre series, 1..AIR_DOM_BANDS_MAX; default 4 */
    int polar;    /* Gauss-Legendre nodes of the cosine to z: even, >= bands and <= 64; default 4 */
    int azimuths; /* even round z: a multiple of 4, >= 2 * bands and <= 128; default 8 */
    bool delta_m; /* leave the forward peak in the unscattered light; default true */
    bool diamond; /* differences of second order where they stay positive; else of first
                     everywhere, which blurs; default true */
} air_dom_params;

/* 4 bands, 4 x 8 directions; size and edges are the caller's. */
AIR_API void air_dom_params_default(air_dom_params *params);

/* The bytes that a solver will take, but for some hundred per array; twice as many with a context
 * of AIR_CPU_C. depth: of air_dom_solve_params. SIZE_MAX: too many to count. */
AIR_API size_t air_dom_bytes(const air_dom_params *params, int depth);

typedef struct air_dom air_dom;

/* An empty box. AIR_ERROR_ARGUMENT: a parameter is out of range; AIR_ERROR_MEMORY. With a context
 * of AIR_CPU_C everything is computed in doubles, else in floats. */
AIR_API air_status air_dom_create(air_context *context, const air_dom_params *params,
                                  air_dom **out_dom);
AIR_API void air_dom_destroy(air_dom *dom); /* NULL is legal */

/* The phase function. */
typedef struct air_dom_phase {
    /* Henyey-Greenstein of mean cosine g in (-1, 1) in every cell and channel: three planes; or
     * NULL */
    const float *g;
    /* for g NULL, one for all cells: the means of P_1 .. P_bands, in [-1, 1], the last < 1 */
    double legendre[AIR_DOM_BANDS_MAX];
} air_dom_phase;

/* Coefficients per metre, >= 0 and together <= 1e9: three planes of size[0] * size[1] * size[2]
 * numbers, one per channel; copied. The solution stays: the next solve starts from it.
 * AIR_ERROR_ARGUMENT names the first number that is out of range; the medium is then as before. */
AIR_API air_status air_dom_set_medium(air_dom *dom, const float *sigma_s, const float *sigma_a,
                                      const air_dom_phase *phase);

/* The share of scattering that counts as none: the mean of P_bands where that is positive, with
 * delta-M; else 0. Unscattered light must be attenuated by sigma_s (1 - peak) + sigma_a. */
AIR_API double air_dom_peak(const air_dom_params *params, double last_legendre);

/* Moments of the unscattered radiance, mean over each cell; copied. NULL: 0, as after creation.
 * AIR_ERROR_ARGUMENT names the first that is larger than 1e15, or is a fluence below 0; the light
 * is then as before. Whether a solve has come to an end is seen for light above 1e-12 or so. */
AIR_API air_status air_dom_set_light(air_dom *dom, const float *moments);

/* Light that enters through the boundary and is followed like what was scattered, on the faces
 * whose bits are set: 1 << 0 .. 5 for -x, +x, -y, +y, -z, +z. The radiance along every direction
 * is the sum of bands * bands moments (moment-major, stride 4), where that is positive. NULL: none,
 * as after creation. It is how solvers in harmonics alone treat beams; unscattered light is better
 * (air_dom_set_light). AIR_ERROR_ARGUMENT: likewise, or another bit is set. */
AIR_API air_status air_dom_set_inflow(air_dom *dom, const float *moments, uint32_t faces);

/* ---- what solvers in harmonics alone do, to compare with ---- */

/* First differences, no delta-M, the fewest directions for the bands (1..AIR_DOM_BANDS_MAX); size
 * and edges stay. */
AIR_API void air_dom_params_shdom(air_dom_params *params, int bands);

/* Moments of a beam's radiance (bands * bands, stride 4), for air_dom_set_inflow: those of a Dirac
 * along the unit direction of travel `dir`, with a Hanning window (1 + cos(pi l / bands)) / 2
 * against ringing. irradiance: across the beam, of three channels. lobe: mean cosine of a light
 * that is spread like Henyey and Greenstein's phase function, 1 for a beam. Of several lights the
 * moments are added up. */
AIR_API void air_dom_hanning_beam(int bands, const double dir[3], const double irradiance[3],
                                  double lobe, float *out_moments);

/* ---- solving ---- */

/* The directions of travel that are followed, and their solid angles, which sum to 4 pi. */
AIR_API size_t air_dom_direction_count(const air_dom_params *params);
AIR_API void air_dom_directions(const air_dom *dom, double (*out_dir)[3], double *out_solid_angle);

/* As air_dom_set_inflow, by the radiance along each of these directions: 4 numbers each, >= 0,
 * finite. */
AIR_API air_status air_dom_set_inflow_directions(air_dom *dom, const float *radiance,
                                                 uint32_t faces);

typedef struct air_dom_solve_params {
    uint32_t sweeps; /* at most, >= 1; default 32 */
    double change;   /* ends when a sweep changes the moments by less than this share of them (root
                        of sums of squares); >= 0; default 1e-3 */
    int depth;       /* of Anderson's acceleration, 0: none, so that sweep n adds light of n further
                        events; 0..AIR_DOM_DEPTH_MAX; default 4. It makes a sweep cost two to three
                        times as much, which fewer sweeps repay where light is scattered some ten
                        times on its way out */
    bool cold;       /* begin from no light, not from the solution before; default false */
} air_dom_solve_params;

AIR_API void air_dom_solve_params_default(air_dom_solve_params *params);

/* Where the power of one channel went, W: in = sum of out + absorbed + residual, to 1e-12 of it
 * (doubles) or 1e-5. */
typedef struct air_dom_books {
    double in;     /* scattered out of the unscattered light, and inflow */
    double out[6]; /* through the faces -x .. +z */
    double absorbed;
    double residual; /* what the last sweep's changes will still scatter */
} air_dom_books;

typedef struct air_dom_report {
    uint32_t sweeps; /* done */
    double change;   /* of the last one, as a share */
    air_dom_books books[3];
} air_dom_report;

/* Solves on the context's threads; the same bytes for any number of them. report may be NULL.
 * AIR_ERROR_MEMORY: then the solution is as before. */
AIR_API air_status air_dom_solve(air_dom *dom, const air_dom_solve_params *params,
                                 air_dom_report *report);

/* Moments of the scattered radiance, size[0] * size[1] * size[2] * bands^2 * 4 floats to out. */
AIR_API void air_dom_moments(const air_dom *dom, float *out);

/* What the next solve begins from, in place of the solution before: moments as air_dom_moments
 * gives them; copied. NULL: no light. AIR_ERROR_ARGUMENT: as air_dom_set_light; the solution is
 * then as before. */
AIR_API air_status air_dom_set_moments(air_dom *dom, const float *moments);

/* Moments of what is scattered in each cell per metre, over sigma_s: the source function towards a
 * direction of travel v is sigma_s times their sum with y_lm(v). Of light that was scattered
 * before; that of unscattered light is the caller's, with the whole phase function. */
AIR_API void air_dom_scattered(const air_dom *dom, float *out);

#ifdef __cplusplus
}
#endif
#endif
