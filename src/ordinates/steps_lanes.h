/* steps_lanes.h: the steps of LITERAL and CM, for the instruction set of the including file, which
 * defines ORDINATES_STEPS as the function's name.
 *
 * In place, one slice after the other: slice k+1 writes into the ring what it sends, then slice k,
 * of which nothing more is needed, becomes what it receives. A slice's light is counted before it
 * is sent; the light of the last step once more at the end.
 *
 * What a loop needs is held in locals: vectors are stored through types that may alias anything,
 * and what is behind a pointer would be read again after each. */
#include "ordinates/steps_start.h"

/* ---- what a slice sends ---- */

/* This pass's fluence f, of mean cosine a. */
static inline void count(float *cell, bool fluence, bool seen, pair f, pair a)
{
    if (seen) {
        const pair g = pair_load(cell + CELL_G), view = pair_load(cell + CELL_VIEW);
        const pair phase = pair_phase(pair_mul(a, g), view);
        pair_store(cell + CELL_SEEN, pair_madd(f, phase, pair_load(cell + CELL_SEEN)));
    }
    if (fluence) {
        pair_store(cell + CELL_FLUENCE, pair_add(f, pair_load(cell + CELL_FLUENCE)));
    }
}

static void count_only(const lanes_grid *self, bool cm, size_t k, float weight)
{
    const bool fluence = self->fluence, seen = self->seen;
    const size_t end = self->body;
    for (size_t i = 0; i < end; i += PAIR) {
        float *const cell = grid_cell(self, k, i);
        const pair a = pair_load(cell + CELL_MEAN);
        pair path = pair_all(weight);
        if (cm) {
            path = pair_mul(path, pair_path(a));
        }
        count(cell, fluence, seen, pair_mul(path, pair_load(cell + CELL_ENERGY)), a);
    }
}

/* F, B and a side's share of what has left; F + B is twice the even half, sides have the rest. */
static inline void store_shares(pair left, pair even, pair odd, float *front, float *back,
                                float *side)
{
    const pair rest = pair_nmadd(pair_all(0.5f), even, pair_all(0.25f));
    pair_store(front, pair_mul(left, pair_add(even, odd)));
    pair_store(back, pair_mul(left, pair_sub(even, odd)));
    pair_store(side, pair_mul(left, rest));
}

/* [Elek2014, eqs. 2, 3] */
static void send_literal(const lanes_grid *self, size_t k, float weight)
{
    float *const front = grid_ring(self, RING_FRONT + k % 3);
    float *const mean = grid_ring(self, RING_FRONT_MOMENT + k % 3);
    float *const side = grid_ring(self, RING_SIDE + k % 2);
    float *const back = grid_ring(self, RING_BACK);
    float *const cells = grid_cell(self, k, 0), *const lost = self->lost;
    const bool fluence = self->fluence, seen = self->seen;
    const pair passes = pair_all(weight);
    const size_t end = self->body;
    for (size_t i = 0; i < end; i += PAIR) {
        float *const cell = cells + i / BLOCK_FLOATS * BLOCK_STRIDE + i % BLOCK_FLOATS;
        const pair e = pair_load(cell + CELL_ENERGY), a = pair_load(cell + CELL_MEAN);
        pair odd;
        const pair even = pair_halves(ordinates_front, a, &odd);
        const pair left = pair_mul(e, pair_load(cell + CELL_ABSORB));
        store_shares(left, even, odd, front + i, back + i, side + i);
        pair_store(mean + i, pair_mul(a, pair_load(cell + CELL_TURN)));
        count(cell, fluence, seen, pair_mul(e, passes), a);
        if (lost != NULL) {
            pair_store(lost + i, pair_sub(e, left));
        }
    }
}

/* exp(-x) of a depth, which is scaled down by 2^squarings, times a path; 0 of SEALED_DEPTH. */
static inline pair exp_of(uint32_t squarings, pair depth, pair path)
{
    pair y = pair_max(pair_short_exp(pair_mul(depth, path)), pair_all(0.0f));
    for (uint32_t i = 0; i < squarings; i++) {
        y = pair_mul(y, y);
    }
    return y;
}

static void send_cm(const lanes_grid *self, size_t k, float weight)
{
    float *const front = grid_ring(self, RING_FRONT + k % 3);
    float *const front_moment = grid_ring(self, RING_FRONT_MOMENT + k % 3);
    float *const side = grid_ring(self, RING_SIDE + k % 2);
    float *const side_moment = grid_ring(self, RING_SIDE_MOMENT + k % 2);
    float *const back = grid_ring(self, RING_BACK);
    float *const back_moment = grid_ring(self, RING_BACK_MOMENT);
    float *const cells = grid_cell(self, k, 0), *const lost = self->lost;
    const bool fluence = self->fluence, seen = self->seen;
    const pair passes = pair_all(weight);
    const uint32_t squarings = self->squarings;
    const size_t end = self->body;
    for (size_t i = 0; i < end; i += PAIR) {
        float *const cell = cells + i / BLOCK_FLOATS * BLOCK_STRIDE + i % BLOCK_FLOATS;
        const pair e = pair_load(cell + CELL_ENERGY), a = pair_load(cell + CELL_MEAN);
        const pair path = pair_path(a);
        const pair left = pair_mul(e, exp_of(squarings, pair_load(cell + CELL_ABSORB), path));
        const pair moment = pair_mul(left, exp_of(squarings, pair_load(cell + CELL_TURN), path));
        pair odd, mean_odd;
        const pair even = pair_halves(ordinates_front, a, &odd);
        store_shares(left, even, odd, front + i, back + i, side + i);
        const pair mean_even = pair_halves(ordinates_front_mean, a, &mean_odd);
        const pair rest = pair_nmadd(pair_all(0.5f), mean_odd, pair_mul(pair_all(0.25f), a));
        pair_store(front_moment + i, pair_mul(moment, pair_add(mean_odd, mean_even)));
        pair_store(back_moment + i, pair_mul(moment, pair_sub(mean_odd, mean_even)));
        pair_store(side_moment + i, pair_mul(moment, rest));
        count(cell, fluence, seen, pair_mul(pair_mul(e, path), passes), a);
        if (lost != NULL) {
            pair_store(lost + i, pair_sub(e, left));
        }
    }
}

/* ---- what a slice receives: gives the power that is then under way in it ---- */

/* Fast shares may be less than none by a rounding. */
static inline pair not_negative(pair sum) { return pair_max(sum, pair_all(0.0f)); }

/* moment/sum, 0 in the dark; rounding may carry it past 1. */
static inline pair mean_of(pair moment, pair sum)
{
    const pair inverse = pair_inverse(pair_max(sum, pair_all(1e-36f)));
    const pair ratio = pair_min(pair_all(1.0f), pair_mul(moment, inverse));
    return pair_max(pair_all(-1.0f), ratio);
}

/* [Elek2014, eqs. 4-6] */
static double receive_literal(const lanes_grid *self, size_t k)
{
    const bool last = k + 1 == self->size[2];
    const float *const ahead = k == 0 ? self->dark : grid_ring(self, RING_FRONT + (k - 1) % 3);
    const float *const ahead_mean = grid_ring(self, RING_FRONT_MOMENT + (k + 2) % 3);
    const float *const side = grid_ring(self, RING_SIDE + k % 2);
    const float *const side_mean = grid_ring(self, RING_FRONT_MOMENT + k % 3);
    const float *const behind = last ? self->dark : grid_ring(self, RING_BACK);
    const float *const behind_mean = grid_ring(self, RING_FRONT_MOMENT + (k + 1) % 3);
    const float *const up = side - self->row, *const up_mean = side_mean - self->row;
    const float *const down = side + self->row, *const down_mean = side_mean + self->row;
    float *const cells = grid_cell(self, k, 0), *const lost = self->lost;
    const size_t end = self->body;
    pair under_way = pair_all(0.0f);
    for (size_t i = 0; i < end; i += PAIR) {
        float *const cell = cells + i / BLOCK_FLOATS * BLOCK_STRIDE + i % BLOCK_FLOATS;
        const pair w1 = pair_load(side + i - 1), w2 = pair_load(side + i + 1);
        const pair w3 = pair_load(up + i), w4 = pair_load(down + i);
        const pair w5 = pair_load(ahead + i), w6 = pair_load(behind + i);
        const pair w = pair_add(pair_add(w1, w2), pair_add(w3, w4));
        const pair sum = not_negative(pair_add(w, pair_add(w5, w6)));
        pair moment = pair_mul(w1, pair_load(side_mean + i - 1));
        pair other = pair_mul(w2, pair_load(side_mean + i + 1));
        moment = pair_madd(w3, pair_load(up_mean + i), moment);
        other = pair_madd(w4, pair_load(down_mean + i), other);
        moment = pair_madd(w5, pair_load(ahead_mean + i), moment);
        other = pair_madd(w6, pair_load(behind_mean + i), other);
        const pair a = mean_of(pair_add(moment, other), sum);
        const pair e = pair_mul(sum, pair_load(cell + CELL_ABSORB));
        pair_store(cell + CELL_ENERGY, e);
        pair_store(cell + CELL_MEAN, pair_mul(a, pair_load(cell + CELL_TURN)));
        under_way = pair_add(under_way, e);
        if (lost != NULL) {
            pair_store(lost + i, pair_sub(sum, e));
        }
    }
    return pair_sum(under_way);
}

static inline pair six_sides(const float *side, size_t row, const float *ahead, const float *behind)
{
    const pair w12 = pair_add(pair_load(side - 1), pair_load(side + 1));
    const pair w34 = pair_add(pair_load(side - row), pair_load(side + row));
    return pair_add(pair_add(w12, w34), pair_add(pair_load(ahead), pair_load(behind)));
}

static double receive_cm(const lanes_grid *self, size_t k)
{
    const bool last = k + 1 == self->size[2];
    const float *const ahead = k == 0 ? self->dark : grid_ring(self, RING_FRONT + (k - 1) % 3);
    const float *const ahead_moment =
        k == 0 ? self->dark : grid_ring(self, RING_FRONT_MOMENT + (k - 1) % 3);
    const float *const side = grid_ring(self, RING_SIDE + k % 2);
    const float *const side_moment = grid_ring(self, RING_SIDE_MOMENT + k % 2);
    const float *const behind = last ? self->dark : grid_ring(self, RING_BACK);
    const float *const behind_moment = last ? self->dark : grid_ring(self, RING_BACK_MOMENT);
    float *const cells = grid_cell(self, k, 0), *const lost = self->lost;
    const uint32_t squarings = self->squarings;
    const size_t row = self->row, end = self->body;
    pair under_way = pair_all(0.0f);
    for (size_t i = 0; i < end; i += PAIR) {
        float *const cell = cells + i / BLOCK_FLOATS * BLOCK_STRIDE + i % BLOCK_FLOATS;
        const pair sum = not_negative(six_sides(side + i, row, ahead + i, behind + i));
        const pair moment = six_sides(side_moment + i, row, ahead_moment + i, behind_moment + i);
        const pair a = mean_of(moment, sum), path = pair_path(a);
        const pair e = pair_mul(sum, exp_of(squarings, pair_load(cell + CELL_ABSORB), path));
        const pair turn = exp_of(squarings, pair_load(cell + CELL_TURN), path);
        pair_store(cell + CELL_ENERGY, e);
        pair_store(cell + CELL_MEAN, pair_mul(a, turn));
        under_way = pair_add(under_way, e);
        if (lost != NULL) {
            pair_store(lost + i, pair_sub(sum, e));
        }
    }
    return pair_sum(under_way);
}

/* ---- steps ---- */

static void send(lanes_grid *self, bool cm, size_t k, float weight)
{
    if (cm) {
        send_cm(self, k, weight);
    } else {
        send_literal(self, k, weight);
    }
    ordinates_lanes_book_lost(self);
    ordinates_lanes_book_faces(self, k);
}

/* Gives what is then under way. */
static double step(lanes_grid *self, bool cm, float weight)
{
    const size_t slices = self->size[2];
    double under_way = 0.0;
    send(self, cm, 0, weight);
    for (size_t k = 0; k < slices; k++) {
        if (k + 1 < slices) {
            send(self, cm, k + 1, weight);
        }
        under_way += cm ? receive_cm(self, k) : receive_literal(self, k);
        ordinates_lanes_book_lost(self);
    }
    return under_way;
}

static void run_steps(const ordinates_run *run)
{
    const air_ordinates_params *const params = run->params;
    const bool cm = params->stencil == AIR_ORDINATES_CM;
    lanes_grid grid;
    ordinates_lanes_lay_out(run, &grid);
    double residual;
    const double in = start(&grid, &residual);
    uint32_t steps = 0;
    float weight = params->start == AIR_ORDINATES_FIRST_SCATTER ? 0.5f : 1.0f;
    while (steps < params->steps && residual > params->residual * in) {
        residual = step(&grid, cm, weight);
        weight = 1.0f;
        steps++;
    }
    for (size_t k = 0; k < grid.size[2]; k++) {
        count_only(&grid, cm, k, weight);
    }
    ordinates_lanes_give(&grid, steps, residual);
}

/* Light that has gone too dim for normal floats is none: such numbers cost a hundred cycles each,
 * and every cell far from the light has them. */
void ORDINATES_STEPS(const ordinates_run *run)
{
    enum { FLUSH_RESULTS = 0x8000, FLUSH_OPERANDS = 0x40 };
    const unsigned before = _mm_getcsr();
    _mm_setcsr(before | FLUSH_RESULTS | FLUSH_OPERANDS);
    run_steps(run);
    _mm_setcsr(before);
}
