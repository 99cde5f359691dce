/* grid_bricks.h: how a grid is laid out in memory, and how its loaders hand over their values; only
 * for src/scene/media. */
#ifndef AIR_SCENE_MEDIA_GRID_BRICKS_H
#define AIR_SCENE_MEDIA_GRID_BRICKS_H

#include "scene/media/grid.h"

/* A brick stores the samples 8b .. 8b+8 of each axis: its own 8 and one more, so that every
 * trilinear lookup whose lower corner is among its own reads this brick only. */
enum {
    AIR_BRICK_SIDE = AIR_BRICK + 1,
    AIR_BRICK_SAMPLES = AIR_BRICK_SIDE * AIR_BRICK_SIDE * AIR_BRICK_SIDE
};

struct air_grid {
    air_context *context;
    size_t size[3];
    size_t channels;
    float last[3];    /* size - 1 */
    int32_t cells[3]; /* bricks per axis */
    uint32_t *slots;  /* per cell: 1 + its brick, 0 for an empty one */
    float *maxima;    /* per cell: bound of its trilinear values */
    float *bricks; /* AIR_BRICK_SAMPLES * channels floats each; x fastest, channels interleaved */
    size_t brick_count;
    float max;
    float index_to_local[12];
};

static inline size_t air_grid_cell(const air_grid *grid, uint32_t x, uint32_t y, uint32_t z)
{
    return ((size_t)z * (uint32_t)grid->cells[1] + y) * (uint32_t)grid->cells[0] + x;
}

/* What a source says of a brick: all samples are zero; all are alike; they differ. */
typedef enum air_brick_kind {
    AIR_BRICK_EMPTY = 0,
    AIR_BRICK_UNIFORM = 1,
    AIR_BRICK_VARIED = 2
} air_brick_kind;

/* Where the values of a new grid come from. */
typedef struct air_grid_source {
    const char *what; /* for messages: the file or the name */
    size_t size[3];
    size_t channels;
    float index_to_local[12];
    int64_t origin[3]; /* added to sample indices where messages name a voxel */
    void *user;
    /* Writes the AIR_BRICK_SAMPLES * channels values from sample `base` on; what lies beyond the
     * grid may be anything finite. EMPTY: out is untouched. UNIFORM: only the first sample is
     * written, so that a small file's large tiles take little time; saying VARIED of equal samples
     * is legal. */
    air_brick_kind (*read_brick)(void *user, const int32_t base[3], float *out);
} air_grid_source;

/* Builds the grid. Errors: a size of 0 or too large, a map that cannot be inverted, a value that is
 * not finite. */
air_status air_grid_make(air_context *context, const air_grid_source *source, air_grid **out_grid);

/* The same from values stored densely, x fastest, channels interleaved; user and read_brick of the
 * source are not looked at. */
air_status air_grid_make_dense(air_context *context, const air_grid_source *source,
                               const float *values, air_grid **out_grid);

/* The map under which `size` voxels fill the box between two corners, samples at voxel centres. */
void air_grid_map_box(const size_t size[3], const float box_min[3], const float box_max[3],
                      float out[12]);

/* Fails with a message that states the bytes if that many values are more than a grid may have. */
air_status air_grid_check_size(air_context *context, const char *what, const size_t size[3],
                               size_t channels);

#endif
