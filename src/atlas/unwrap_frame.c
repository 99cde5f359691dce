/* unwrap_frame.c: the convex hull by Andrew's monotone chain [Andrew1979], and rectangles along its
 * sides, of which the smallest has one [Freeman1975]. */
#include "atlas/unwrap_frame.h"

#include <math.h>
#include <stdlib.h>

#include "atlas/triangle.h"
#include "core/vec.h"

/* Round charts have hulls of many sides: so many are tried. The angle between two of those is then
 * at most 1.4 degrees or so, and the area within 3 % of the smallest. */
enum { MOST_SIDES = 256 };

static int compare_points(const void *a, const void *b)
{
    const double *x = a, *y = b;
    if (x[0] != y[0]) {
        return x[0] < y[0] ? -1 : 1;
    }
    return (x[1] > y[1]) - (x[1] < y[1]);
}

static size_t add_to_hull(double *hull, size_t count, size_t least, const double *p)
{
    while (count >= least + 2 &&
           air_doubled_area(hull + 2 * (count - 2), hull + 2 * (count - 1), p) <= 0.0) {
        count--;
    }
    hull[2 * count] = p[0];
    hull[2 * count + 1] = p[1];
    return count + 1;
}

/* The hull, counterclockwise, the first point again at its end; room for count + 1 points. */
static size_t find_hull(double *points, size_t count, double *hull)
{
    size_t size = 0;
    qsort(points, count, 2 * sizeof *points, compare_points);
    for (size_t i = 0; i < count; i++) {
        size = add_to_hull(hull, size, 0, points + 2 * i);
    }
    const size_t lower = size - 1;
    for (size_t i = count - 1; i-- > 0;) {
        size = add_to_hull(hull, size, lower, points + 2 * i);
    }
    return size;
}

static double rectangle_area(const double *hull, size_t size, const double right[2])
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < size; i++) {
        const double *p = hull + 2 * i;
        const double at[2] = {p[0] * right[0] + p[1] * right[1], p[1] * right[0] - p[0] * right[1]};
        for (int k = 0; k < 2; k++) {
            low[k] = double_min(low[k], at[k]);
            high[k] = double_max(high[k], at[k]);
        }
    }
    return (high[0] - low[0]) * (high[1] - low[1]);
}

/* The quarter turn of `right` whose up is nearest to that given. */
static void stand_up(const double up[2], double right[2])
{
    double best = -INFINITY, out[2] = {right[0], right[1]};
    double at[2] = {right[0], right[1]};
    for (int i = 0; i < 4; i++) {
        const double upright = at[0] * up[1] - at[1] * up[0];
        if (upright > best) {
            best = upright;
            out[0] = at[0];
            out[1] = at[1];
        }
        const double kept = at[0];
        at[0] = -at[1];
        at[1] = kept;
    }
    right[0] = out[0];
    right[1] = out[1];
}

void air_unwrap_frame(double *points, size_t count, double *hull, const double up[2],
                      double out_right[2])
{
    const size_t size = find_hull(points, count, hull);
    const double length = sqrt(up[0] * up[0] + up[1] * up[1]);
    const double upright[2] = {up[1] / length, -up[0] / length};
    const size_t step = size / MOST_SIDES + 1;
    double best = INFINITY;
    out_right[0] = upright[0];
    out_right[1] = upright[1];
    for (size_t i = 0; i + 1 < size; i += step) {
        const double *a = hull + 2 * i;
        const double way[2] = {a[2] - a[0], a[3] - a[1]};
        const double side = sqrt(way[0] * way[0] + way[1] * way[1]);
        const double right[2] = {way[0] / side, way[1] / side};
        const double area = side > 0.0 ? rectangle_area(hull, size, right) : INFINITY;
        if (area < best) {
            best = area;
            out_right[0] = right[0];
            out_right[1] = right[1];
        }
    }
    if (rectangle_area(hull, size, upright) <= 1.02 * best) {
        out_right[0] = upright[0];
        out_right[1] = upright[1];
    }
    stand_up(up, out_right);
}
