/* separation.h: do two triangles of a plane overlap? */
#ifndef AIR_ATLAS_SEPARATION_H
#define AIR_ATLAS_SEPARATION_H

#include <math.h>
#include <stdbool.h>

/* A counterclockwise triangle with a positive area: corners, and unit vectors along its sides. */
typedef struct air_flat_triangle {
    double point[3][2], way[3][2];
} air_flat_triangle;

static inline void air_flat_triangle_set_ways(air_flat_triangle *self)
{
    for (int i = 0; i < 3; i++) {
        const double *a = self->point[i], *b = self->point[i < 2 ? i + 1 : 0];
        const double way[2] = {b[0] - a[0], b[1] - a[1]};
        const double length = sqrt(way[0] * way[0] + way[1] * way[1]);
        self->way[i][0] = way[0] / length;
        self->way[i][1] = way[1] / length;
    }
}

/* Is the other triangle beyond one of self's sides, but for a depth of at most `tolerance`? Two
 * triangles are apart where this holds one way or the other. */
static inline bool air_flat_triangle_parts(const air_flat_triangle *self,
                                           const air_flat_triangle *other, double tolerance)
{
    for (int i = 0; i < 3; i++) {
        const double *from = self->point[i], *way = self->way[i];
        double deepest = -INFINITY;
        for (int k = 0; k < 3; k++) {
            const double *p = other->point[k];
            const double depth = way[0] * (p[1] - from[1]) - way[1] * (p[0] - from[0]);
            deepest = depth > deepest ? depth : deepest;
        }
        if (deepest <= tolerance) {
            return true;
        }
    }
    return false;
}

static inline bool air_flat_triangles_overlap(const air_flat_triangle *a,
                                              const air_flat_triangle *b, double tolerance)
{
    return !air_flat_triangle_parts(a, b, tolerance) && !air_flat_triangle_parts(b, a, tolerance);
}

#endif
