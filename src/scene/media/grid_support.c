/* grid_support.c: where a grid has values. */
#include "scene/media/grid_bricks.h"

/* The least and greatest sample that is above a value, so far. */
typedef struct support {
    const air_grid *grid;
    float above;
    int32_t low[3], high[3]; /* low > high: none */
} support;

static void include_sample(support *self, const int32_t at[3])
{
    for (int k = 0; k < 3; k++) {
        self->low[k] = at[k] < self->low[k] ? at[k] : self->low[k];
        self->high[k] = at[k] > self->high[k] ? at[k] : self->high[k];
    }
}

/* Nothing of a brick between bounds moves them. */
static bool is_within(const support *self, const int32_t base[3])
{
    bool within = true;
    for (int k = 0; k < 3; k++) {
        within = within && base[k] >= self->low[k] && base[k] + AIR_BRICK - 1 <= self->high[k];
    }
    return within;
}

static bool is_above(const support *self, const float *sample)
{
    float most = 0.0f;
    for (size_t c = 0; c < self->grid->channels; c++) {
        most = sample[c] > most ? sample[c] : most;
    }
    return most > self->above;
}

/* A brick's own samples: the others are its neighbours' or beyond the grid. */
static void include_brick(support *self, const int32_t base[3], const float *samples)
{
    const air_grid *const grid = self->grid;
    int32_t side[3];
    for (int k = 0; k < 3; k++) {
        const int32_t left = (int32_t)grid->size[k] - base[k];
        side[k] = left < AIR_BRICK ? left : AIR_BRICK;
    }
    for (int32_t z = 0; z < side[2]; z++) {
        for (int32_t y = 0; y < side[1]; y++) {
            for (int32_t x = 0; x < side[0]; x++) {
                const int32_t at[3] = {base[0] + x, base[1] + y, base[2] + z};
                const size_t n = (size_t)((z * AIR_BRICK_SIDE + y) * AIR_BRICK_SIDE + x);
                if (is_above(self, samples + n * grid->channels)) {
                    include_sample(self, at);
                }
            }
        }
    }
}

bool air_grid_support(const air_grid *grid, float above, float out_low[3], float out_high[3])
{
    support self = {.grid = grid, .above = above};
    for (int k = 0; k < 3; k++) {
        self.low[k] = INT32_MAX;
        self.high[k] = -1;
    }
    for (int32_t z = 0; z < grid->cells[2]; z++) {
        for (int32_t y = 0; y < grid->cells[1]; y++) {
            for (int32_t x = 0; x < grid->cells[0]; x++) {
                const int32_t base[3] = {x * AIR_BRICK, y * AIR_BRICK, z * AIR_BRICK};
                const size_t cell = air_grid_cell(grid, (uint32_t)x, (uint32_t)y, (uint32_t)z);
                const uint32_t slot = grid->slots[cell];
                if (slot != 0 && grid->maxima[cell] > above && !is_within(&self, base)) {
                    include_brick(&self, base,
                                  grid->bricks +
                                      (slot - 1) * (size_t)AIR_BRICK_SAMPLES * grid->channels);
                }
            }
        }
    }
    if (self.high[0] < 0) {
        return false;
    }
    for (int k = 0; k < 3; k++) {
        /* A sample counts up to its neighbours, and at the grid's end as far as it is held. */
        const float edge = grid->last[k] + 0.5f;
        out_low[k] = self.low[k] > 0 ? (float)(self.low[k] - 1) : -0.5f;
        out_high[k] = (float)self.high[k] < grid->last[k] ? (float)(self.high[k] + 1) : edge;
    }
    return true;
}
