/* coverage_clip.c: cutting by lines along the axes [Sutherland1974], areas, points. */
#include "atlas/coverage_clip.h"

#include <math.h>

#include "atlas/triangle.h"
#include "core/vec.h"

air_texel_triangle air_texel_triangle_of(const air_atlas_part *part, size_t t)
{
    air_texel_triangle self = {.flipped = false};
    for (int i = 0; i < 3; i++) {
        const float *uv = part->uv + 2 * (size_t)part->indices[3 * t + (size_t)i];
        for (int k = 0; k < 2; k++) {
            self.point[i][k] = (double)uv[k] * part->size[k] + part->offset[k];
        }
    }
    for (int k = 0; k < 2; k++) {
        const double least =
            double_min(double_min(self.point[0][k], self.point[1][k]), self.point[2][k]);
        self.origin[k] = floor(least);
        for (int i = 0; i < 3; i++) {
            self.point[i][k] -= self.origin[k];
        }
    }
    if (air_doubled_area(self.point[0], self.point[1], self.point[2]) < 0.0) {
        self.flipped = true;
        for (int k = 0; k < 2; k++) {
            const double kept = self.point[1][k];
            self.point[1][k] = self.point[2][k];
            self.point[2][k] = kept;
        }
    }
    return self;
}

static void add(air_piece *out, const double point[2])
{
    out->point[out->count][0] = point[0];
    out->point[out->count][1] = point[1];
    out->count++;
}

/* Where the edge meets the bound, counted from its lower end whichever way it runs. */
static void add_crossing(air_piece *out, int axis, double bound, const double *a, const double *b)
{
    const double *low = a[axis] < b[axis] ? a : b, *high = a[axis] < b[axis] ? b : a;
    const double share = (bound - low[axis]) / (high[axis] - low[axis]);
    const int other = 1 - axis;
    double point[2];
    point[axis] = bound;
    point[other] = low[other] + share * (high[other] - low[other]);
    add(out, point);
}

void air_piece_cut(const air_piece *in, int axis, double bound, bool upper, air_piece *out)
{
    const double sign = upper ? -1.0 : 1.0;
    out->count = 0;
    for (int i = 0; i < in->count; i++) {
        const double *a = in->point[i], *b = in->point[i + 1 < in->count ? i + 1 : 0];
        const double from = sign * (a[axis] - bound), to = sign * (b[axis] - bound);
        if (from >= 0.0) {
            add(out, a);
        }
        if ((from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0)) {
            add_crossing(out, axis, bound, a, b);
        }
    }
}

void air_piece_cut_line(const air_piece *in, const double from[2], const double way[2],
                        double depth, air_piece *out)
{
    out->count = 0;
    for (int i = 0; i < in->count && out->count + 2 <= AIR_PIECE_MAX; i++) {
        const double *a = in->point[i], *b = in->point[i + 1 < in->count ? i + 1 : 0];
        const double at_a = way[0] * (a[1] - from[1]) - way[1] * (a[0] - from[0]) - depth;
        const double at_b = way[0] * (b[1] - from[1]) - way[1] * (b[0] - from[0]) - depth;
        if (at_a >= 0.0) {
            add(out, a);
        }
        if ((at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0)) {
            const double share = at_a / (at_a - at_b);
            add(out, (double[2]){a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])});
        }
    }
}

static void cut_between(const air_piece *in, int axis, double low, air_piece *out)
{
    air_piece half;
    air_piece_cut(in, axis, low, false, &half);
    air_piece_cut(&half, axis, low + 1.0, true, out);
}

void air_piece_row(const air_texel_triangle *triangle, double y, air_piece *out)
{
    air_piece whole = {.count = 3};
    for (int i = 0; i < 3; i++) {
        whole.point[i][0] = triangle->point[i][0];
        whole.point[i][1] = triangle->point[i][1];
    }
    cut_between(&whole, 1, y, out);
}

/* For each side the corner that is farthest out decides. */
bool air_texel_triangle_has_texel(const air_texel_triangle *triangle, double x, double y)
{
    for (int i = 0; i < 3; i++) {
        const double *a = triangle->point[i], *b = triangle->point[i < 2 ? i + 1 : 0];
        const double corner[2] = {b[1] > a[1] ? x + 1.0 : x, b[0] > a[0] ? y : y + 1.0};
        if (air_doubled_area(a, b, corner) < 0.0) {
            return false;
        }
    }
    return true;
}

void air_piece_column(const air_piece *row, double x, air_piece *out)
{
    cut_between(row, 0, x, out);
}

void air_piece_texel(const air_texel_triangle *triangle, double x, double y, air_piece *out)
{
    air_piece row;
    if (air_texel_triangle_has_texel(triangle, x, y)) {
        *out = (air_piece){4, {{x, y}, {x + 1.0, y}, {x + 1.0, y + 1.0}, {x, y + 1.0}}};
        return;
    }
    air_piece_row(triangle, y, &row);
    air_piece_column(&row, x, out);
}

double air_piece_area(const air_piece *polygon)
{
    double sum = 0.0;
    for (int i = 1; i + 1 < polygon->count; i++) {
        sum += air_doubled_area(polygon->point[0], polygon->point[i], polygon->point[i + 1]);
    }
    return 0.5 * sum;
}

/* The ends in one order, so that both triangles of a side get the same number; on the line, sides
 * that run downwards, or to the right, have the point. */
bool air_texel_triangle_has(const air_texel_triangle *triangle, const double point[2])
{
    for (int i = 0; i < 3; i++) {
        const double *a = triangle->point[i], *b = triangle->point[i < 2 ? i + 1 : 0];
        const bool forward = a[1] < b[1] || (a[1] == b[1] && a[0] < b[0]);
        const double side =
            forward ? air_doubled_area(a, b, point) : -air_doubled_area(b, a, point);
        if (side < 0.0 || (side == 0.0 && !forward)) {
            return false;
        }
    }
    return true;
}
