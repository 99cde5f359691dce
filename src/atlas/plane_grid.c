/* plane_grid.c: a hash table of cells with chains; the newest entry is a chain's first. */
#include "atlas/plane_grid.h"

#include "atlas/coverage_clip.h"
#include "core/random.h"
#include "core/vec.h"

air_status air_plane_grid_init(air_context *context, size_t triangle_count, air_plane_grid *out)
{
    air_plane_grid grid = {.context = context, .slot_count = 16};
    while (grid.slot_count < 4 * triangle_count) {
        grid.slot_count *= 2;
    }
    grid.triangles = air_allocate(context, triangle_count, sizeof *grid.triangles);
    grid.slots = air_allocate(context, grid.slot_count, sizeof *grid.slots);
    if (grid.triangles == NULL || grid.slots == NULL) {
        air_plane_grid_finish(&grid);
        return AIR_ERROR_MEMORY;
    }
    for (size_t i = 0; i < grid.slot_count; i++) {
        grid.slots[i] = UINT32_MAX;
    }
    *out = grid;
    return AIR_OK;
}

void air_plane_grid_finish(air_plane_grid *grid)
{
    air_free(grid->context, grid->entries);
    air_free(grid->context, grid->slots);
    air_free(grid->context, grid->triangles);
    *grid = (air_plane_grid){.context = grid->context};
}

static size_t slot_of(const air_plane_grid *grid, uint32_t plane, const int64_t cell[2])
{
    uint32_t hash = air_hash_combine(plane, (uint32_t)cell[0]);
    hash = air_hash_combine(hash, (uint32_t)cell[1]);
    return hash & (grid->slot_count - 1);
}

static air_status add(air_plane_grid *grid, uint32_t plane, const int64_t cell[2],
                      uint32_t triangle)
{
    const size_t slot = slot_of(grid, plane, cell);
    if (grid->entry_count == grid->capacity) {
        const size_t capacity = 2 * grid->capacity + 64;
        air_plane_entry *grown =
            capacity < UINT32_MAX
                ? air_reallocate(grid->context, grid->entries, capacity, sizeof *grown)
                : NULL;
        if (grown == NULL) {
            return AIR_ERROR_MEMORY;
        }
        grid->entries = grown;
        grid->capacity = capacity;
    }
    grid->entries[grid->entry_count] =
        (air_plane_entry){plane, triangle, {cell[0], cell[1]}, grid->slots[slot]};
    grid->slots[slot] = (uint32_t)grid->entry_count++;
    return AIR_OK;
}

void air_plane_grid_cut(air_plane_grid *grid, size_t count)
{
    while (grid->entry_count > count) {
        const air_plane_entry *e = &grid->entries[--grid->entry_count];
        grid->slots[slot_of(grid, e->plane, e->cell)] = e->next;
    }
}

static bool is_free(const air_plane_grid *grid, uint32_t plane, const int64_t cell[2],
                    uint32_t triangle, const air_flat_triangle *flat, double tolerance)
{
    for (uint32_t i = grid->slots[slot_of(grid, plane, cell)]; i != UINT32_MAX;) {
        const air_plane_entry *e = &grid->entries[i];
        if (e->plane == plane && e->cell[0] == cell[0] && e->cell[1] == cell[1] &&
            e->triangle != triangle &&
            air_flat_triangles_overlap(&grid->triangles[e->triangle], flat, tolerance)) {
            return false;
        }
        i = e->next;
    }
    return true;
}

/* Cells from the lowest to the highest along an axis; the border of a cell is both's. */
static void span_of(const air_piece *piece, int axis, int64_t out[2])
{
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < piece->count; i++) {
        low = double_min(low, piece->point[i][axis]);
        high = double_max(high, piece->point[i][axis]);
    }
    out[0] = (int64_t)floor(low);
    out[1] = (int64_t)floor(high);
}

air_status air_plane_grid_put(air_plane_grid *grid, uint32_t plane, double cell, double tolerance,
                              uint32_t triangle, const air_flat_triangle *flat, bool *out_fits)
{
    const size_t before = grid->entry_count;
    air_piece whole = {.count = 3}, half, row;
    int64_t rows[2], columns[2];
    for (int i = 0; i < 3; i++) {
        whole.point[i][0] = flat->point[i][0] / cell;
        whole.point[i][1] = flat->point[i][1] / cell;
    }
    span_of(&whole, 1, rows);
    *out_fits = true;
    for (int64_t y = rows[0]; y <= rows[1]; y++) {
        air_piece_cut(&whole, 1, (double)y, false, &half);
        air_piece_cut(&half, 1, (double)y + 1.0, true, &row);
        if (row.count == 0) {
            continue;
        }
        span_of(&row, 0, columns);
        for (int64_t x = columns[0]; x <= columns[1]; x++) {
            const int64_t at[2] = {x, y};
            if (!is_free(grid, plane, at, triangle, flat, tolerance)) {
                air_plane_grid_cut(grid, before);
                *out_fits = false;
                return AIR_OK;
            }
            if (add(grid, plane, at, triangle) != AIR_OK) {
                return AIR_ERROR_MEMORY;
            }
        }
    }
    grid->triangles[triangle] = *flat;
    return AIR_OK;
}
