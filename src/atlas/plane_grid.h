/* plane_grid.h: flat triangles of many planes by the cells of each plane's grid, to find those that
 * a new one overlaps. */
#ifndef AIR_ATLAS_PLANE_GRID_H
#define AIR_ATLAS_PLANE_GRID_H

#include "atlas/separation.h"
#include "core/host.h"

typedef struct air_plane_entry {
    uint32_t plane, triangle;
    int64_t cell[2];
    uint32_t next; /* in its slot; UINT32_MAX: none */
} air_plane_entry;

typedef struct air_plane_grid {
    air_context *context;
    air_flat_triangle *triangles; /* by number, as last put in */
    uint32_t *slots;
    size_t slot_count; /* a power of two */
    air_plane_entry *entries;
    size_t entry_count, capacity;
} air_plane_grid;

/* For triangles numbered below triangle_count. Fails for want of memory, without a message. */
air_status air_plane_grid_init(air_context *context, size_t triangle_count,
                               air_plane_grid *out_grid);
void air_plane_grid_finish(air_plane_grid *grid);

/* Puts a triangle into a plane whose cells are `cell` wide. *out_fits false, and nothing is
 * changed, where it overlaps one that is there by more than tolerance. */
air_status air_plane_grid_put(air_plane_grid *grid, uint32_t plane, double cell, double tolerance,
                              uint32_t triangle, const air_flat_triangle *flat, bool *out_fits);

/* Takes the entries from number `count` on out again, the last first. */
void air_plane_grid_cut(air_plane_grid *grid, size_t count);

#endif
