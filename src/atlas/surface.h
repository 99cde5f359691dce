/* surface.h: triangles with texture coordinates, as all of this room takes them. */
#ifndef AIR_ATLAS_SURFACE_H
#define AIR_ATLAS_SURFACE_H

#include <stddef.h>
#include <stdint.h>

/* The chart of a texel that no triangle touches. */
#define AIR_NO_CHART UINT32_MAX

/* A mesh and its place on a page. Texel coordinates are uv * size + offset; v points downwards as
 * in glTF; texel (i, j) is the square [i, i+1) x [j, j+1). All arrays are borrowed. A page may hold
 * several parts; their triangles and charts are numbered through in the order of the parts. */
typedef struct air_atlas_part {
    const float *positions;  /* 3 per vertex; NULL where only uv matters */
    const float *uv;         /* 2 per vertex */
    const uint32_t *indices; /* 3 per triangle, all below vertex_count */
    size_t vertex_count;
    size_t triangle_count;
    double offset[2], size[2]; /* texels; size > 0 */
    const uint32_t *charts;    /* chart of each triangle, from 0; NULL: islands.h finds them */
} air_atlas_part;

#endif
