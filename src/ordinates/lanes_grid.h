/* lanes_grid.h: the state of a run in floats side by side: where things lie.
 *
 * A slice is one row after the other, each followed by one column that stays dark and parts it from
 * the next: a vector may run over the ends of rows, and neighbours to either side lie one float
 * away. Its cells come in blocks of two cache lines, in which the arrays of the slice take turns:
 * one pointer reaches all of them. What a slice sends lies in a ring of slices with dark rows
 * before and after, as long as another slice needs it: ahead for three slices, sideways for two.
 * Every slice begins at a cache line (without: 1.4 times the time).
 *
 * Powers are in units of what the brightest cell of the entry lets in. */
#ifndef AIR_ORDINATES_LANES_GRID_H
#define AIR_ORDINATES_LANES_GRID_H

#include <stdbool.h>
#include <stdint.h>

#include "ordinates/run.h"

enum { LINE_FLOATS = 16, BLOCK_FLOATS = 2 * LINE_FLOATS };

/* Where the arrays lie in a block. */
enum {
    CELL_ENERGY = 0,
    CELL_MEAN = BLOCK_FLOATS,
    CELL_ABSORB = 2 * BLOCK_FLOATS, /* as plain_grid has them */
    CELL_TURN = 3 * BLOCK_FLOATS,
    CELL_G = 4 * BLOCK_FLOATS,
    CELL_VIEW = 5 * BLOCK_FLOATS, /* 2 d.v */
    CELL_SEEN = 6 * BLOCK_FLOATS, /* times 4 pi */
    CELL_FLUENCE = 7 * BLOCK_FLOATS,
    CELL_ARRAYS = 8
};

/* What a slice sends: powers, and mean cosines times them (LITERAL: the mean cosine alone, in
 * RING_FRONT_MOMENT). */
enum {
    RING_FRONT = 0,
    RING_FRONT_MOMENT = 3,
    RING_SIDE = 6,
    RING_SIDE_MOMENT = 8,
    RING_BACK = 10,
    RING_BACK_MOMENT = 11,
    RING_SLICES = 12
};

typedef struct lanes_grid {
    const ordinates_run *run;
    size_t size[3];
    size_t row;    /* floats from row to row: a dark column more than cells */
    size_t body;   /* of a slice, in whole blocks */
    size_t margin; /* before and after a slice of the ring: a row at least */
    float scale;   /* the largest entry factor */
    float *cells, *ring, *dark, *beam;
    float *sigma_s, *sigma_a, *g, *view, *spare; /* of one slice */
    float *lost;                                 /* of one slice; NULL: no books are wanted */
    bool fluence, seen;                          /* wanted */
    uint32_t squarings; /* exponentials are powers of 2^this of lesser ones */
    double absorbed, out[ORDINATES_FACES];
} lanes_grid;

/* Cell `at` of slice k: add one of CELL_x. Block after block lies BLOCK_STRIDE apart. */
enum { BLOCK_STRIDE = BLOCK_FLOATS * CELL_ARRAYS };
static inline float *grid_cell(const lanes_grid *self, size_t k, size_t at)
{
    return self->cells + k * self->body * CELL_ARRAYS + at / BLOCK_FLOATS * BLOCK_STRIDE +
           at % BLOCK_FLOATS;
}

static inline float *grid_ring(const lanes_grid *self, size_t index)
{
    return self->ring + index * (self->body + 2 * self->margin) + self->margin;
}

/* Borrows the run's scratch; ring and single slices are dark, cells are not set. */
void ordinates_lanes_lay_out(const ordinates_run *run, lanes_grid *out);
/* Books of what slice k sent out of the grid, and of a slice's losses. Nothing without books. */
void ordinates_lanes_book_faces(lanes_grid *self, size_t k);
void ordinates_lanes_book_lost(lanes_grid *self);
/* Lets nothing pass the dark columns of slice k and what is behind its last row: their CELL_ABSORB
 * becomes `value`. */
void ordinates_lanes_seal(const lanes_grid *self, size_t k, float value);
/* Rows of a slice of cells, scaled, without the columns between. */
void ordinates_lanes_give_slice(const lanes_grid *self, const float *slice, float scale,
                                float *out);
void ordinates_lanes_give(const lanes_grid *self, uint32_t steps, double residual);

#endif
