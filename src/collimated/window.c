/* window.c: a ray against a window swept along the light: in the plane across the light, a line
 * against a polygon, inside by the even-odd rule. */
#include <math.h>

#include "collimated/planes.h"

/* Below this sine the ray counts as parallel to the light: all along it the window is passed, or
 * nowhere. At 1 km the ray has moved across the light by 1 nm. */
static const double parallel_sine = 1e-12;

static bool polygon_holds(const double *window, size_t count, const double p[2])
{
    bool inside = false;
    for (size_t i = 0, j = count - 1; i < count; j = i++) {
        const double *a = window + 2 * i, *b = window + 2 * j;
        if ((a[1] > p[1]) != (b[1] > p[1]) &&
            p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0]) {
            inside = !inside;
        }
    }
    return inside;
}

/* The k-th of the crossings, which wait in the ends of the intervals. */
static double *crossing(air_interval *out, size_t k)
{
    return k % 2 == 0 ? &out[k / 2].begin : &out[k / 2].end;
}

static void insert_crossing(air_interval *out, size_t count, double t)
{
    size_t k = count;
    for (; k > 0 && *crossing(out, k - 1) > t; k--) {
        *crossing(out, k) = *crossing(out, k - 1);
    }
    *crossing(out, k) = t;
}

/* Crossings of the line o + t w with the polygon's edges, sorted; their number is even. A vertex on
 * the line belongs to its left side, so edges that meet there are crossed once, twice or not at
 * all, as the polygon has it there. An edge gives the same t, bit for bit, from both of its sides:
 * windows that share one neither overlap nor leave a gap. */
static size_t polygon_crossings(const double *window, size_t vertex_count, const double o[2],
                                const double w[2], double w2, air_interval *out)
{
    size_t count = 0;
    for (size_t i = 0, j = vertex_count - 1; i < vertex_count; j = i++) {
        const double a[2] = {window[2 * i] - o[0], window[2 * i + 1] - o[1]};
        const double b[2] = {window[2 * j] - o[0], window[2 * j + 1] - o[1]};
        const double side_a = w[0] * a[1] - w[1] * a[0], side_b = w[0] * b[1] - w[1] * b[0];
        if ((side_a >= 0.0) != (side_b >= 0.0)) {
            const double along_a = w[0] * a[0] + w[1] * a[1], along_b = w[0] * b[0] + w[1] * b[1];
            const double t = (along_a * side_b - along_b * side_a) / (side_b - side_a) / w2;
            insert_crossing(out, count++, t);
        }
    }
    return count;
}

size_t air_collimated_window(const double *window, size_t vertex_count, const double axis_s[3],
                             const double axis_t[3], const double origin[3], const double dir[3],
                             double begin, double end, air_interval *out)
{
    if (vertex_count < 3 || !(begin < end) || !air_finite3(origin) || !air_finite3(dir) ||
        !air_finite3(axis_s) || !air_finite3(axis_t)) {
        return 0;
    }
    const double o[2] = {air_dot3(origin, axis_s), air_dot3(origin, axis_t)};
    const double w[2] = {air_dot3(dir, axis_s), air_dot3(dir, axis_t)};
    const double w2 = w[0] * w[0] + w[1] * w[1];
    if (!(w2 > parallel_sine * parallel_sine)) {
        out[0] = (air_interval){begin, end};
        return polygon_holds(window, vertex_count, o) ? 1 : 0;
    }
    const size_t count = polygon_crossings(window, vertex_count, o, w, w2, out) / 2;
    for (size_t i = 0; i < count; i++) {
        out[i].begin = double_max(begin, out[i].begin); /* NaN stays, and is dropped below */
        out[i].end = double_min(end, out[i].end);
    }
    return air_intervals_join(out, count);
}
