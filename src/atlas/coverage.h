/* coverage.h: which triangles are in which texel of a page, and how much of it.
 *
 * Conservative: every texel that a triangle covers a positive area of has a fragment of it. A
 * fragment keeps triangle and area only, 8 bytes; its outline is cut again when it is asked for. A
 * texel of a covered band of rows costs 4 bytes and 8 per fragment: 201 MB for 4096 x 4096 texels
 * with a fragment each. */
#ifndef AIR_ATLAS_COVERAGE_H
#define AIR_ATLAS_COVERAGE_H

#include "atlas/coverage_clip.h"
#include "atlas/surface.h"
#include "core/host.h"

enum { AIR_COVERAGE_BAND = 16 }; /* rows that are kept together */

#define AIR_FRAGMENT_CENTRE 0x80000000u

typedef struct air_fragment {
    uint32_t tag; /* the triangle, counted through all parts; top bit: has the texel's centre */
    float area;   /* of the texel's 1, > 0 */
} air_fragment;

static inline uint32_t air_fragment_triangle(air_fragment fragment)
{
    return fragment.tag & ~AIR_FRAGMENT_CENTRE;
}

/* The fragments of 16 rows; first is NULL where there are none. */
typedef struct air_coverage_band {
    uint32_t *first; /* per texel and one more */
    air_fragment *fragments;
} air_coverage_band;

typedef struct air_coverage {
    size_t width, height;
    air_atlas_part *parts; /* a copy; what they point to is borrowed */
    size_t part_count;
    uint32_t *first_triangle; /* of each part, and one more */
    uint32_t *charts;         /* of each triangle, counted through all parts */
    size_t chart_count;
    air_coverage_band *bands;
    size_t band_count;
} air_coverage;

/* What is wrong with a layout, and what there is. Triangles are counted through all parts; "first"
 * is the smallest number and means nothing where its count is 0. */
typedef struct air_coverage_report {
    size_t degenerate_count; /* no area in space or in uv, or not finite: left out */
    uint32_t first_degenerate;
    size_t
        outside_count; /* triangles with uv outside [0, 1] by more than 2^-22: cut at the border */
    uint32_t first_outside;
    float outside_uv[2];
    size_t covered_texels, fragment_count;
} air_coverage_report;

/* parts: at least one; copied, their arrays must outlive the coverage. A part covers texels of its
 * own rectangle and of the page only. out_report may be NULL. Parallel over bands of rows; the same
 * for any number of threads. Time: linear in triangles and fragments, some 200 ns each.
 * AIR_ERROR_ARGUMENT: a page of 0 or above 65536 texels a side, 2^31 triangles or more, an index
 * out of range, a size that is not positive. Free with air_coverage_destroy. */
air_status air_coverage_create(air_context *context, size_t width, size_t height,
                               const air_atlas_part *parts, size_t part_count,
                               air_coverage **out_coverage, air_coverage_report *out_report);
void air_coverage_destroy(air_context *context, air_coverage *coverage); /* NULL is legal */

/* The fragments of a texel, by triangle. */
static inline const air_fragment *air_coverage_texel(const air_coverage *self, size_t x, size_t y,
                                                     size_t *out_count)
{
    const air_coverage_band *band = &self->bands[y / AIR_COVERAGE_BAND];
    if (band->first == NULL) {
        *out_count = 0;
        return NULL;
    }
    const uint32_t *first = band->first + (y % AIR_COVERAGE_BAND) * self->width + x;
    *out_count = first[1] - first[0];
    return band->fragments + first[0];
}

/* The covered area of a texel, in [0, 1] (where triangles overlap, cut at 1). */
float air_coverage_area(const air_coverage *self, size_t x, size_t y);

/* The part of a triangle, and its number there. */
size_t air_coverage_part(const air_coverage *self, uint32_t triangle, size_t *out_local);

/* A fragment's outline, relative to texel (x, y): in [0, 1]^2. Its area in doubles is the
 * fragment's before rounding. */
void air_coverage_outline(const air_coverage *self, size_t x, size_t y, uint32_t triangle,
                          air_piece *out_polygon);

/* A point of a triangle: weights of its three vertices, >= 0 with sum 1. */
typedef struct air_coverage_point {
    uint32_t triangle;
    double weights[3];
} air_coverage_point;

/* A point drawn uniformly over what is covered of the texel, from u in [0, 1)^2. A texel inside one
 * triangle is mapped as it is, so strata stay. False where nothing is covered. */
bool air_coverage_draw(const air_coverage *self, size_t x, size_t y, const double u[2],
                       air_coverage_point *out_point);

/* The point at the texel's centre; false where that is not covered. */
bool air_coverage_centre(const air_coverage *self, size_t x, size_t y,
                         air_coverage_point *out_point);

/* Planes of width x height: the chart of each texel's largest fragment (equal: of the first),
 * AIR_NO_CHART where nothing is; and the covered area. Either may be NULL. */
void air_coverage_planes(air_context *context, const air_coverage *self, uint32_t *out_charts,
                         float *out_areas);

/* Triangles whose insides overlap. */
typedef struct air_coverage_overlap {
    size_t texel_count;   /* texels in which two triangles overlap; 0: none */
    uint32_t texel[2];    /* the first one, by rows: x, y */
    uint32_t triangle[2]; /* two that overlap there, the smaller first */
} air_coverage_overlap;

/* Overlaps less deep than the rounding of uv are none: a coordinate made in float and moved once
 * more is off by 2^-24 of the part's size at most, so two triangles that touch, each with two
 * coordinates, overlap by up to 2 sqrt(2) 2^-24 size (7e-4 texels at 4096). Parallel; time as for
 * air_coverage_create, except in texels with many long thin triangles side by side. */
air_status air_coverage_find_overlap(air_context *context, const air_coverage *self,
                                     air_coverage_overlap *out_overlap);

#endif
