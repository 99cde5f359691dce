/* unwrap_join.c: tiny charts become parts of a neighbour. */
#include <stdlib.h>
#include <string.h>

#include "atlas/surface.h"
#include "atlas/unwrap_charts.h"
#include "core/triple.h"

enum { MOST_NEIGHBOURS = 16 };

/* A chart beside another, and over how many sides. */
typedef struct beside {
    uint32_t chart, sides;
} beside;

typedef struct joiner {
    const air_unwrap_mesh *mesh;
    air_flat_charts *charts;
    air_plane_grid *grid;
    double least_cosine;
} joiner;

/* Most sides first, then by number. */
static int compare_beside(const void *a, const void *b)
{
    const beside *x = a, *y = b;
    if (x->sides != y->sides) {
        return x->sides > y->sides ? -1 : 1;
    }
    return (x->chart > y->chart) - (x->chart < y->chart);
}

static size_t list_beside(const joiner *j, uint32_t chart, beside list[MOST_NEIGHBOURS])
{
    const air_unwrap_mesh *mesh = j->mesh;
    size_t count = 0;
    for (uint32_t t = j->charts->charts[chart].first; t != UINT32_MAX; t = j->charts->next[t]) {
        for (uint32_t i = mesh->first_neighbour[t]; i < mesh->first_neighbour[t + 1]; i++) {
            const uint32_t other = j->charts->of_triangle[mesh->neighbours[i]];
            size_t k = 0;
            while (k < count && list[k].chart != other) {
                k++;
            }
            if (other == chart || other == AIR_NO_CHART || k == MOST_NEIGHBOURS) {
                continue;
            }
            if (k == count) {
                list[count++] = (beside){other, 0};
            }
            list[k].sides++;
        }
    }
    qsort(list, count, sizeof *list, compare_beside);
    return count;
}

static air_status fits_into(joiner *j, uint32_t from, uint32_t to, bool *out_fits)
{
    const air_flat_chart *chart = &j->charts->charts[to];
    *out_fits = true;
    for (uint32_t t = j->charts->charts[from].first; t != UINT32_MAX && *out_fits;
         t = j->charts->next[t]) {
        air_flat_triangle flat;
        if (!(j->mesh->areas[t] > 0.0)) {
            continue;
        }
        *out_fits = air_dot3(j->mesh->normals + 3 * (size_t)t, chart->normal) >= j->least_cosine &&
                    air_flat_chart_lay(j->mesh, chart, t, &flat);
        if (*out_fits) {
            const air_status status = air_plane_grid_put(j->grid, to, chart->cell,
                                                         j->mesh->tolerance, t, &flat, out_fits);
            if (status != AIR_OK) {
                return status;
            }
        }
    }
    return AIR_OK;
}

/* The triangles as they lie in their own chart again. */
static void lay_back(joiner *j, uint32_t chart)
{
    for (uint32_t t = j->charts->charts[chart].first; t != UINT32_MAX; t = j->charts->next[t]) {
        (void)air_flat_chart_lay(j->mesh, &j->charts->charts[chart], t, &j->grid->triangles[t]);
    }
}

static void move_all(joiner *j, uint32_t from, uint32_t to)
{
    air_flat_chart *chart = &j->charts->charts[from];
    for (uint32_t t = chart->first; t != UINT32_MAX;) {
        const uint32_t next = j->charts->next[t];
        air_flat_chart_append(j->charts, to, t);
        t = next;
    }
    j->charts->charts[to].area += chart->area;
    chart->first = chart->last = UINT32_MAX;
    chart->triangle_count = 0;
    chart->area = 0.0;
}

static air_status join(joiner *j, uint32_t chart)
{
    beside list[MOST_NEIGHBOURS];
    const size_t count = list_beside(j, chart, list);
    for (size_t i = 0; i < count; i++) {
        const size_t before = j->grid->entry_count;
        bool fits;
        const air_status status = fits_into(j, chart, list[i].chart, &fits);
        if (status != AIR_OK) {
            return status;
        }
        if (fits) {
            move_all(j, chart, list[i].chart);
            return AIR_OK;
        }
        air_plane_grid_cut(j->grid, before);
        lay_back(j, chart);
    }
    return AIR_OK;
}

typedef struct tiny {
    double area;
    uint32_t chart;
} tiny;

static int compare_tiny(const void *a, const void *b)
{
    const tiny *x = a, *y = b;
    if (x->area != y->area) {
        return x->area < y->area ? -1 : 1;
    }
    return (x->chart > y->chart) - (x->chart < y->chart);
}

air_status air_flat_charts_join_tiny(air_context *context, const air_unwrap_mesh *mesh,
                                     const air_unwrap_params *params, air_flat_charts *self,
                                     air_plane_grid *grid)
{
    joiner j = {mesh, self, grid, cos(params->merge_angle_rad)};
    const double density = params->texels_per_metre;
    const double least = params->merge_texels / (density * density);
    tiny *list = air_allocate(context, self->count, sizeof *list);
    air_status status = list != NULL ? AIR_OK : AIR_ERROR_MEMORY;
    size_t count = 0;
    for (size_t i = 0; i < self->count && status == AIR_OK; i++) {
        if (self->charts[i].area < least) {
            list[count++] = (tiny){self->charts[i].area, (uint32_t)i};
        }
    }
    if (count > 0) {
        qsort(list, count, sizeof *list, compare_tiny);
    }
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        if (self->charts[list[i].chart].area < least) {
            status = join(&j, list[i].chart);
        }
    }
    air_free(context, list);
    return status;
}
