/* cache_grid.h: where the points of cached light lie, and what they hold.
 *
 * A grid is a box of points at the centres of its cells. A point stands for as much of its cell as
 * it sees (cache_sight.h). */
#ifndef AIR_BAKE_CACHE_GRID_H
#define AIR_BAKE_CACHE_GRID_H

#include "airlight/lightmap.h"
#include "scene/snapshot.h"

enum {
    AIR_CACHE_COEFFICIENTS = AIR_PROBE_COEFFICIENTS,
    AIR_CACHE_BANDS = 3,
    AIR_CACHE_FLOATS = 28 /* RGB of all coefficients, and one that is 0, to sum four at a time */
};

/* What a point holds: straight from lights, and all else. */
typedef struct air_cache_point {
    float lights[AIR_CACHE_FLOATS], rest[AIR_CACHE_FLOATS];
    float weight; /* 0: inside of something */
} air_cache_point;

typedef struct air_cache_grid {
    air_vec3 low, step; /* of the first point; to the next ones */
    uint32_t size[3];
    air_cache_point *points;
    uint8_t *sight; /* of places between the points; NULL: all see all (cache_sight.h) */
} air_cache_grid;

/* The grids of one medium, finest first; the last holds all that matters. */
typedef struct air_cache_grids {
    air_cache_grid *grids;
    size_t count;
} air_cache_grids;

/* Lays out the grids of one medium: the scene, with `resolution` cells along its longest side;
 * boxes about lamps; and for media that reach far beyond the scene what lies within four mean free
 * paths of it. No points yet. Out of memory only. */
air_status air_cache_grids_place(air_context *context, const air_snapshot *snapshot,
                                 const air_medium *medium, uint32_t resolution,
                                 air_cache_grids *out_grids);
/* Points of the scene's grids of all media together. */
double air_cache_scene_points(const air_snapshot *snapshot, uint32_t resolution);
/* The finest resolution, 8 to 64 and even, with which the scene's grids of all media have at most
 * so many points together. */
uint32_t air_cache_resolution(const air_snapshot *snapshot, double points);
void air_cache_grids_finish(air_context *context, air_cache_grids *grids);

/* The cell of a point, by its number: x fastest. */
static inline void air_cache_cell(const air_cache_grid *g, size_t index, uint32_t out[3])
{
    out[0] = (uint32_t)(index % g->size[0]);
    out[1] = (uint32_t)(index / g->size[0] % g->size[1]);
    out[2] = (uint32_t)(index / ((size_t)g->size[0] * g->size[1]));
}

/* A place in cells from the first point. */
static inline air_vec3 air_cache_place_at(const air_cache_grid *g, float x, float y, float z)
{
    return vec3(g->low.x + x * g->step.x, g->low.y + y * g->step.y, g->low.z + z * g->step.z);
}

static inline size_t air_cache_point_count(const air_cache_grid *g)
{
    return (size_t)g->size[0] * g->size[1] * g->size[2];
}

#endif
