/* ordinates_view.h: from light in cells to what an observer sees: the source function towards the
 * observer, its upsampling to the medium's own detail, and the march along camera rays.
 *
 * Plain functions over arrays, without threads or allocation. Boxes of cells begin at the origin;
 * cell (i, j, k) is number (k * size[1] + j) * size[0] + i; numbers of cells come in fours, three
 * channels and one that is said where it is used. Functions that take a range of k can run side by
 * side on disjoint ranges. The context chooses the instruction set; NULL is legal and takes the
 * plainest. */
#ifndef AIRLIGHT_ORDINATES_VIEW_H
#define AIRLIGHT_ORDINATES_VIEW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/context.h"
#include "airlight/medium.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- source functions ---- */

/* Cells and who looks at them. */
typedef struct air_seen_box {
    size_t size[3];
    float cell_m[3];
    bool distant;      /* the observer is infinitely far away: */
    float observer[3]; /* the unit direction in which light travels to it; else its position */
} air_seen_box;

/* Adds to out, for the cells of k in [begin, end), what moments of radiance (ordinates_dom.h; bands
 * of them) scatter towards the observer, over sigma_s: the sum of factors[l] c_lm y_lm. factors:
 * for a phase function the mean of P_l, less that of P_bands with delta-M. */
AIR_API void air_seen_moments(const air_context *context, const air_seen_box *box, int bands,
                              const float *moments, const double *factors, size_t begin, size_t end,
                              float *out);

/* Light whose fluence in each cell is fluence (4 numbers, the fourth the mean transmittance on the
 * way there) times power, of directions that spread with mean cosine lobe about one direction of
 * travel: dir, or (local) away from a position. */
typedef struct air_seen_beam {
    bool local;
    bool peakless; /* the peak (air_seen_peak) is not shown: the caller does it otherwise */
    float dir[3];  /* unit; or the position */
    float power[3];
    float lobe;
    const float *fluence;
} air_seen_beam;

/* The peak of a phase function that counts as no event (air_dom_peak): beams then hold what it
 * scatters as well, which must not be shown again each time that it happens on the way to the
 * observer, but once. */
typedef struct air_seen_peak {
    double share;       /* of the phase function, [0, 1); 0: none, and the rest is not looked at */
    double ratio;       /* optical depth of such events, over that of the others by which beams are
                           attenuated */
    const float *depth; /* the latter from each cell to the observer; NULL: 0 */
} air_seen_peak;

/* The value above which lies `share` of a phase function that rises ahead, seen in light of mean
 * cosine lobe. */
AIR_API float air_seen_cap(air_phase phase, float lobe, double share);

/* Adds what the phase function scatters of beams, likewise. The lobes widen the phase function:
 * mean cosines are multiplied. The peak is what of it is above a certain value. peak NULL: none.
 * [Elek2014, eq. 8] */
AIR_API void air_seen_beams(const air_context *context, const air_seen_box *box,
                            const air_seen_beam *beams, size_t count, air_phase phase,
                            const air_seen_peak *peak, size_t begin, size_t end, float *out);

/* Adds the moments of beams' radiance (ordinates_dom.h; bands of them) to out, likewise. */
AIR_API void air_beam_moments(const air_context *context, const air_seen_box *box,
                              const air_seen_beam *beams, size_t count, int bands, size_t begin,
                              size_t end, float *out);

/* ---- volumes ---- */

/* Voxels ready to be marched through: at each the radiance J that the medium tends to (its source
 * function over sigma_t) and its extinction. Trilinear between centres, held beyond the outermost.
 */
typedef struct air_volume {
    size_t size[3];
    float voxel_m[3];
    bool coloured; /* extinction differs between channels */
    /* Per voxel (J.r, J.g, J.b, sigma_t); coloured: (J.r, J.g, J.b, 0, sigma_t.r, .g, .b, the least
     * of these). */
    float *voxels;
    const uint8_t *empty; /* of voxels, how large cubes without extinction are from each on
                             (air_volume_find_empty): marches take no steps there; NULL */
} air_volume;

/* Fills voxels of k in [begin, end) from cells that fill the same box, of any number: J is
 * interpolated between cells, weighted by how near the cells' extinction is to the voxel's (joint
 * bilateral: w exp(-(s(p) - s(q))^2 / (2 r^2)), r a tenth of the largest extinction), or only
 * trilinear. sigma_t: of the voxels, 1 number each or 3 (coloured), borrowed. cell_j: 4 per cell,
 * the fourth the cell's extinction (mean over channels); largest: of all extinctions, > 0. */
AIR_API void air_volume_fill(const air_context *context, const air_volume *volume,
                             const float *sigma_t, const size_t cell_size[3], const float *cell_j,
                             bool bilateral, float largest, size_t begin, size_t end);

/* For each voxel, to out: how many voxels wide the largest cube is of which it is the lowest corner
 * and in which no extinction is above 0; 0 where its own is, 255 at most; beyond the volume there
 * is none. Of filled voxels; 0.8 ms for 64^3. */
AIR_API void air_volume_find_empty(const air_volume *volume, uint8_t *out);

/* Rays in the box's frame, coordinate by coordinate; dir of any length: t counts in it. */
typedef struct air_volume_rays {
    const float *origin[3], *dir[3];
    const float *t0, *t1; /* where the march begins and ends, within the box; t1 <= t0: nothing */
    const float *jitter;  /* where in each step it looks, [0, 1) */
} air_volume_rays;

/* Radiance that arrives at the origins and transmittance of the marched parts, in `steps` equal
 * steps each: in a step extinction and J are constant. Three arrays each; borrowed. */
AIR_API void air_volume_march(const air_context *context, const air_volume *volume,
                              const air_volume_rays *rays, size_t count, uint32_t steps,
                              float *const out_radiance[3], float *const out_transmittance[3]);

#ifdef __cplusplus
}
#endif
#endif
