/* triangle.h: areas of triangles on a page and in space, and which of them are none. */
#ifndef AIR_ATLAS_TRIANGLE_H
#define AIR_ATLAS_TRIANGLE_H

/* Positive where a, b, c is counterclockwise (y upwards). */
static inline double air_doubled_area(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

#endif
