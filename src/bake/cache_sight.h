/* cache_sight.h: which points of cached light a place between them sees.
 *
 * Light on the other side of a wall is nobody's business. Every cell is cut into 4 x 4 x 4 parts,
 * and of each it is kept which of the eight points around its centre opaque surfaces leave visible.
 * A point then stands for the part of its cell that sees it, and a place is told what the points
 * say that it sees. What is thinner than a quarter of a cell and lies between neither stays
 * unknown. */
#ifndef AIR_BAKE_CACHE_SIGHT_H
#define AIR_BAKE_CACHE_SIGHT_H

#include "bake/cache_grid.h"

/* A place among the points of a grid. Outside it is at the border. */
typedef struct air_cache_place {
    uint32_t lower[3], upper[3]; /* the points around it; the same ones beyond the outermost */
    float share[3];              /* of the upper ones */
    uint8_t sees;                /* bit dx + 2 dy + 4 dz: the point at upper where d is 1 */
} air_cache_place;

air_cache_place air_cache_locate(const air_cache_grid *grid, air_vec3 position);

/* Finds out who sees whom, in parallel. Out of memory only. */
air_status air_cache_sight_make(air_context *context, const air_snapshot *snapshot,
                                air_cache_grid *grid);

/* Does a place see the point of the cell that it lies in? */
bool air_cache_sees_own(const air_cache_grid *grid, air_vec3 position);

static inline size_t air_cache_index(const air_cache_grid *g, uint32_t x, uint32_t y, uint32_t z)
{
    return ((size_t)z * g->size[1] + y) * g->size[0] + x;
}

#endif
