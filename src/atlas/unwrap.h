/* unwrap.h: texture coordinates for a mesh that has none: flat charts by direction.
 *
 * A chart is a connected set of triangles whose normals lie within an angle of its mean and whose
 * projection along that mean neither folds nor overlaps itself. It is turned to its smallest
 * bounding rectangle and laid out in texels; pack.h puts the rectangles on pages. */
#ifndef AIR_ATLAS_UNWRAP_H
#define AIR_ATLAS_UNWRAP_H

#include "core/host.h"

typedef struct air_unwrap_params {
    double texels_per_metre; /* > 0; default 10 */
    double angle_rad;        /* of normals to the chart's, (0, 80 degrees]; default 40 degrees */
    /* Charts of less than merge_texels texels of area join a neighbour where their normals are
     * within merge_angle_rad of its mean and nothing overlaps. Defaults 8 and 65 degrees; an angle
     * of at most 80 degrees. */
    double merge_texels, merge_angle_rad;
    bool snap; /* stretch charts to whole texels: rows of texels then end at borders; default true
                */
} air_unwrap_params;

void air_unwrap_params_default(air_unwrap_params *params);

typedef struct air_unwrap_chart {
    double extent[2];   /* texels, x and y: coordinates are in [0, extent] */
    uint32_t texels[2]; /* extent rounded up, at least 1 */
    double normal[3];   /* unit; that of the projection */
    size_t triangle_count;
} air_unwrap_chart;

/* Triangles are those of the input in their order, with vertices of their own. Seen from the front
 * (counterclockwise), x points right and y down, as glTF's uv do: charts are not mirrored. */
typedef struct air_unwrap {
    uint32_t *vertices; /* of each new vertex, the old one */
    float *places;      /* 2 per new vertex: texels in its chart */
    size_t vertex_count;
    uint32_t *indices;         /* 3 per triangle: new vertices */
    uint32_t *triangle_charts; /* 1 per triangle */
    size_t triangle_count;
    air_unwrap_chart *charts;
    size_t chart_count; /* at least 1 unless there are no triangles */
} air_unwrap;

/* positions: 3 per vertex, finite. Any soup of triangles will do: open, closed, one-sided, with
 * sides of many triangles, duplicates, or pieces apart; vertices at equal positions count as one.
 * Triangles without area join a neighbour's chart; where there is none, they are a point of chart
 * 0. Deterministic. Free with air_unwrap_destroy. AIR_ERROR_ARGUMENT: a parameter or an index out
 * of range, a position that is not finite. */
air_status air_unwrap_create(air_context *context, const float *positions, size_t vertex_count,
                             const uint32_t *indices, size_t triangle_count,
                             const air_unwrap_params *params, air_unwrap **out_unwrap);
void air_unwrap_destroy(air_context *context, air_unwrap *unwrap); /* NULL is legal */

/* How good an unwrap is. Singular values are those of the map from the surface, in metres times
 * texels_per_metre, to texels: 1 is perfect. Means are weighted by area. */
typedef struct air_unwrap_quality {
    double least_stretch, most_stretch; /* of all singular values */
    double mean_stretch;                /* sqrt of the mean of (s1^2 + s2^2) / 2 */
    double utilisation;                 /* area of triangles by that of the charts' texels */
} air_unwrap_quality;

air_unwrap_quality air_unwrap_measure(const air_unwrap *unwrap, const float *positions,
                                      double texels_per_metre);

#endif
