/* coverage_read.c: what a coverage says of a texel. */
#include "atlas/coverage.h"
#include "atlas/triangle.h"
#include "core/vec.h"

size_t air_coverage_part(const air_coverage *self, uint32_t triangle, size_t *out_local)
{
    size_t low = 0, high = self->part_count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (self->first_triangle[middle] <= triangle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    *out_local = triangle - self->first_triangle[low];
    return low;
}

static air_texel_triangle triangle_of(const air_coverage *self, uint32_t triangle)
{
    size_t local;
    const size_t part = air_coverage_part(self, triangle, &local);
    return air_texel_triangle_of(&self->parts[part], local);
}

static double sum_of_areas(const air_fragment *fragments, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)fragments[i].area;
    }
    return sum;
}

float air_coverage_area(const air_coverage *self, size_t x, size_t y)
{
    size_t count;
    const air_fragment *fragments = air_coverage_texel(self, x, y, &count);
    return (float)double_min(sum_of_areas(fragments, count), 1.0);
}

/* The outline relative to the triangle's origin. */
static void cut_out(const air_texel_triangle *triangle, size_t x, size_t y, air_piece *out)
{
    const double at_x = (double)x - triangle->origin[0], at_y = (double)y - triangle->origin[1];
    air_piece_texel(triangle, at_x, at_y, out);
}

void air_coverage_outline(const air_coverage *self, size_t x, size_t y, uint32_t triangle,
                          air_piece *out_polygon)
{
    const air_texel_triangle at = triangle_of(self, triangle);
    cut_out(&at, x, y, out_polygon);
    for (int i = 0; i < out_polygon->count; i++) {
        out_polygon->point[i][0] -= (double)x - at.origin[0];
        out_polygon->point[i][1] -= (double)y - at.origin[1];
    }
}

/* ---- points ---- */

/* What point (relative to the triangle's origin) is by its vertices; rounding below 0 is cut. */
static void weigh(const air_texel_triangle *triangle, const double point[2], double weights[3])
{
    double weight[3], sum = 0.0;
    for (int i = 0; i < 3; i++) {
        const double *a = triangle->point[(i + 1) % 3], *b = triangle->point[(i + 2) % 3];
        weight[i] = double_max(air_doubled_area(point, a, b), 0.0);
        sum += weight[i];
    }
    for (int i = 0; i < 3; i++) {
        const int from = triangle->flipped && i > 0 ? 3 - i : i;
        weights[i] = sum > 0.0 ? weight[from] / sum : 1.0 / 3.0;
    }
}

static double fan_area(const air_piece *p, int i)
{
    const double doubled = air_doubled_area(p->point[0], p->point[i], p->point[i + 1]);
    return 0.5 * double_max(doubled, 0.0);
}

/* The corners 0, i, i + 1 of the fan that a share of the area falls into; *share becomes that in
 * the corner's triangle. */
static int pick_of_fan(const air_piece *p, double *share)
{
    double all = 0.0, below = 0.0, area = 0.0;
    int i = 1;
    for (int k = 1; k + 1 < p->count; k++) {
        all += fan_area(p, k);
    }
    for (;; i++) {
        area = fan_area(p, i);
        if (i + 2 >= p->count || below + area > *share * all) {
            break;
        }
        below += area;
    }
    *share = area > 0.0 ? double_min(double_max((*share * all - below) / area, 0.0), 1.0) : 0.0;
    return i;
}

/* Uniform in the polygon. A whole texel takes u as it is; else a triangle of the fan about corner 0
 * is chosen and the square folded onto it [Heitz2019]. */
static void draw_in(const air_piece *p, const double u[2], double out[2])
{
    if (p->count == 4 && air_piece_area(p) == 1.0) {
        out[0] = p->point[0][0] + u[0];
        out[1] = p->point[0][1] + u[1];
        return;
    }
    double share = u[0];
    const int i = pick_of_fan(p, &share);
    const double fold = share < u[1] ? 0.5 * share : share - 0.5 * u[1];
    const double b1 = fold, b2 = share < u[1] ? u[1] - fold : 0.5 * u[1];
    const double *a = p->point[0], *b = p->point[i], *c = p->point[i + 1];
    for (int k = 0; k < 2; k++) {
        out[k] = a[k] + b1 * (b[k] - a[k]) + b2 * (c[k] - a[k]);
    }
}

bool air_coverage_draw(const air_coverage *self, size_t x, size_t y, const double u[2],
                       air_coverage_point *out_point)
{
    size_t count, i = 0;
    const air_fragment *fragments = air_coverage_texel(self, x, y, &count);
    if (count == 0) {
        return false;
    }
    const double target = u[0] * sum_of_areas(fragments, count);
    double below = 0.0;
    while (i + 1 < count && below + (double)fragments[i].area <= target) {
        below += (double)fragments[i++].area;
    }
    const double share = (target - below) / (double)fragments[i].area;
    const double rest[2] = {count == 1 ? u[0] : double_min(double_max(share, 0.0), 1.0), u[1]};
    const uint32_t number = air_fragment_triangle(fragments[i]);
    const air_texel_triangle triangle = triangle_of(self, number);
    air_piece outline;
    double point[2];
    cut_out(&triangle, x, y, &outline);
    draw_in(&outline, rest, point);
    out_point->triangle = number;
    weigh(&triangle, point, out_point->weights);
    return true;
}

bool air_coverage_centre(const air_coverage *self, size_t x, size_t y,
                         air_coverage_point *out_point)
{
    size_t count;
    const air_fragment *fragments = air_coverage_texel(self, x, y, &count);
    for (size_t i = 0; i < count; i++) {
        if ((fragments[i].tag & AIR_FRAGMENT_CENTRE) != 0) {
            const uint32_t number = air_fragment_triangle(fragments[i]);
            const air_texel_triangle triangle = triangle_of(self, number);
            const double point[2] = {(double)x + 0.5 - triangle.origin[0],
                                     (double)y + 0.5 - triangle.origin[1]};
            out_point->triangle = number;
            weigh(&triangle, point, out_point->weights);
            return true;
        }
    }
    return false;
}

/* ---- planes ---- */

typedef struct plane_work {
    const air_coverage *self;
    uint32_t *charts;
    float *areas;
} plane_work;

static void fill_row(void *user, size_t y, size_t worker)
{
    const plane_work *work = user;
    const air_coverage *self = work->self;
    (void)worker;
    for (size_t x = 0; x < self->width; x++) {
        size_t count;
        const air_fragment *fragments = air_coverage_texel(self, x, y, &count);
        size_t largest = 0;
        for (size_t i = 1; i < count; i++) {
            largest = fragments[i].area > fragments[largest].area ? i : largest;
        }
        if (work->charts != NULL) {
            work->charts[y * self->width + x] =
                count > 0 ? self->charts[air_fragment_triangle(fragments[largest])] : AIR_NO_CHART;
        }
        if (work->areas != NULL) {
            work->areas[y * self->width + x] =
                (float)double_min(sum_of_areas(fragments, count), 1.0);
        }
    }
}

void air_coverage_planes(air_context *context, const air_coverage *self, uint32_t *out_charts,
                         float *out_areas)
{
    plane_work work = {self, out_charts, out_areas};
    air_parallel_for(context, self->height, fill_row, &work);
}
