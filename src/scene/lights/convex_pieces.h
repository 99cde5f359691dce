/* convex_pieces.h: few convex polygons instead of many triangles. */
#ifndef AIR_SCENE_LIGHTS_CONVEX_PIECES_H
#define AIR_SCENE_LIGHTS_CONVEX_PIECES_H

#include "airlight/arealight.h"

/* Flat convex polygons of 3 to AIR_AREA_MAX_VERTICES corners, one after the other. */
typedef struct air_convex_pieces {
    size_t count;
    size_t *ends;         /* one past the last corner of each piece */
    double (*corners)[3]; /* counter-clockwise as the triangles were */
} air_convex_pieces;

/* Joins triangles that lie in one plane and share a side, and what comes of them, as long as it is
 * convex [Hertel1983]. Triangles that nothing joins stay as they are; those without area are left
 * out. Pieces cover what the triangles cover and turn the way they do, to within rounding of float
 * coordinates (2^-20 of the largest one). Corners that turn by no more than that go.
 *
 * vertices: 3 per triangle, finite, borrowed. Triangles are neighbours where they pass through two
 * equal points in opposite order. The result depends on nothing but the input, in its order; time
 * is that of sorting the sides, a bounded number of times. The caller frees *out by
 * air_convex_pieces_finish; after AIR_ERROR_MEMORY and AIR_ERROR_UNSUPPORTED (2^32 vertices or
 * more) it is empty. */
air_status air_convex_pieces_make(air_context *context, const double (*vertices)[3],
                                  size_t triangle_count, air_convex_pieces *out);
void air_convex_pieces_finish(air_context *context, air_convex_pieces *pieces);

#endif
