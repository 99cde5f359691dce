#include "scene/media/grid_bricks.h"

/* The second where one is not a number, and a single instruction, unlike fminf and fmaxf. */
static inline float lesser(float a, float b) { return a < b ? a : b; }
static inline float greater(float a, float b) { return a > b ? a : b; }

/* Where the ray leaves cell c along axis k. Computed anew from the cell, so that rounding does not
 * add up over the walk. The last cell reaches on to the grid's edge. */
static float leave_time(const air_grid_walk *walk, int k)
{
    const int32_t step = walk->cell_step[k];
    const int32_t next = walk->cell[k] + (step > 0);
    if (step == 0 || next <= 0 || next >= walk->grid->cells[k]) {
        return INFINITY;
    }
    return ((float)(next * AIR_BRICK) - walk->origin[k]) * walk->inverse_dir[k];
}

/* Clips (t0, t1) to the grid's box [-1/2, size-1/2]; false if nothing is left. */
static bool clip_to_grid(air_grid_walk *walk, const float dir[3], float t0, float t1)
{
    walk->t_enter = t0;
    walk->t_leave = t1;
    for (int k = 0; k < 3; k++) {
        const float low = -0.5f, high = walk->grid->last[k] + 0.5f;
        if (dir[k] == 0.0f) {
            if (!(walk->origin[k] >= low && walk->origin[k] <= high)) {
                return false;
            }
            continue;
        }
        const float a = (low - walk->origin[k]) * walk->inverse_dir[k];
        const float b = (high - walk->origin[k]) * walk->inverse_dir[k];
        walk->t_enter = greater(lesser(a, b), walk->t_enter);
        walk->t_leave = lesser(greater(a, b), walk->t_leave);
    }
    return walk->t_enter < walk->t_leave;
}

void air_grid_walk_start(air_grid_walk *walk, const air_grid *grid, air_vec3 origin, air_vec3 dir,
                         float t0, float t1)
{
    const float d[3] = {dir.x, dir.y, dir.z};
    walk->grid = grid;
    walk->t = t0;
    walk->t_end = t1;
    vec3_store(walk->origin, origin);
    for (int k = 0; k < 3; k++) {
        walk->inverse_dir[k] = 1.0f / d[k];
        walk->cell_step[k] = d[k] > 0.0f ? 1 : d[k] < 0.0f ? -1 : 0;
    }
    if (!clip_to_grid(walk, d, t0, t1)) {
        walk->t_enter = walk->t_leave = t1;
        return;
    }
    for (int k = 0; k < 3; k++) {
        const float at = walk->origin[k] + walk->t_enter * d[k];
        const float clamped = lesser(greater(at, 0.0f), grid->last[k]);
        walk->cell[k] = (int32_t)clamped / AIR_BRICK;
        walk->t_next[k] = leave_time(walk, k);
    }
}

/* Goes over to the next cell; false if the walk leaves the grid. *out_t: where that happens. */
static bool next_cell(air_grid_walk *walk, float *out_t)
{
    int axis = walk->t_next[0] < walk->t_next[1] ? 0 : 1;
    axis = walk->t_next[2] < walk->t_next[axis] ? 2 : axis;
    *out_t = walk->t_next[axis];
    if (!(*out_t < walk->t_leave)) {
        *out_t = walk->t_leave;
        return false;
    }
    walk->cell[axis] += walk->cell_step[axis];
    walk->t_next[axis] = leave_time(walk, axis);
    return true;
}

static float cell_majorant(const air_grid_walk *walk)
{
    return walk->grid->maxima[air_grid_cell(walk->grid, (uint32_t)walk->cell[0],
                                            (uint32_t)walk->cell[1], (uint32_t)walk->cell[2])];
}

bool air_grid_walk_next(air_grid_walk *walk, float *out_t0, float *out_t1, float *out_majorant)
{
    if (!(walk->t < walk->t_end)) {
        return false;
    }
    *out_t0 = walk->t;
    *out_majorant = 0.0f;
    if (walk->t < walk->t_enter) {
        *out_t1 = walk->t = walk->t_enter;
        return true;
    }
    bool inside = walk->t < walk->t_leave;
    while (inside) {
        const float majorant = cell_majorant(walk);
        if (majorant > 0.0f && walk->t > *out_t0) {
            *out_t1 = walk->t; /* the empty cells before this one */
            return true;
        }
        float t;
        inside = next_cell(walk, &t);
        const float begin = walk->t;
        walk->t = t > begin ? t : begin;
        if (majorant > 0.0f && walk->t > begin) {
            *out_t1 = walk->t;
            *out_majorant = majorant;
            return true;
        }
    }
    *out_t1 = walk->t = walk->t_end;
    return true;
}
