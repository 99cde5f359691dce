/* fuzz_grid.h: what the harnesses of the grid loaders share: a context that reads the input, and
 * what a grid must hold. */
#ifndef AIR_TESTS_FUZZ_GRID_H
#define AIR_TESTS_FUZZ_GRID_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene/media/grid.h"

/* One allocation may have this much: enough for the files of a corpus, and no reason to run out of
 * memory. */
enum { FUZZ_MAX_ALLOCATION = 1 << 26 };

typedef struct fuzz_input {
    const uint8_t *data;
    size_t size;
} fuzz_input;

static inline void *fuzz_reallocate(void *user, void *pointer, size_t size)
{
    (void)user;
    if (size == 0) {
        free(pointer);
        return NULL;
    }
    return size <= FUZZ_MAX_ALLOCATION ? realloc(pointer, size) : NULL;
}

/* Gives the input for every path. */
static inline air_status fuzz_read(void *user, air_context *context, const char *path,
                                   void **out_data, size_t *out_size)
{
    const fuzz_input *input = user;
    (void)context;
    (void)path;
    void *copy = malloc(input->size + 1);
    if (copy == NULL) {
        return AIR_ERROR_MEMORY;
    }
    if (input->size > 0) {
        memcpy(copy, input->data, input->size);
    }
    *out_data = copy;
    *out_size = input->size;
    return AIR_OK;
}

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
    fuzz_input input = {data, size};
    air_context_params params;
    air_context *context = NULL;
    air_grid *grid = NULL;
    air_context_params_default(&params);
    params.thread_count = 1;
    params.reallocate = fuzz_reallocate;
    params.read_file = fuzz_read;
    params.read_user = &input;
    if (air_context_create(&params, &context) != AIR_OK) {
        return;
    }
    const air_status status = load(context, &grid);
    if ((status == AIR_OK) != (grid != NULL)) {
        abort();
    }
    if (grid != NULL) {
        fuzz_use_grid(grid);
    }
    air_grid_destroy(grid);
    air_context_destroy(context);
}

#endif
