/* moment.c: the rectified shadow map, its sums and what rays read from them. */
#include "airlight/moment.h"

#include <math.h>
#include <string.h>

#include "collimated/moment_bound.h"
#include "core/host.h"
#include "core/triple.h"
#include "core/vec.h"

struct air_moment_map {
    air_context *context;
    air_moment_params params;
    double axis_s[3], axis_t[3]; /* perpendicular to the light: azimuth 0 and pi/2 */
    double row_step, rho_step;
    float *heights; /* rows of column_count */
    /* Rows of column_count + 1 sets of moment_count + 1: sums over a column and all beyond it.
     * Summed from the far end, where weights are small, so that a difference of two keeps its
     * digits however deep the medium is. Doubles: a stretch that has the share f of a sum takes
     * over its rounding over f, and the Hankel matrix of a stretch that one depth occludes is only
     * as regular as the bias makes it. Floats would do down to about f = 1e-3 at the usual biases;
     * with doubles the bias may be as small as 1e-10. */
    double *sums;
};

/* ---- geometry ---- */

/* The signed depth of a slope seen from the camera: -1 towards the light, 0 level, 1 away from it
 * and for nothing (z = -INFINITY). */
static double signed_depth(double z, double rho) { return -(2.0 / AIR_PI) * atan2(z, rho); }

static double row_azimuth(const air_moment_params *p, double row)
{
    return p->azimuth_begin + (p->azimuth_end - p->azimuth_begin) * (row / (double)p->row_count);
}

static double column_rho(const air_moment_params *p, double column)
{
    return p->rho_begin + (p->rho_end - p->rho_begin) * (column / (double)p->column_count);
}

static bool is_circle(const air_moment_params *p)
{
    return p->azimuth_end - p->azimuth_begin >= 2.0 * AIR_PI * (1.0 - 1e-12);
}

void air_moment_ray_origin(const air_moment_params *params, size_t row, size_t column,
                           double height, double out_origin[3])
{
    double s[3], t[3];
    air_axes_across(params->to_light, s, t);
    const double azimuth = row_azimuth(params, (double)row + 0.5);
    const double rho = column_rho(params, (double)column + 0.5);
    for (int i = 0; i < 3; i++) {
        out_origin[i] = params->origin[i] + rho * (cos(azimuth) * s[i] + sin(azimuth) * t[i]) +
                        height * params->to_light[i];
    }
}

/* ---- parameters ---- */

void air_moment_params_default(uint32_t moment_count, air_moment_params *params)
{
    *params = (air_moment_params){
        .to_light = {0.0, 1.0, 0.0},
        .azimuth_end = 2.0 * AIR_PI,
        .rho_end = 1.0,
        .row_count = 1024,
        .column_count = 512,
        .moment_count = moment_count,
        .bias = moment_count == 4 ? 6e-5 : 5e-4,
    };
}

void air_moment_choice_default(air_moment_choice *choice)
{
    *choice = (air_moment_choice){.overestimation = 0.0, .blend_rows = true};
}

/* Distance from the origin of the plane to the segment ab. */
static double segment_distance(const double a[2], const double b[2])
{
    const double d[2] = {b[0] - a[0], b[1] - a[1]};
    const double square = d[0] * d[0] + d[1] * d[1];
    const double along = square > 0.0 ? -(a[0] * d[0] + a[1] * d[1]) / square : 0.0;
    const double u = fmin(fmax(along, 0.0), 1.0);
    return hypot(a[0] + u * d[0], a[1] + u * d[1]);
}

void air_moment_params_fit(const double (*hull)[3], size_t hull_count, air_moment_params *params)
{
    double s[3], t[3], nearest = INFINITY, farthest = 0.0, widest = -1.0, after_gap = 0.0;
    air_axes_across(params->to_light, s, t);
    /* Each pair of points spans a segment inside the hull's projection, its edges are among them.
     * The widest gap between neighbouring azimuths is what no ray needs; none of pi or more means
     * that the axis goes through the hull. */
    for (size_t i = 0; i < hull_count; i++) {
        const double *o = params->origin;
        const double x[3] = {hull[i][0] - o[0], hull[i][1] - o[1], hull[i][2] - o[2]};
        const double a[2] = {air_dot3(x, s), air_dot3(x, t)};
        double gap = 2.0 * AIR_PI, next = atan2(a[1], a[0]);
        for (size_t k = 0; k < hull_count; k++) {
            const double y[3] = {hull[k][0] - o[0], hull[k][1] - o[1], hull[k][2] - o[2]};
            const double b[2] = {air_dot3(y, s), air_dot3(y, t)};
            nearest = fmin(nearest, segment_distance(a, b));
            double turn = atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
            turn += turn < 0.0 ? 2.0 * AIR_PI : 0.0;
            if (turn > 0.0 && turn < gap) {
                gap = turn;
                next = atan2(b[1], b[0]);
            }
        }
        farthest = fmax(farthest, hypot(a[0], a[1]));
        if (gap > widest) {
            widest = gap;
            after_gap = next;
        }
    }
    const bool outside = widest >= AIR_PI && nearest > 1e-9 * farthest;
    params->azimuth_begin = after_gap;
    params->azimuth_end = after_gap + (outside ? 2.0 * AIR_PI - widest : 2.0 * AIR_PI);
    params->rho_begin = outside ? nearest : 0.0;
    params->rho_end = farthest;
}

static const char *params_fault(const air_moment_params *p)
{
    if (!(isfinite(air_dot3(p->origin, p->origin)) &&
          fabs(air_dot3(p->to_light, p->to_light) - 1.0) < 1e-6)) {
        return "origin must be finite and to_light unit";
    }
    const double turn = p->azimuth_end - p->azimuth_begin;
    if (!(isfinite(p->azimuth_begin) && turn >= 0.0 && turn <= 2.0 * AIR_PI * (1.0 + 1e-12))) {
        return "azimuths must be finite and span 0 to 2 pi";
    }
    if (!(p->rho_begin >= 0.0 && p->rho_end > p->rho_begin && isfinite(p->rho_end))) {
        return "rho must run from >= 0 to something larger";
    }
    if (p->row_count == 0 || p->column_count == 0) {
        return "rows and columns must be at least 1";
    }
    if (p->moment_count != 4 && p->moment_count != 6) {
        return "moment_count must be 4 or 6";
    }
    if (!(p->sigma_t >= 0.0 && isfinite(p->sigma_t) && p->bias > 0.0 && p->bias <= 1.0)) {
        return "sigma_t must be >= 0 and finite, bias in (0, 1]";
    }
    return NULL;
}

/* ---- building ---- */

static void add_power_sums(double weight, double depth, size_t count, double *sums)
{
    for (size_t k = 0; k <= count; k++) {
        sums[k] += weight;
        weight *= depth;
    }
}

static void sum_row(void *user, size_t row, size_t worker)
{
    (void)worker;
    const air_moment_map *map = user;
    const air_moment_params *p = &map->params;
    const size_t columns = p->column_count, set = p->moment_count + 1u;
    const float *heights = map->heights + row * columns;
    double *sums = map->sums + row * (columns + 1) * set;
    for (size_t column = columns; column-- > 0;) {
        const double rho = column_rho(p, (double)column + 0.5);
        double *sum = sums + column * set;
        memcpy(sum, sum + set, set * sizeof *sum);
        add_power_sums(exp(-p->sigma_t * (rho - p->rho_begin)),
                       signed_depth((double)heights[column], rho), p->moment_count, sum);
    }
}

air_status air_moment_map_create(air_context *context, const air_moment_params *params,
                                 const float *heights, air_moment_map **out_map)
{
    *out_map = NULL;
    const char *fault = params_fault(params);
    if (fault != NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "moment map: %s", fault);
    }
    const size_t rows = params->row_count, columns = params->column_count;
    const size_t set_size = (params->moment_count + 1u) * sizeof(double);
    if (columns >= SIZE_MAX / set_size || rows > SIZE_MAX / columns) {
        return air_fail_memory(context, "moment map");
    }
    for (size_t i = 0; i < rows * columns; i++) {
        if (isnan(heights[i])) {
            return air_fail(context, AIR_ERROR_ARGUMENT, "moment map: height %zu is NaN", i);
        }
    }
    air_moment_map *map = air_allocate(context, 1, sizeof *map);
    if (map == NULL) {
        return air_fail_memory(context, "moment map");
    }
    map->context = context;
    map->params = *params;
    map->row_step = (params->azimuth_end - params->azimuth_begin) / (double)rows;
    map->rho_step = (params->rho_end - params->rho_begin) / (double)columns;
    air_axes_across(params->to_light, map->axis_s, map->axis_t);
    map->heights = air_allocate(context, rows * columns, sizeof *map->heights);
    map->sums = air_allocate(context, rows, (columns + 1) * set_size);
    if (map->heights == NULL || map->sums == NULL) {
        air_moment_map_destroy(map);
        return air_fail_memory(context, "moment map");
    }
    memcpy(map->heights, heights, rows * columns * sizeof *heights);
    air_parallel_for(context, rows, sum_row, map);
    *out_map = map;
    return AIR_OK;
}

void air_moment_map_destroy(air_moment_map *map)
{
    if (map == NULL) {
        return;
    }
    air_free(map->context, map->heights);
    air_free(map->context, map->sums);
    air_free(map->context, map);
}

/* ---- reading ---- */

/* A ray in the map's terms. */
typedef struct map_ray {
    double rise, run; /* z and rho per t */
    double row;       /* as a coordinate: the centre of row i is i */
    double x0, x1;    /* the stretch as column coordinates: column i is [i, i + 1] */
} map_ray;

static map_ray to_map(const air_moment_map *map, const double dir[3], double begin, double end)
{
    const air_moment_params *p = &map->params;
    const double s = air_dot3(dir, map->axis_s), t = air_dot3(dir, map->axis_t);
    map_ray ray = {.rise = air_dot3(dir, p->to_light), .run = hypot(s, t)};
    double turn = fmod(atan2(t, s) - p->azimuth_begin, 2.0 * AIR_PI);
    turn += turn < 0.0 ? 2.0 * AIR_PI : 0.0;
    /* Beyond the last row: is the first one nearer? */
    const double span = p->azimuth_end - p->azimuth_begin;
    turn -= turn - span > 2.0 * AIR_PI - turn ? 2.0 * AIR_PI : 0.0;
    ray.row = map->row_step > 0.0 ? turn / map->row_step - 0.5 : 0.0;
    const double most = (double)p->column_count;
    ray.x0 = fmin(fmax((ray.run * begin - p->rho_begin) / map->rho_step, 0.0), most);
    ray.x1 = fmin(fmax((ray.run * end - p->rho_begin) / map->rho_step, 0.0), most);
    return ray;
}

static size_t wrap_row(const air_moment_map *map, double row)
{
    const double count = (double)map->params.row_count;
    if (is_circle(&map->params)) {
        row -= row >= count ? count : 0.0;
        row += row < 0.0 ? count : 0.0;
    }
    return (size_t)fmin(fmax(row, 0.0), count - 1.0);
}

/* Sums over all beyond a column coordinate: linear within a column. Added to out times factor. */
static void add_sums_beyond(const air_moment_map *map, size_t row, double x, double factor,
                            double *out)
{
    const size_t columns = map->params.column_count, set = map->params.moment_count + 1u;
    const size_t column = x < (double)columns ? (size_t)x : columns - 1;
    const double part = x - (double)column;
    const double *sum = map->sums + (row * (columns + 1) + column) * set;
    for (size_t k = 0; k < set; k++) {
        out[k] += factor * ((1.0 - part) * sum[k] + part * sum[k + set]);
    }
}

/* A stretch within one column: how much of it lies below the column's height. */
static double direct_shadow(const air_moment_map *map, const map_ray *ray, double begin, double end)
{
    const size_t columns = map->params.column_count;
    const size_t column = (size_t)fmin(0.5 * (ray->x0 + ray->x1), (double)(columns - 1));
    const size_t row = wrap_row(map, floor(ray->row + 0.5));
    const double height = (double)map->heights[row * columns + column];
    const double z0 = ray->rise * begin, z1 = ray->rise * end;
    const double low = fmin(z0, z1), high = fmax(z0, z1);
    if (height >= high || height <= low) {
        return height > low ? 1.0 : 0.0;
    }
    return (height - low) / (high - low);
}

double air_moment_shadow(const air_moment_map *map, const double dir[3], double begin, double end,
                         const air_moment_choice *choice)
{
    const air_moment_params *p = &map->params;
    const map_ray ray = to_map(map, dir, begin, end);
    if (!(ray.x1 - ray.x0 > 1.0)) {
        return direct_shadow(map, &ray, begin, end);
    }
    const double first = floor(choice->blend_rows ? ray.row : ray.row + 0.5);
    const double part = choice->blend_rows ? ray.row - first : 0.0;
    double moments[AIR_MOMENT_MOST + 1] = {0.0};
    for (int i = 0; i < 2; i++) {
        const double share = i == 0 ? 1.0 - part : part;
        if (share > 0.0) {
            const size_t row = wrap_row(map, first + (double)i);
            add_sums_beyond(map, row, ray.x0, share, moments);
            add_sums_beyond(map, row, ray.x1, -share, moments);
        }
    }
    if (!(moments[0] > 0.0)) {
        return 0.0; /* so deep that the weights are below the smallest double */
    }
    return air_moment_bound(moments, p->moment_count, p->bias, signed_depth(ray.rise, ray.run),
                            choice->overestimation);
}

double air_moment_shadow_weighted(const air_moment_map *map, const double dir[3], double begin,
                                  double end, double (*weight)(void *user, double t), void *user,
                                  const air_moment_choice *choice)
{
    const air_moment_params *p = &map->params;
    const map_ray ray = to_map(map, dir, begin, end);
    if (!(ray.x1 - ray.x0 > 1.0)) {
        return direct_shadow(map, &ray, begin, end);
    }
    const float *heights = map->heights + wrap_row(map, floor(ray.row + 0.5)) * p->column_count;
    double moments[AIR_MOMENT_MOST + 1] = {0.0};
    for (size_t column = (size_t)ray.x0; column < p->column_count; column++) {
        const double low = fmax((double)column, ray.x0), high = fmin((double)column + 1.0, ray.x1);
        if (!(low < high)) {
            break;
        }
        const double t = column_rho(p, 0.5 * (low + high)) / ray.run;
        const double rho = column_rho(p, (double)column + 0.5);
        add_power_sums((high - low) * weight(user, t), signed_depth((double)heights[column], rho),
                       p->moment_count, moments);
    }
    if (!(moments[0] > 0.0)) {
        return 0.0;
    }
    return air_moment_bound(moments, p->moment_count, p->bias, signed_depth(ray.rise, ray.run),
                            choice->overestimation);
}
