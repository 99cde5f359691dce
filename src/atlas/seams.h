/* seams.h: sides that are one in space and two on the page, and values that agree along them.
 *
 * The idea of least squares over samples of both sides is [Iwanicki2013]'s; here bilinear samples
 * are at most half a texel apart, and texels hold on to what they were by a weight. */
#ifndef AIR_ATLAS_SEAMS_H
#define AIR_ATLAS_SEAMS_H

#include "atlas/surface.h"
#include "core/host.h"

/* A side twice on a page: end 0 of the one is end 0 of the other in space. */
typedef struct air_seam {
    float place[2][2][2]; /* [side][end][x, y], texels of the page */
    uint32_t triangle[2]; /* counted through all parts */
    uint32_t page[2];
} air_seam;

typedef struct air_seams_find_params {
    double angle_rad; /* between the normals of both sides, [0, pi]; default 20 degrees */
} air_seams_find_params;

void air_seams_find_params_default(air_seams_find_params *params);

typedef struct air_seams {
    air_seam *seams;
    size_t count;
} air_seams;

/* normals: for each part 3 per vertex, or NULL; the array may be NULL: then triangles' normals are
 * compared, else those of the vertices at both ends. pages: the page of each part, or NULL: all 0.
 * Sides with equal positions, number by number, are one; of more than two the first two that fit
 * are a pair, then the next. Deterministic, linear. Free with air_seams_finish. */
air_status air_seams_find(air_context *context, const air_atlas_part *parts, size_t part_count,
                          const float *const *normals, const uint32_t *pages,
                          const air_seams_find_params *params, air_seams *out_seams);
void air_seams_finish(air_context *context, air_seams *seams);

/* One page for the solver: planes of width * height floats, and what of it is covered. */
typedef struct air_seams_page {
    size_t width, height;
    const uint32_t *charts; /* AIR_NO_CHART: a free texel, which may change more easily */
    float *const *planes;
} air_seams_page;

typedef struct air_seams_params {
    double hold;         /* weight of a covered texel's value against a sample; default 0.0003 */
    double hold_free;    /* of a free texel's; default 0.00015 */
    double stiffness;    /* weight of differences of changes within a footprint; default 0.0001 */
    uint32_t iterations; /* at most; default 2000 */
    double tolerance;    /* of the residual against its start; default 1e-4 */
    size_t light_planes; /* the first so many planes hold light: what is not below 0 stays so;
                            default 0 */
} air_seams_params;

void air_seams_params_default(air_seams_params *params);

typedef struct air_seams_report {
    size_t sample_count, texel_count; /* samples along seams; texels that may change */
    double rms_before, rms_after;     /* difference of both sides over all samples and planes */
    double most_before, most_after;
    uint32_t iterations; /* the most that a plane took */
} air_seams_report;

/* Makes least, by conjugate gradients [Hestenes1952]: the sum over samples of (difference of both
 * sides)^2, plus that over texels of hold * change^2, plus stiffness times that over samples, sides
 * and the four texels of each of (change - its mean over the four)^2. Only texels in the bilinear
 * footprints of seams change. Free texels there must have been filled (dilate.h). A jump across a
 * seam along the texels' rows shrinks to about hold / 4 of it; without stiffness neighbours swing
 * against each other beyond what they join. Texels of light that would fall below 0 are held at 0
 * and the others solved for anew. Each plane by itself: parallel over planes, deterministic.
 * out_report may be NULL. AIR_ERROR_ARGUMENT: a parameter out of range, a seam that names a page
 * that is not there. */
air_status air_seams_solve(air_context *context, const air_seams *seams,
                           const air_seams_page *pages, size_t page_count, size_t plane_count,
                           const air_seams_params *params, air_seams_report *out_report);

#endif
