#include "bake/cache_sight.h"

#include <math.h>
#include <string.h>

#include "core/host.h"

enum { PARTS = 4, CORNERS = 8 }; /* of a cell along each axis; points around a place */

/* Walls like to stand where points do; a little beside the centre of their cells, points are on one
 * side of them. Shares of a cell. */
static const float beside[3] = {0.031f, 0.023f, -0.027f};

static air_vec3 point_at(const air_cache_grid *g, uint32_t x, uint32_t y, uint32_t z)
{
    return air_cache_place_at(g, (float)x + beside[0], (float)y + beside[1], (float)z + beside[2]);
}

/* ---- where a place is ---- */

typedef struct axis_place {
    uint32_t lower, upper, part;
    float share;
} axis_place;

/* In cells from the first point. */
static axis_place locate_cell(float x, uint32_t size)
{
    const float inside = float_min(float_max(x, -0.5f), (float)size - 0.5f);
    const float base = floorf(inside);
    const uint32_t part = (uint32_t)((inside + 0.5f) * (float)PARTS),
                   upper = (uint32_t)(base + 1.0f);
    return (axis_place){base < 0.0f ? 0 : (uint32_t)base, upper < size ? upper : size - 1,
                        part < PARTS * size ? part : PARTS * size - 1, inside - base};
}

static axis_place locate_axis(float at, float low, float step, uint32_t size)
{
    return locate_cell(step > 0.0f ? (at - low) / step : 0.0f, size);
}

static size_t part_index(const air_cache_grid *g, const uint32_t part[3])
{
    return ((size_t)part[2] * PARTS * g->size[1] + part[1]) * PARTS * g->size[0] + part[0];
}

air_cache_place air_cache_locate(const air_cache_grid *g, air_vec3 p)
{
    const axis_place at[3] = {locate_axis(p.x, g->low.x, g->step.x, g->size[0]),
                              locate_axis(p.y, g->low.y, g->step.y, g->size[1]),
                              locate_axis(p.z, g->low.z, g->step.z, g->size[2])};
    const uint32_t part[3] = {at[0].part, at[1].part, at[2].part};
    return (air_cache_place){{at[0].lower, at[1].lower, at[2].lower},
                             {at[0].upper, at[1].upper, at[2].upper},
                             {at[0].share, at[1].share, at[2].share},
                             g->sight == NULL ? 0xff : g->sight[part_index(g, part)]};
}

bool air_cache_sees_own(const air_cache_grid *g, air_vec3 p)
{
    const air_cache_place place = air_cache_locate(g, p);
    const unsigned corner = (place.share[0] >= 0.5f ? 1u : 0u) |
                            (place.share[1] >= 0.5f ? 2u : 0u) | (place.share[2] >= 0.5f ? 4u : 0u);
    return (place.sees >> corner & 1u) != 0;
}

/* ---- looking around ---- */

typedef struct sight_run {
    const air_snapshot *snapshot;
    air_cache_grid *grid;
    uint8_t *blocked; /* of each cell: is anything in it? */
} sight_run;

static air_ray ray_between(air_vec3 from, air_vec3 to)
{
    const air_vec3 way = vec3_sub(to, from);
    return (air_ray){
        {from.x, from.y, from.z}, 0.0f, {way.x, way.y, way.z}, 1.0f, AIR_MASK_SHADOW_OPAQUE};
}

/* Rays from the middle of the cell to corners, edges and faces, and a little beyond: walls between
 * cells are in both. */
static void look_into_cell(void *user, size_t cell, size_t worker)
{
    enum { RAYS = 26 };
    const float reach = 0.55f;
    const sight_run *run = user;
    const air_cache_grid *g = run->grid;
    uint32_t at[3];
    air_ray rays[RAYS];
    uint8_t occluded[RAYS];
    (void)worker;
    air_cache_cell(g, cell, at);
    const float x = (float)at[0], y = (float)at[1], z = (float)at[2];
    for (int i = 0; i < RAYS; i++) {
        const int k = i < RAYS / 2 ? i : i + 1; /* 13 is the middle itself */
        rays[i] = ray_between(point_at(g, at[0], at[1], at[2]),
                              air_cache_place_at(g, x + reach * (float)(k % 3 - 1),
                                                 y + reach * (float)(k / 3 % 3 - 1),
                                                 z + reach * (float)(k / 9 - 1)));
    }
    air_context_ray_backend(run->snapshot->context)
        ->occluded(run->snapshot->accelerator, rays, RAYS, occluded);
    run->blocked[cell] = memchr(occluded, 1, RAYS) != NULL;
}

static void corners_of(const air_cache_grid *g, const axis_place at[3], size_t cells[CORNERS],
                       air_vec3 points[CORNERS])
{
    for (uint32_t corner = 0; corner < CORNERS; corner++) {
        const uint32_t x = corner & 1u ? at[0].upper : at[0].lower;
        const uint32_t y = corner & 2u ? at[1].upper : at[1].lower;
        const uint32_t z = corner & 4u ? at[2].upper : at[2].lower;
        cells[corner] = air_cache_index(g, x, y, z);
        points[corner] = point_at(g, x, y, z);
    }
}

static uint8_t look_around(const sight_run *run, const uint32_t part[3])
{
    const air_cache_grid *g = run->grid;
    axis_place at[3];
    float x[3];
    size_t cells[CORNERS];
    air_vec3 points[CORNERS];
    air_ray rays[CORNERS];
    uint8_t occluded[CORNERS], sees = 0, blocked = 0;
    for (int k = 0; k < 3; k++) {
        x[k] = ((float)part[k] + 0.5f) / (float)PARTS - 0.5f;
        at[k] = locate_cell(x[k], g->size[k]);
    }
    corners_of(g, at, cells, points);
    for (int corner = 0; corner < CORNERS; corner++) {
        blocked |= run->blocked[cells[corner]];
        rays[corner] = ray_between(air_cache_place_at(g, x[0], x[1], x[2]), points[corner]);
    }
    if (!blocked) {
        return 0xff;
    }
    air_context_ray_backend(run->snapshot->context)
        ->occluded(run->snapshot->accelerator, rays, CORNERS, occluded);
    for (int corner = 0; corner < CORNERS; corner++) {
        sees |= (uint8_t)(occluded[corner] ? 0u : 1u << corner);
    }
    return sees;
}

/* A layer of parts. */
static void look_from_layer(void *user, size_t layer, size_t worker)
{
    const sight_run *run = user;
    const air_cache_grid *g = run->grid;
    (void)worker;
    for (uint32_t y = 0; y < PARTS * g->size[1]; y++) {
        for (uint32_t x = 0; x < PARTS * g->size[0]; x++) {
            const uint32_t part[3] = {x, y, (uint32_t)layer};
            g->sight[part_index(g, part)] = look_around(run, part);
        }
    }
}

air_status air_cache_sight_make(air_context *context, const air_snapshot *snapshot,
                                air_cache_grid *grid)
{
    const size_t cells = air_cache_point_count(grid);
    if (snapshot->accelerator == NULL) {
        return AIR_OK;
    }
    sight_run run = {snapshot, grid, air_allocate(context, cells, 1)};
    grid->sight = air_allocate(context, cells, (size_t)PARTS * PARTS * PARTS);
    if (run.blocked != NULL && grid->sight != NULL) {
        air_parallel_for(context, cells, look_into_cell, &run);
        air_parallel_for(context, PARTS * (size_t)grid->size[2], look_from_layer, &run);
    }
    const bool complete = run.blocked != NULL && grid->sight != NULL;
    air_free(context, run.blocked);
    return complete ? AIR_OK : air_fail_memory(context, "light in media");
}
