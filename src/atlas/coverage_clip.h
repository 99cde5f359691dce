/* coverage_clip.h: the piece of a triangle inside a texel, in doubles.
 *
 * Texel coordinates of a triangle are exact: 24 bits of uv by a size, plus an offset. They are kept
 * relative to a whole texel near the triangle, which loses nothing, so the errors of a piece are
 * those of the triangle's own extent. */
#ifndef AIR_ATLAS_COVERAGE_CLIP_H
#define AIR_ATLAS_COVERAGE_CLIP_H

#include <stdbool.h>

#include "atlas/surface.h"

/* A triangle cut by four lines has at most 7 corners; three lines more make it 10. */
enum { AIR_PIECE_MAX = 10 };

typedef struct air_piece {
    int count;
    double point[AIR_PIECE_MAX][2];
} air_piece;

typedef struct air_texel_triangle {
    double point[3][2]; /* texels from origin; counterclockwise where y points upwards */
    double origin[2];   /* whole */
    bool flipped;       /* points 1 and 2 have changed places */
} air_texel_triangle;

/* Triangle t of the part. */
air_texel_triangle air_texel_triangle_of(const air_atlas_part *part, size_t t);

/* Keeps where coordinate `axis` is at least (upper false) or at most (upper true) `bound`. An edge
 * is cut at the same point from whichever side, so pieces fit. */
void air_piece_cut(const air_piece *in, int axis, double bound, bool upper, air_piece *out);

/* Keeps what is left of the line through `from` along the unit vector `way`, by at least `depth`.
 */
void air_piece_cut_line(const air_piece *in, const double from[2], const double way[2],
                        double depth, air_piece *out);

/* The piece in the row of texels y; from it that in column x. Texels too are counted from the
 * triangle's origin. */
void air_piece_row(const air_texel_triangle *triangle, double y, air_piece *out);
void air_piece_column(const air_piece *row, double x, air_piece *out);

/* Both in one; a texel inside the triangle gives its own four corners. */
void air_piece_texel(const air_texel_triangle *triangle, double x, double y, air_piece *out);

/* Are all four corners of texel (x, y) in the triangle? */
bool air_texel_triangle_has_texel(const air_texel_triangle *triangle, double x, double y);

/* Positive for counterclockwise. */
double air_piece_area(const air_piece *polygon);

/* Is a point in the triangle? Coordinates relative to its origin. Of triangles that share a side
 * with equal ends exactly one has a point on it. */
bool air_texel_triangle_has(const air_texel_triangle *triangle, const double point[2]);

#endif
