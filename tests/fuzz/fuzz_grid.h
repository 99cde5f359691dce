/* fuzz_grid.h: what the harnesses of the grid loaders share: what is done with a grid. */
#ifndef AIR_TESTS_FUZZ_GRID_H
#define AIR_TESTS_FUZZ_GRID_H

#include "fuzz_host.h"
#include "scene/media/grid.h"

/* Values between 0 and the maximum, along a ray with its majorants. */
static inline void fuzz_use_grid(const air_grid *grid)
{
    size_t size[3];
    air_grid_size(grid, size);
    const air_vec3 origin = vec3(-1.0f, -1.0f, -1.0f);
    const air_vec3 dir = vec3((float)size[0] + 1.0f, (float)size[1] + 1.0f, (float)size[2] + 1.0f);
    air_grid_walk walk;
    float t0, t1, majorant, end = 0.0f;
    air_grid_walk_start(&walk, grid, origin, dir, 0.0f, 1.0f);
    while (air_grid_walk_next(&walk, &t0, &t1, &majorant)) {
        const air_vec3 value = air_grid_lookup(grid, vec3_madd(origin, 0.5f * (t0 + t1), dir));
        if (t0 != end || !(t1 > t0) || !(vec3_min(value) >= 0.0f) ||
            !(vec3_max(value) <= air_grid_max(grid) * 1.000001f)) {
            abort();
        }
        end = t1;
    }
    if (end != 1.0f) {
        abort();
    }
}

/* Loads the input with `load` and uses what came of it. */
static inline void fuzz_load(const uint8_t *data, size_t size,
                             air_status (*load)(air_context *context, air_grid **out_grid))
{
    fuzz_files files = {.files = {{"", data, size}}, .count = 1};
    air_context *context = fuzz_context(&files, NULL);
    air_grid *grid = NULL;
    if (context == NULL) {
        return;
    }
    const air_status status = load(context, &grid);
    fuzz_check_outcome(context, status, grid);
    if (grid != NULL) {
        fuzz_use_grid(grid);
    }
    air_grid_destroy(grid);
    air_context_destroy(context);
}

#endif
