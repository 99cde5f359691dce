/* unwrap_charts.c: a chart grows from the largest triangle that is left over the neighbour whose
 * normal is nearest to the mean so far. Then its plane is fixed, and its triangles are laid down
 * one after the other as far as they fit; what does not fit is left for later charts. */
#include "atlas/unwrap_charts.h"

#include <stdlib.h>
#include <string.h>

#include "atlas/surface.h"
#include "atlas/triangle.h"
#include "core/triple.h"
#include "core/vec.h"

typedef struct heap_entry {
    double cost;
    uint32_t order, triangle;
} heap_entry;

typedef struct grower {
    air_context *context;
    const air_unwrap_mesh *mesh;
    air_flat_charts *charts;
    air_plane_grid *grid;
    double least_cosine;
    heap_entry *heap;
    size_t heap_count;
    uint32_t *grown; /* triangles in the order they came */
    size_t grown_count;
    uint32_t *seen; /* per triangle: the last round that took or laid it */
    uint32_t round;
} grower;

/* ---- the heap: least cost first, then first come ---- */

static bool comes_before(const heap_entry *a, const heap_entry *b)
{
    return a->cost < b->cost || (a->cost == b->cost && a->order < b->order);
}

static void heap_push(grower *g, heap_entry entry)
{
    size_t at = g->heap_count++;
    while (at > 0 && comes_before(&entry, &g->heap[(at - 1) / 2])) {
        g->heap[at] = g->heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    g->heap[at] = entry;
}

static heap_entry heap_pop(grower *g)
{
    const heap_entry top = g->heap[0], last = g->heap[--g->heap_count];
    size_t at = 0;
    for (size_t child = 1; child < g->heap_count; child = 2 * at + 1) {
        if (child + 1 < g->heap_count && comes_before(&g->heap[child + 1], &g->heap[child])) {
            child++;
        }
        if (!comes_before(&g->heap[child], &last)) {
            break;
        }
        g->heap[at] = g->heap[child];
        at = child;
    }
    g->heap[at] = last;
    return top;
}

/* ---- growing ---- */

static void unit_of(const double v[3], double out[3])
{
    const double length = air_length3(v);
    for (int k = 0; k < 3; k++) {
        out[k] = length > 0.0 ? v[k] / length : 0.0;
    }
}

/* Triangles without area go anywhere, and first. */
static double cosine_to(const air_unwrap_mesh *mesh, uint32_t t, const double mean[3])
{
    return mesh->areas[t] > 0.0 ? air_dot3(mesh->normals + 3 * (size_t)t, mean) : 1.0;
}

/* Costs in steps of 1/1024, so that flat surfaces grow in rings and not along rounding. */
static void push_neighbours(grower *g, uint32_t t, const double mean[3], uint32_t *order)
{
    const air_unwrap_mesh *mesh = g->mesh;
    for (uint32_t i = mesh->first_neighbour[t]; i < mesh->first_neighbour[t + 1]; i++) {
        const uint32_t n = mesh->neighbours[i];
        if (g->charts->of_triangle[n] == AIR_NO_CHART && g->seen[n] != g->round) {
            const double cost = floor(1024.0 * (1.0 - cosine_to(mesh, n, mean)));
            heap_push(g, (heap_entry){cost, (*order)++, n});
        }
    }
}

/* Fills g->grown from the seed on; the sum of normals by area. */
static void grow(grower *g, uint32_t seed, double sum[3])
{
    const air_unwrap_mesh *mesh = g->mesh;
    uint32_t order = 0;
    g->round++;
    g->heap_count = g->grown_count = 0;
    memset(sum, 0, 3 * sizeof *sum);
    heap_push(g, (heap_entry){0.0, order++, seed});
    while (g->heap_count > 0) {
        const uint32_t t = heap_pop(g).triangle;
        double mean[3];
        unit_of(sum, mean);
        const bool first = g->grown_count == 0;
        if (g->seen[t] == g->round || (!first && cosine_to(mesh, t, mean) < g->least_cosine)) {
            continue;
        }
        g->seen[t] = g->round;
        g->grown[g->grown_count++] = t;
        air_along3(sum, mesh->areas[t], mesh->normals + 3 * (size_t)t, sum);
        unit_of(sum, mean);
        push_neighbours(g, t, mean, &order);
    }
}

/* ---- laying down ---- */

bool air_flat_chart_lay(const air_unwrap_mesh *mesh, const air_flat_chart *chart, uint32_t triangle,
                        air_flat_triangle *out_flat)
{
    for (size_t i = 0; i < 3; i++) {
        air_unwrap_mesh_project(mesh, triangle, i, chart->axis[0], chart->axis[1],
                                out_flat->point[i]);
    }
    air_flat_triangle_set_ways(out_flat);
    return air_doubled_area(out_flat->point[0], out_flat->point[1], out_flat->point[2]) > 0.0;
}

void air_flat_chart_append(air_flat_charts *self, uint32_t chart, uint32_t triangle)
{
    air_flat_chart *c = &self->charts[chart];
    if (c->triangle_count++ == 0) {
        c->first = triangle;
    } else {
        self->next[c->last] = triangle;
    }
    c->last = triangle;
    self->next[triangle] = UINT32_MAX;
    self->of_triangle[triangle] = chart;
}

/* About one cell for two triangles: then even a triangle as large as all others has few. */
static double cell_of(const grower *g, const air_flat_chart *chart)
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    const double count = (double)g->grown_count;
    for (size_t i = 0; i < 3 * g->grown_count; i++) {
        double p[2];
        air_unwrap_mesh_project(g->mesh, g->grown[i / 3], i % 3, chart->axis[0], chart->axis[1], p);
        for (int k = 0; k < 2; k++) {
            low[k] = double_min(low[k], p[k]);
            high[k] = double_max(high[k], p[k]);
        }
    }
    const double width = high[0] - low[0], height = high[1] - low[1];
    const double cell =
        double_max(sqrt(0.5 * width * height / count), double_max(width, height) / (2.0 * count));
    return cell > 0.0 ? cell : 1.0;
}

static air_status add_chart(grower *g, const double normal[3])
{
    air_flat_charts *charts = g->charts;
    if (charts->count == charts->capacity) {
        const size_t capacity = 2 * charts->capacity + 16;
        air_flat_chart *grown = air_reallocate(g->context, charts->charts, capacity, sizeof *grown);
        if (grown == NULL) {
            return AIR_ERROR_MEMORY;
        }
        charts->charts = grown;
        charts->capacity = capacity;
    }
    air_flat_chart chart = {.first = UINT32_MAX, .last = UINT32_MAX};
    air_copy3(normal, chart.normal);
    air_axes_across(normal, chart.axis[0], chart.axis[1]);
    chart.cell = cell_of(g, &chart);
    charts->charts[charts->count++] = chart;
    return AIR_OK;
}

/* Lays t into the newest chart if its normal and the room allow. */
static air_status lay(grower *g, uint32_t t, bool *out_fits)
{
    const uint32_t number = (uint32_t)g->charts->count - 1;
    air_flat_chart *chart = &g->charts->charts[number];
    air_status status = AIR_OK;
    air_flat_triangle flat;
    *out_fits = true;
    if (g->mesh->areas[t] > 0.0) {
        *out_fits = cosine_to(g->mesh, t, chart->normal) >= g->least_cosine &&
                    air_flat_chart_lay(g->mesh, chart, t, &flat);
        if (*out_fits) {
            status = air_plane_grid_put(g->grid, number, chart->cell, g->mesh->tolerance, t, &flat,
                                        out_fits);
        }
    }
    if (status == AIR_OK && *out_fits) {
        air_flat_chart_append(g->charts, number, t);
        chart->area += g->mesh->areas[t];
    }
    return status;
}

/* From the first grown triangle that suits the plane over those that fit, in rings; g->grown
 * becomes the queue. Triangles of this growth are those with seen == round. */
static air_status lay_all(grower *g)
{
    const uint32_t grown_round = g->round++;
    size_t count = 0;
    bool fits = false;
    for (size_t i = 0; i < g->grown_count && !fits; i++) {
        const uint32_t t = g->grown[i];
        if (g->mesh->areas[t] > 0.0) {
            const air_status status = lay(g, t, &fits);
            if (status != AIR_OK) {
                return status;
            }
            g->grown[0] = t;
            g->seen[t] = g->round;
        }
    }
    count = fits ? 1 : 0;
    for (size_t i = 0; i < count; i++) {
        const uint32_t from = g->grown[i];
        for (uint32_t k = g->mesh->first_neighbour[from]; k < g->mesh->first_neighbour[from + 1];
             k++) {
            const uint32_t t = g->mesh->neighbours[k];
            if (g->seen[t] != grown_round || g->charts->of_triangle[t] != AIR_NO_CHART) {
                continue;
            }
            const air_status status = lay(g, t, &fits);
            if (status != AIR_OK) {
                return status;
            }
            g->seen[t] = g->round;
            if (fits) {
                g->grown[count++] = t;
            }
        }
    }
    g->grown_count = count;
    return AIR_OK;
}

/* A triangle as a chart by itself, even where rounding would turn it over. */
static air_status make_single(grower *g, uint32_t t)
{
    air_status status;
    bool fits;
    g->grown[0] = t;
    g->grown_count = 1;
    status = add_chart(g, g->mesh->normals + 3 * (size_t)t);
    status = status == AIR_OK ? lay(g, t, &fits) : status;
    if (status == AIR_OK && !fits) {
        const uint32_t number = (uint32_t)g->charts->count - 1;
        air_flat_chart_append(g->charts, number, t);
        g->charts->charts[number].area += g->mesh->areas[t];
    }
    return status;
}

/* A chart from a seed with area. Where the mean suits none of those that made it, the seed is one
 * by itself. */
static air_status make_chart(grower *g, uint32_t seed)
{
    double sum[3], normal[3];
    grow(g, seed, sum);
    unit_of(sum, normal);
    if (air_length3(normal) == 0.0) {
        return make_single(g, seed);
    }
    air_status status = add_chart(g, normal);
    status = status == AIR_OK ? lay_all(g) : status;
    if (status == AIR_OK && g->grown_count == 0) {
        g->charts->count--;
        status = make_single(g, seed);
    }
    return status;
}

/* ---- all charts ---- */

typedef struct seed {
    double area;
    uint32_t triangle;
} seed;

static int compare_seeds(const void *a, const void *b)
{
    const seed *x = a, *y = b;
    if (x->area != y->area) {
        return x->area > y->area ? -1 : 1;
    }
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static air_status make_charts(grower *g, seed *seeds)
{
    const size_t count = g->mesh->triangle_count;
    for (size_t t = 0; t < count; t++) {
        seeds[t] = (seed){g->mesh->areas[t], (uint32_t)t};
    }
    qsort(seeds, count, sizeof *seeds, compare_seeds);
    for (size_t i = 0; i < count && seeds[i].area > 0.0; i++) {
        /* what did not fit comes again at once: it is a part of the same surface */
        while (g->charts->of_triangle[seeds[i].triangle] == AIR_NO_CHART) {
            const air_status status = make_chart(g, seeds[i].triangle);
            if (status != AIR_OK) {
                return status;
            }
        }
    }
    return AIR_OK;
}

static air_status grow_charts(air_context *context, const air_unwrap_mesh *mesh,
                              const air_unwrap_params *params, air_flat_charts *charts,
                              air_plane_grid *grid)
{
    const size_t count = mesh->triangle_count;
    grower g = {.context = context,
                .mesh = mesh,
                .charts = charts,
                .grid = grid,
                .least_cosine = cos(params->angle_rad)};
    seed *seeds = air_allocate(context, count, sizeof *seeds);
    g.heap = air_allocate(context, (size_t)mesh->first_neighbour[count] + 1, sizeof *g.heap);
    g.grown = air_allocate(context, count, sizeof *g.grown);
    g.seen = air_allocate(context, count, sizeof *g.seen);
    air_status status = AIR_ERROR_MEMORY;
    if (seeds != NULL && g.heap != NULL && g.grown != NULL && g.seen != NULL) {
        status = make_charts(&g, seeds);
    }
    air_free(context, g.seen);
    air_free(context, g.grown);
    air_free(context, g.heap);
    air_free(context, seeds);
    return status;
}

air_status air_flat_charts_init(air_context *context, const air_unwrap_mesh *mesh,
                                const air_unwrap_params *params, air_flat_charts *out_charts)
{
    const size_t count = mesh->triangle_count;
    air_plane_grid grid;
    *out_charts = (air_flat_charts){.charts = NULL};
    out_charts->of_triangle = air_allocate(context, count, sizeof *out_charts->of_triangle);
    out_charts->next = air_allocate(context, count, sizeof *out_charts->next);
    if (out_charts->of_triangle == NULL || out_charts->next == NULL ||
        air_plane_grid_init(context, count, &grid) != AIR_OK) {
        return AIR_ERROR_MEMORY;
    }
    for (size_t t = 0; t < count; t++) {
        out_charts->of_triangle[t] = AIR_NO_CHART;
    }
    air_status status = grow_charts(context, mesh, params, out_charts, &grid);
    if (status == AIR_OK) {
        status = air_flat_charts_join_tiny(context, mesh, params, out_charts, &grid);
    }
    air_plane_grid_finish(&grid);
    return status;
}

void air_flat_charts_finish(air_context *context, air_flat_charts *charts)
{
    air_free(context, charts->next);
    air_free(context, charts->of_triangle);
    air_free(context, charts->charts);
    *charts = (air_flat_charts){.charts = NULL};
}
