/* unwrap.c: charts are grown (unwrap_charts.c), joined (unwrap_join.c), turned (unwrap_frame.c),
 * and here laid out in texels with vertices of their own. */
#include "atlas/unwrap.h"

#include <math.h>

#include "atlas/surface.h"
#include "atlas/triangle.h"
#include "atlas/unwrap_charts.h"
#include "atlas/unwrap_frame.h"
#include "core/triple.h"
#include "core/vec.h"

void air_unwrap_params_default(air_unwrap_params *params)
{
    *params = (air_unwrap_params){.texels_per_metre = 10.0,
                                  .angle_rad = 40.0 * AIR_PI / 180.0,
                                  .merge_texels = 8.0,
                                  .merge_angle_rad = 65.0 * AIR_PI / 180.0,
                                  .snap = true};
}

/* ---- laying out ---- */

typedef struct layout {
    air_context *context;
    const air_unwrap_mesh *mesh;
    const air_unwrap_params *params;
    const air_flat_charts *charts;
    air_unwrap *out;
    double *points, *hull; /* of one chart */
    uint32_t *last_chart;  /* of each old vertex: the last chart that took it, plus 1 */
    uint32_t *new_vertex;  /* ... as which vertex */
} layout;

/* Map from the plane of a chart to texels. */
typedef struct placing {
    double right[2], low[2], scale[2];
} placing;

static void to_rectangle(const placing *at, const double p[2], double out[2])
{
    out[0] = p[0] * at->right[0] + p[1] * at->right[1];
    out[1] = p[0] * at->right[1] - p[1] * at->right[0];
}

static void project(const layout *l, const air_flat_chart *chart, size_t t, size_t corner,
                    double out[2])
{
    air_unwrap_mesh_project(l->mesh, t, corner, chart->axis[0], chart->axis[1], out);
}

/* Texels over a length along an axis. */
static void set_extent(const layout *l, double length, int axis, placing *at,
                       air_unwrap_chart *chart)
{
    const double density = l->params->texels_per_metre, free = length * density;
    const double snapped = double_max(floor(free + 0.5), 1.0);
    const double extent = l->params->snap && length > 0.0 ? snapped : free;
    at->scale[axis] = length > 0.0 ? extent / length : 0.0;
    chart->extent[axis] = extent;
    /* rounding may leave a hair more than whole texels */
    const double texels = double_max(ceil(extent - 1e-6), 1.0);
    chart->texels[axis] = (uint32_t)double_min(texels, 0x1p31);
}

/* What is up in the world, in the plane; on floors and ceilings, -z. */
static void up_in_plane(const air_flat_chart *chart, double up[2])
{
    const int axis = fabs(chart->normal[1]) < 0.95 ? 1 : 2;
    const double sign = axis == 1 ? 1.0 : -1.0;
    up[0] = sign * chart->axis[0][axis];
    up[1] = sign * chart->axis[1][axis];
}

static void place_chart(layout *l, const air_flat_chart *chart, placing *at, air_unwrap_chart *out)
{
    double up[2], low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    size_t count = 0;
    up_in_plane(chart, up);
    for (uint32_t t = chart->first; t != UINT32_MAX; t = l->charts->next[t]) {
        for (size_t k = 0; k < 3; k++) {
            project(l, chart, t, k, l->points + 2 * count++);
        }
    }
    air_unwrap_frame(l->points, count, l->hull, up, at->right);
    for (size_t i = 0; i < count; i++) {
        double p[2];
        to_rectangle(at, l->points + 2 * i, p);
        for (int k = 0; k < 2; k++) {
            low[k] = double_min(low[k], p[k]);
            high[k] = double_max(high[k], p[k]);
        }
    }
    for (int k = 0; k < 2; k++) {
        at->low[k] = low[k];
        set_extent(l, high[k] - low[k], k, at, out);
    }
    air_copy3(chart->normal, out->normal);
    out->triangle_count = chart->triangle_count;
}

static uint32_t add_vertex(layout *l, uint32_t old, double x, double y)
{
    air_unwrap *out = l->out;
    out->vertices[out->vertex_count] = old;
    out->places[2 * out->vertex_count] = (float)x;
    out->places[2 * out->vertex_count + 1] = (float)y;
    return (uint32_t)out->vertex_count++;
}

static void place_triangle(layout *l, const air_flat_chart *chart, const placing *at,
                           const air_unwrap_chart *rectangle, uint32_t number, uint32_t t)
{
    for (size_t k = 0; k < 3; k++) {
        const uint32_t old = l->mesh->indices[3 * (size_t)t + k];
        if (l->last_chart[old] != number + 1) {
            double p[2], q[2];
            project(l, chart, t, k, p);
            to_rectangle(at, p, q);
            for (int axis = 0; axis < 2; axis++) {
                const double texel = (q[axis] - at->low[axis]) * at->scale[axis];
                q[axis] = double_min(double_max(texel, 0.0), rectangle->extent[axis]);
            }
            l->last_chart[old] = number + 1;
            l->new_vertex[old] = add_vertex(l, old, q[0], q[1]);
        }
        l->out->indices[3 * (size_t)t + k] = l->new_vertex[old];
    }
    l->out->triangle_charts[t] = number;
}

/* Triangles that are in no chart are a point of the first. */
static void place_rest(layout *l)
{
    air_unwrap *out = l->out;
    for (size_t t = 0; t < l->mesh->triangle_count; t++) {
        if (l->charts->of_triangle[t] != AIR_NO_CHART) {
            continue;
        }
        for (size_t k = 0; k < 3; k++) {
            out->indices[3 * t + k] = add_vertex(l, l->mesh->indices[3 * t + k], 0.0, 0.0);
        }
        out->triangle_charts[t] = 0;
        if (out->chart_count == 0) {
            out->charts[out->chart_count++] =
                (air_unwrap_chart){{0.0, 0.0}, {1, 1}, {0.0, 1.0, 0.0}, 0};
        }
        out->charts[0].triangle_count++;
    }
}

static void lay_out(layout *l)
{
    air_unwrap *out = l->out;
    for (size_t i = 0; i < l->charts->count; i++) {
        const air_flat_chart *chart = &l->charts->charts[i];
        placing at;
        if (chart->triangle_count == 0) {
            continue;
        }
        const uint32_t number = (uint32_t)out->chart_count++;
        place_chart(l, chart, &at, &out->charts[number]);
        for (uint32_t t = chart->first; t != UINT32_MAX; t = l->charts->next[t]) {
            place_triangle(l, chart, &at, &out->charts[number], number, t);
        }
    }
    place_rest(l);
}

static air_status make_layout(air_context *context, const air_unwrap_mesh *mesh,
                              const air_unwrap_params *params, const air_flat_charts *charts,
                              air_unwrap *out)
{
    const size_t corners = 3 * mesh->triangle_count;
    layout l = {.context = context, .mesh = mesh, .params = params, .charts = charts, .out = out};
    air_status status = AIR_ERROR_MEMORY;
    l.points = air_allocate(context, corners + 1, 2 * sizeof *l.points);
    l.hull = air_allocate(context, corners + 1, 2 * sizeof *l.hull);
    l.last_chart = air_allocate(context, mesh->vertex_count, sizeof *l.last_chart);
    l.new_vertex = air_allocate(context, mesh->vertex_count, sizeof *l.new_vertex);
    out->vertices = air_allocate(context, corners, sizeof *out->vertices);
    out->places = air_allocate(context, corners, 2 * sizeof *out->places);
    out->indices = air_allocate(context, corners, sizeof *out->indices);
    out->triangle_charts =
        air_allocate(context, mesh->triangle_count, sizeof *out->triangle_charts);
    out->charts = air_allocate(context, charts->count + 1, sizeof *out->charts);
    out->triangle_count = mesh->triangle_count;
    if (l.points != NULL && l.hull != NULL && l.last_chart != NULL && l.new_vertex != NULL &&
        out->vertices != NULL && out->places != NULL && out->indices != NULL &&
        out->triangle_charts != NULL && out->charts != NULL) {
        lay_out(&l);
        status = AIR_OK;
    }
    air_free(context, l.new_vertex);
    air_free(context, l.last_chart);
    air_free(context, l.hull);
    air_free(context, l.points);
    return status;
}

/* ---- lifecycle ---- */

static air_status check(air_context *context, const float *positions, size_t vertex_count,
                        const uint32_t *indices, size_t triangle_count,
                        const air_unwrap_params *params)
{
    const double most = 80.0 * AIR_PI / 180.0 + 1e-9;
    if (!(params->texels_per_metre > 0.0) || !isfinite(params->texels_per_metre) ||
        !(params->angle_rad > 0.0 && params->angle_rad <= most) ||
        !(params->merge_angle_rad > 0.0 && params->merge_angle_rad <= most) ||
        !(params->merge_texels >= 0.0) || triangle_count > UINT32_MAX / 64) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "unwrap: %g texels per metre, angles %g and %g, %g texels, %zu triangles: "
                        "expected a positive density, angles in (0, 80 degrees], no negative area "
                        "and at most 2^26 triangles",
                        params->texels_per_metre, params->angle_rad, params->merge_angle_rad,
                        params->merge_texels, triangle_count);
    }
    for (size_t i = 0; i < 3 * triangle_count; i++) {
        const uint32_t v = indices[i];
        if (v >= vertex_count) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "unwrap: triangle %zu: expected an index below %zu, not %u", i / 3,
                            vertex_count, v);
        }
        if (!vec3_is_finite(vec3_load(positions + 3 * (size_t)v))) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "unwrap: triangle %zu: vertex %u is not finite", i / 3, v);
        }
    }
    return AIR_OK;
}

air_status air_unwrap_create(air_context *context, const float *positions, size_t vertex_count,
                             const uint32_t *indices, size_t triangle_count,
                             const air_unwrap_params *params, air_unwrap **out_unwrap)
{
    air_unwrap_mesh mesh = {.positions = NULL};
    air_flat_charts charts = {.charts = NULL};
    *out_unwrap = NULL;
    air_status status = check(context, positions, vertex_count, indices, triangle_count, params);
    if (status != AIR_OK) {
        return status;
    }
    air_unwrap *self = air_allocate(context, 1, sizeof *self);
    status = self != NULL ? air_unwrap_mesh_init(context, positions, vertex_count, indices,
                                                 triangle_count, &mesh)
                          : AIR_ERROR_MEMORY;
    status = status == AIR_OK ? air_flat_charts_init(context, &mesh, params, &charts) : status;
    status = status == AIR_OK ? make_layout(context, &mesh, params, &charts, self) : status;
    air_flat_charts_finish(context, &charts);
    air_unwrap_mesh_finish(context, &mesh);
    if (status != AIR_OK) {
        air_unwrap_destroy(context, self);
        return air_fail_memory(context, "unwrap");
    }
    *out_unwrap = self;
    return AIR_OK;
}

void air_unwrap_destroy(air_context *context, air_unwrap *self)
{
    if (self == NULL) {
        return;
    }
    air_free(context, self->charts);
    air_free(context, self->triangle_charts);
    air_free(context, self->indices);
    air_free(context, self->places);
    air_free(context, self->vertices);
    air_free(context, self);
}

/* ---- quality ---- */

/* Singular values of the map from a triangle in space to one in texels, the larger first, and its
 * area in space; false where that is 0. */
static bool stretch_of(const air_unwrap *self, const float *positions, size_t t, double values[2],
                       double *out_area)
{
    double p[3][3], e[2][3], q[3][2], normal[3];
    uint32_t vertices[3];
    for (size_t i = 0; i < 3; i++) {
        const size_t v = self->indices[3 * t + i];
        vertices[i] = self->vertices[v];
        for (size_t k = 0; k < 3; k++) {
            p[i][k] = (double)positions[3 * (size_t)vertices[i] + k];
        }
        q[i][0] = (double)self->places[2 * v];
        q[i][1] = (double)self->places[2 * v + 1];
    }
    if (!air_triangle_normal(positions, vertices, normal)) {
        return false;
    }
    air_subtract3(p[1], p[0], e[0]);
    air_subtract3(p[2], p[0], e[1]);
    const double doubled = air_length3(normal), base = air_length3(e[0]);
    /* in the triangle's own frame: (base, 0) and (along, height) */
    const double along = air_dot3(e[0], e[1]) / base, height = doubled / base;
    double a = 0.0, c = 0.0, determinant;
    double column[2][2];
    for (int k = 0; k < 2; k++) {
        column[0][k] = (q[1][k] - q[0][k]) / base;
        column[1][k] = (q[2][k] - q[0][k] - column[0][k] * along) / height;
        a += column[0][k] * column[0][k];
        c += column[1][k] * column[1][k];
    }
    determinant = fabs(column[0][0] * column[1][1] - column[0][1] * column[1][0]);
    const double sum = sqrt(a + c + 2.0 * determinant);
    const double difference = sqrt(double_max(a + c - 2.0 * determinant, 0.0));
    values[0] = 0.5 * (sum + difference);
    values[1] = 0.5 * (sum - difference);
    *out_area = 0.5 * doubled;
    return true;
}

air_unwrap_quality air_unwrap_measure(const air_unwrap *self, const float *positions,
                                      double texels_per_metre)
{
    air_unwrap_quality quality = {INFINITY, 0.0, 0.0, 0.0};
    double area = 0.0, squares = 0.0, texels = 0.0, used = 0.0;
    for (size_t t = 0; t < self->triangle_count; t++) {
        double values[2], here;
        if (!stretch_of(self, positions, t, values, &here)) {
            continue;
        }
        used += here * values[0] * values[1];
        area += here;
        squares += here * 0.5 * (values[0] * values[0] + values[1] * values[1]);
        quality.most_stretch = double_max(quality.most_stretch, values[0] / texels_per_metre);
        quality.least_stretch = double_min(quality.least_stretch, values[1] / texels_per_metre);
    }
    for (size_t i = 0; i < self->chart_count; i++) {
        texels += (double)self->charts[i].texels[0] * (double)self->charts[i].texels[1];
    }
    quality.mean_stretch = area > 0.0 ? sqrt(squares / area) / texels_per_metre : 0.0;
    quality.utilisation = texels > 0.0 ? used / texels : 0.0;
    return quality;
}
