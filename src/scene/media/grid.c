#include "scene/media/grid.h"

#include <inttypes.h>
#include <string.h>

#include "scene/media/grid_bricks.h"

/* Index coordinates stay exact in float up to here. */
#define MAX_GRID_SIDE ((size_t)1 << 22)

/* Values of a grid if it were stored densely: bounds the table of cells and the work that a hostile
 * file can ask for. */
#define MAX_DENSE_BYTES ((uint64_t)1 << 36)

/* The seven interpolations of a lookup round by less than 2^-24 each: their result exceeds the
 * largest sample by less than this factor. */
#define MAXIMUM_SLACK (1.0f + 1e-6f)

/* What air_grid_make holds while it fills a grid. */
typedef struct grid_builder {
    air_context *context;
    const air_grid_source *source;
    air_grid *grid;
    float *samples; /* one brick */
    size_t capacity;
    size_t uniform_brick; /* 1 + the last brick stored whose samples are all equal */
    uint64_t negative_count;
} grid_builder;

air_status air_grid_check_size(air_context *context, const char *what, const size_t size[3],
                               size_t channels)
{
    for (int k = 0; k < 3; k++) {
        if (size[k] < 1 || size[k] > MAX_GRID_SIDE) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "%s: the grid's size is %zu x %zu x %zu, each must be 1 to %zu", what,
                            size[0], size[1], size[2], MAX_GRID_SIDE);
        }
    }
    if (channels != 1 && channels != 3) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: the grid has %zu channels, must have 1 or 3", what, channels);
    }
    const double bytes =
        (double)size[0] * (double)size[1] * (double)size[2] * (double)channels * sizeof(float);
    if (bytes > (double)MAX_DENSE_BYTES) {
        return air_fail(
            context, AIR_ERROR_UNSUPPORTED,
            "%s: a grid of %zu x %zu x %zu with %zu channels spans %.0f bytes, at most %" PRIu64
            " are supported",
            what, size[0], size[1], size[2], channels, bytes, MAX_DENSE_BYTES);
    }
    return AIR_OK;
}

/* Makes room for one more brick; growing by half keeps the number of copies logarithmic. */
static air_status reserve_brick(grid_builder *builder)
{
    air_grid *grid = builder->grid;
    if (grid->brick_count < builder->capacity) {
        return AIR_OK;
    }
    const size_t capacity = builder->capacity + builder->capacity / 2 + 16;
    float *bricks = air_reallocate(builder->context, grid->bricks, capacity,
                                   AIR_BRICK_SAMPLES * grid->channels * sizeof(float));
    if (bricks == NULL) {
        return air_fail_memory(builder->context, builder->source->what);
    }
    grid->bricks = bricks;
    builder->capacity = capacity;
    return AIR_OK;
}

static air_status fail_not_finite(const grid_builder *builder, const int32_t base[3], size_t index,
                                  float value)
{
    const size_t sample = index / builder->grid->channels;
    int64_t voxel[3];
    const size_t local[3] = {sample % AIR_BRICK_SIDE, sample / AIR_BRICK_SIDE % AIR_BRICK_SIDE,
                             sample / (AIR_BRICK_SIDE * AIR_BRICK_SIDE)};
    for (int k = 0; k < 3; k++) {
        voxel[k] = builder->source->origin[k] + base[k] + (int64_t)local[k];
    }
    return air_fail(builder->context, AIR_ERROR_FORMAT,
                    "%s: voxel (%" PRId64 ", %" PRId64 ", %" PRId64
                    ") channel %zu is %g, must be finite",
                    builder->source->what, voxel[0], voxel[1], voxel[2],
                    index % builder->grid->channels, (double)value);
}

/* Is sample `local` of axis k one of the brick's own and inside the grid? */
static bool own_sample(const air_grid *grid, const int32_t base[3], int k, size_t local)
{
    return local < AIR_BRICK && (size_t)base[k] + local < grid->size[k];
}

/* Clamps the brick's samples to be >= 0, counts the negative ones where they belong to it, and
 * finds their maximum. */
static air_status clean_brick(grid_builder *builder, const int32_t base[3], float *out_max)
{
    const air_grid *grid = builder->grid;
    float max = 0.0f;
    size_t index = 0;
    for (size_t z = 0; z < AIR_BRICK_SIDE; z++) {
        for (size_t y = 0; y < AIR_BRICK_SIDE; y++) {
            const bool own_row = own_sample(grid, base, 2, z) && own_sample(grid, base, 1, y);
            for (size_t x = 0; x < AIR_BRICK_SIDE; x++) {
                const bool own = own_row && own_sample(grid, base, 0, x);
                for (size_t c = 0; c < grid->channels; c++, index++) {
                    const float value = builder->samples[index];
                    if (!isfinite(value)) {
                        return fail_not_finite(builder, base, index, value);
                    }
                    builder->negative_count += own && value < 0.0f;
                    builder->samples[index] = value > 0.0f ? value : 0.0f;
                    max = value > max ? value : max;
                }
            }
        }
    }
    *out_max = max;
    return AIR_OK;
}

/* The same for a brick of which only the first sample is there, as all are alike. */
static air_status clean_uniform(grid_builder *builder, const int32_t base[3], float *out_max)
{
    const air_grid *grid = builder->grid;
    float max = 0.0f;
    uint64_t own_count = 1;
    for (int k = 0; k < 3; k++) {
        const size_t left = grid->size[k] - (size_t)base[k];
        own_count *= left < AIR_BRICK ? left : AIR_BRICK;
    }
    for (size_t c = 0; c < grid->channels; c++) {
        const float value = builder->samples[c];
        if (!isfinite(value)) {
            return fail_not_finite(builder, base, c, value);
        }
        builder->negative_count += value < 0.0f ? own_count : 0;
        builder->samples[c] = value > 0.0f ? value : 0.0f;
        max = value > max ? value : max;
    }
    *out_max = max;
    return AIR_OK;
}

/* Are all values equal to those of the last uniform brick? Then it serves again: large tiles of one
 * value take no memory. */
static bool repeats_uniform(const grid_builder *builder, bool uniform)
{
    const size_t bytes = builder->grid->channels * sizeof(float);
    return uniform && builder->uniform_brick != 0 &&
           memcmp(builder->samples,
                  builder->grid->bricks +
                      (builder->uniform_brick - 1) * AIR_BRICK_SAMPLES * builder->grid->channels,
                  bytes) == 0;
}

static bool is_uniform(const grid_builder *builder)
{
    const size_t channels = builder->grid->channels;
    return memcmp(builder->samples, builder->samples + channels,
                  (AIR_BRICK_SAMPLES - 1) * channels * sizeof(float)) == 0;
}

/* Stores the samples (uniform: the first one) as a brick; *out_slot is 1 + its index. */
static air_status store_brick(grid_builder *builder, bool uniform, uint32_t *out_slot)
{
    air_grid *grid = builder->grid;
    if (repeats_uniform(builder, uniform)) {
        *out_slot = (uint32_t)builder->uniform_brick;
        return AIR_OK;
    }
    const air_status status = reserve_brick(builder);
    if (status != AIR_OK) {
        return status;
    }
    const size_t values = AIR_BRICK_SAMPLES * grid->channels;
    for (size_t i = grid->channels; uniform && i < values; i++) {
        builder->samples[i] = builder->samples[i - grid->channels];
    }
    memcpy(grid->bricks + grid->brick_count * values, builder->samples, values * sizeof(float));
    grid->brick_count++;
    builder->uniform_brick = uniform ? grid->brick_count : builder->uniform_brick;
    *out_slot = (uint32_t)grid->brick_count;
    return AIR_OK;
}

static air_status add_brick(grid_builder *builder, int32_t x, int32_t y, int32_t z)
{
    air_grid *grid = builder->grid;
    const int32_t base[3] = {x * AIR_BRICK, y * AIR_BRICK, z * AIR_BRICK};
    const air_brick_kind kind =
        builder->source->read_brick(builder->source->user, base, builder->samples);
    if (kind == AIR_BRICK_EMPTY) {
        return AIR_OK;
    }
    float max = 0.0f;
    air_status status = kind == AIR_BRICK_UNIFORM ? clean_uniform(builder, base, &max)
                                                  : clean_brick(builder, base, &max);
    if (status != AIR_OK || max == 0.0f) {
        return status;
    }
    const size_t cell = air_grid_cell(grid, (uint32_t)x, (uint32_t)y, (uint32_t)z);
    const bool uniform = kind == AIR_BRICK_UNIFORM || is_uniform(builder);
    status = store_brick(builder, uniform, &grid->slots[cell]);
    if (status != AIR_OK) {
        return status;
    }
    grid->maxima[cell] = max * MAXIMUM_SLACK;
    grid->max = max > grid->max ? max : grid->max;
    return AIR_OK;
}

static air_status fill(grid_builder *builder)
{
    const air_grid *grid = builder->grid;
    for (int32_t z = 0; z < grid->cells[2]; z++) {
        for (int32_t y = 0; y < grid->cells[1]; y++) {
            for (int32_t x = 0; x < grid->cells[0]; x++) {
                const air_status status = add_brick(builder, x, y, z);
                if (status != AIR_OK) {
                    return status;
                }
            }
        }
    }
    if (builder->negative_count > 0) {
        air_warn(builder->context, "%s: %" PRIu64 " negative values were set to 0",
                 builder->source->what, builder->negative_count);
    }
    return AIR_OK;
}

/* Gives back what reserve_brick took in advance. */
static void trim(grid_builder *builder)
{
    air_grid *grid = builder->grid;
    if (grid->brick_count < builder->capacity && grid->brick_count > 0) {
        float *bricks = air_reallocate(builder->context, grid->bricks, grid->brick_count,
                                       AIR_BRICK_SAMPLES * grid->channels * sizeof(float));
        grid->bricks = bricks != NULL ? bricks : grid->bricks;
    }
}

static air_grid *allocate_grid(air_context *context, const air_grid_source *source)
{
    air_grid *grid = air_allocate(context, 1, sizeof *grid);
    if (grid == NULL) {
        return NULL;
    }
    grid->context = context;
    grid->channels = source->channels;
    memcpy(grid->size, source->size, sizeof grid->size);
    memcpy(grid->index_to_local, source->index_to_local, sizeof grid->index_to_local);
    size_t cell_count = 1;
    for (int k = 0; k < 3; k++) {
        grid->last[k] = (float)(source->size[k] - 1);
        grid->cells[k] = (int32_t)((source->size[k] - 1) / AIR_BRICK + 1);
        cell_count *= (size_t)grid->cells[k];
    }
    grid->slots = air_allocate(context, cell_count, sizeof *grid->slots);
    grid->maxima = air_allocate(context, cell_count, sizeof *grid->maxima);
    if (grid->slots == NULL || grid->maxima == NULL) {
        air_grid_destroy(grid);
        return NULL;
    }
    return grid;
}

air_status air_grid_make(air_context *context, const air_grid_source *source, air_grid **out_grid)
{
    float inverse[12];
    grid_builder builder = {.context = context, .source = source};
    air_status status = air_grid_check_size(context, source->what, source->size, source->channels);
    if (status != AIR_OK) {
        return status;
    }
    if (!affine_invert(source->index_to_local, inverse)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: the grid's map from index to local space cannot be inverted",
                        source->what);
    }
    builder.grid = allocate_grid(context, source);
    builder.samples = air_allocate(context, AIR_BRICK_SAMPLES * source->channels, sizeof(float));
    if (builder.grid == NULL || builder.samples == NULL) {
        status = air_fail_memory(context, source->what);
        goto cleanup;
    }
    status = fill(&builder);
    if (status != AIR_OK) {
        goto cleanup;
    }
    trim(&builder);
    *out_grid = builder.grid;
    builder.grid = NULL;

cleanup:
    air_free(context, builder.samples);
    air_grid_destroy(builder.grid);
    return status;
}

typedef struct dense_values {
    const air_grid_source *source;
    const float *values;
} dense_values;

/* Beyond the last sample its value is repeated; lookups give it weight 0 there. */
static air_brick_kind read_dense(void *user, const int32_t base[3], float *out)
{
    const dense_values *dense = user;
    const size_t *size = dense->source->size;
    const size_t channels = dense->source->channels;
    for (size_t z = 0; z < AIR_BRICK_SIDE; z++) {
        const size_t k = (size_t)base[2] + z < size[2] ? (size_t)base[2] + z : size[2] - 1;
        for (size_t y = 0; y < AIR_BRICK_SIDE; y++) {
            const size_t j = (size_t)base[1] + y < size[1] ? (size_t)base[1] + y : size[1] - 1;
            const float *row = dense->values + (k * size[1] + j) * size[0] * channels;
            for (size_t x = 0; x < AIR_BRICK_SIDE; x++) {
                const size_t i = (size_t)base[0] + x < size[0] ? (size_t)base[0] + x : size[0] - 1;
                memcpy(out, row + i * channels, channels * sizeof(float));
                out += channels;
            }
        }
    }
    return AIR_BRICK_VARIED;
}

air_status air_grid_make_dense(air_context *context, const air_grid_source *source,
                               const float *values, air_grid **out_grid)
{
    air_grid_source dense_source = *source;
    dense_values dense = {&dense_source, values};
    dense_source.user = &dense;
    dense_source.read_brick = read_dense;
    return air_grid_make(context, &dense_source, out_grid);
}

air_status air_grid_create(air_context *context, const air_grid_desc *desc, air_grid **out_grid)
{
    air_grid_source source = {.what = desc->name != NULL ? desc->name : "grid",
                              .size = {desc->size[0], desc->size[1], desc->size[2]},
                              .channels = desc->channels};
    if (desc->values == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%s: the grid has no values", source.what);
    }
    memcpy(source.index_to_local, desc->index_to_local, sizeof source.index_to_local);
    return air_grid_make_dense(context, &source, desc->values, out_grid);
}

void air_grid_map_box(const size_t size[3], const float box_min[3], const float box_max[3],
                      float out[12])
{
    memset(out, 0, 12 * sizeof out[0]);
    for (int k = 0; k < 3; k++) {
        const double step = ((double)box_max[k] - (double)box_min[k]) / (double)size[k];
        out[5 * k] = (float)step;
        out[4 * k + 3] = (float)((double)box_min[k] + 0.5 * step);
    }
}

void air_grid_destroy(air_grid *grid)
{
    if (grid == NULL) {
        return;
    }
    air_free(grid->context, grid->bricks);
    air_free(grid->context, grid->maxima);
    air_free(grid->context, grid->slots);
    air_free(grid->context, grid);
}

const float *air_grid_index_to_local(const air_grid *grid) { return grid->index_to_local; }

void air_grid_size(const air_grid *grid, size_t out_size[3])
{
    memcpy(out_size, grid->size, sizeof grid->size);
}

size_t air_grid_channels(const air_grid *grid) { return grid->channels; }

size_t air_grid_bytes(const air_grid *grid)
{
    const size_t cell_count =
        (size_t)grid->cells[0] * (size_t)grid->cells[1] * (size_t)grid->cells[2];
    return sizeof *grid + cell_count * (sizeof *grid->slots + sizeof *grid->maxima) +
           grid->brick_count * AIR_BRICK_SAMPLES * grid->channels * sizeof(float);
}

float air_grid_max(const air_grid *grid) { return grid->max; }

static inline float mix(float a, float b, float t) { return a + t * (b - a); }

/* Trilinear value of one channel; `stride` is the number of channels. */
static inline float interpolate(const float *corner, size_t stride, const float f[3])
{
    const size_t row = AIR_BRICK_SIDE * stride, slice = AIR_BRICK_SIDE * row;
    const float y0 = mix(mix(corner[0], corner[stride], f[0]),
                         mix(corner[row], corner[row + stride], f[0]), f[1]);
    const float *far = corner + slice;
    const float y1 =
        mix(mix(far[0], far[stride], f[0]), mix(far[row], far[row + stride], f[0]), f[1]);
    return mix(y0, y1, f[2]);
}

/* Holds the value over the outermost half voxel. */
static inline float clamp_index(float x, float last)
{
    const float above = x > 0.0f ? x : 0.0f;
    return above < last ? above : last;
}

air_vec3 air_grid_lookup(const air_grid *grid, air_vec3 index)
{
    const float *last = grid->last;
    /* written so that NaN is outside */
    if (!(index.x >= -0.5f && index.x <= last[0] + 0.5f && index.y >= -0.5f &&
          index.y <= last[1] + 0.5f && index.z >= -0.5f && index.z <= last[2] + 0.5f)) {
        return vec3_set1(0.0f);
    }
    const float x = clamp_index(index.x, last[0]);
    const float y = clamp_index(index.y, last[1]);
    const float z = clamp_index(index.z, last[2]);
    const uint32_t i = (uint32_t)(int32_t)x, j = (uint32_t)(int32_t)y, k = (uint32_t)(int32_t)z;
    const uint32_t slot =
        grid->slots[air_grid_cell(grid, i / AIR_BRICK, j / AIR_BRICK, k / AIR_BRICK)];
    if (slot == 0) {
        return vec3_set1(0.0f);
    }
    const float f[3] = {x - (float)(int32_t)i, y - (float)(int32_t)j, z - (float)(int32_t)k};
    const size_t local =
        ((k % AIR_BRICK) * AIR_BRICK_SIDE + j % AIR_BRICK) * AIR_BRICK_SIDE + i % AIR_BRICK;
    if (grid->channels == 1) {
        return vec3_set1(
            interpolate(grid->bricks + (slot - 1) * (size_t)AIR_BRICK_SAMPLES + local, 1, f));
    }
    const float *corner = grid->bricks + ((slot - 1) * (size_t)AIR_BRICK_SAMPLES + local) * 3;
    return vec3(interpolate(corner, 3, f), interpolate(corner + 1, 3, f),
                interpolate(corner + 2, 3, f));
}
