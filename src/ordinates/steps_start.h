/* steps_start.h: what a grid begins with, for the instruction set of the including file. */
#ifndef AIR_ORDINATES_STEPS_START_H
#define AIR_ORDINATES_STEPS_START_H

#include "ordinates/lanes_grid.h"
#include "ordinates/steps_math.h"

/* Optical depths and coefficients beyond these change nothing that floats could show, and their
 * sums and inverses are numbers. */
enum { START_DEPTH = 64 };
#define START_COEFFICIENT 1e30f

/* Rows of cells to rows with dark columns between: vectors, and the last vector of a row over what
 * is there already. */
static void spread(const lanes_grid *self, const float *cells, float *out)
{
    const size_t n = self->size[0];
    for (size_t j = 0; j < self->size[1]; j++) {
        const float *const from = cells + j * n;
        float *const to = out + j * self->row;
        size_t i = 0;
        for (; i + LANES <= n; i += LANES) {
            lanes_store(to + i, lanes_load(from + i));
        }
        if (n >= LANES && i < n) {
            lanes_store(to + n - LANES, lanes_load(from + n - LANES));
            i = n;
        }
        for (; i < n; i++) {
            to[i] = from[i];
        }
    }
}

/* Rates of the paper's decay take a logarithm; media have few g. */
static void paper_rates(const lanes_grid *self)
{
    float known = self->g[0];
    float rate = (float)ordinates_decay_rate(AIR_ORDINATES_DECAY_PAPER, (double)known);
    for (size_t i = 0; i < self->body; i++) {
        if (self->g[i] != known) {
            known = self->g[i];
            rate = (float)ordinates_decay_rate(AIR_ORDINATES_DECAY_PAPER, (double)known);
        }
        self->spare[i] = rate;
    }
}

/* A slice's coefficients, and half a cell's depths, of which the greatest. */
static pair start_medium(const lanes_grid *self, size_t k, pair greatest)
{
    const air_ordinates_cells *const cells = self->run->cells;
    const bool literal = self->run->params->stencil == AIR_ORDINATES_LITERAL;
    const bool paper = self->run->params->decay == AIR_ORDINATES_DECAY_PAPER;
    const size_t at = k * self->size[0] * self->size[1], end = self->body;
    const pair half = pair_all(0.5f * cells->cell_m), most = pair_all(START_COEFFICIENT);
    const pair deepest = pair_all(START_DEPTH), zero = pair_all(0.0f);
    const float sharpest = (float)ORDINATES_SHARPEST;
    spread(self, cells->sigma_s + at, self->sigma_s);
    spread(self, cells->sigma_a + at, self->sigma_a);
    spread(self, cells->g + at, self->g);
    if (self->seen) {
        spread(self, self->run->results->view_cosine + at, self->view);
    }
    if (paper) {
        paper_rates(self);
    }
    for (size_t i = 0; i < end; i += PAIR) {
        float *const cell = grid_cell(self, k, i);
        const pair g = pair_load(self->g + i), view = pair_load(self->view + i);
        const pair dull = pair_max(pair_all(-sharpest), pair_min(pair_all(sharpest), g));
        const pair sigma_s = pair_min(pair_load(self->sigma_s + i), most);
        const pair sigma_a = pair_min(pair_load(self->sigma_a + i), most);
        pair rate = pair_sub(pair_all(1.0f), g), unused;
        if (paper) {
            rate = pair_load(self->spare + i);
        }
        pair absorb = pair_min(pair_mul(sigma_a, half), deepest);
        pair turn = pair_min(pair_mul(pair_mul(sigma_s, half), rate), deepest);
        greatest = pair_max(greatest, pair_max(absorb, turn));
        if (literal) {
            absorb = pair_transmittance(absorb, &unused);
            turn = pair_transmittance(turn, &unused);
        }
        pair_store(cell + CELL_ABSORB, absorb);
        pair_store(cell + CELL_TURN, turn);
        pair_store(cell + CELL_G, dull);
        pair_store(cell + CELL_VIEW, pair_add(view, view));
        pair_store(cell + CELL_FLUENCE, zero);
        pair_store(cell + CELL_SEEN, zero);
    }
    return greatest;
}

/* As start_first_scatter of plain.c. Clear cells get a depth of 1e-20, so that fluence is what is
 * lost over the depth everywhere; it is left in self->spare. */
static double start_first_scatter(const lanes_grid *self, size_t k)
{
    const pair edge = pair_all(self->run->cells->cell_m), lobe = pair_all(self->run->params->lobe);
    const pair most = pair_all(START_COEFFICIENT);
    const bool seen = self->seen;
    float *const absorbed = self->lost;
    const size_t end = self->body;
    pair under_way = pair_all(0.0f);
    for (size_t i = 0; i < end; i += PAIR) {
        float *const cell = grid_cell(self, k, i);
        const pair sigma_s = pair_min(pair_load(self->sigma_s + i), most);
        const pair sigma_a = pair_min(pair_load(self->sigma_a + i), most);
        const pair sigma_t = pair_add(sigma_s, sigma_a), beam = pair_load(self->beam + i);
        const pair a = pair_mul(lobe, pair_load(self->g + i));
        const pair depth = pair_min(pair_mul(sigma_t, edge), pair_all(1e18f));
        const pair tau = pair_max(depth, pair_all(1e-20f));
        const pair albedo = pair_mul(sigma_s, pair_inverse(pair_max(sigma_t, pair_all(1e-30f))));
        pair loss;
        (void)pair_transmittance(tau, &loss);
        const pair lost = pair_mul(beam, loss), fluence = pair_mul(lost, pair_inverse(tau));
        const pair scattered = pair_mul(lost, albedo);
        under_way = pair_add(under_way, scattered);
        pair_store(cell + CELL_ENERGY, scattered);
        pair_store(cell + CELL_MEAN, a);
        pair_store(self->beam + i, pair_sub(beam, lost));
        pair_store(self->spare + i, fluence);
        if (seen) {
            const pair view = pair_load(cell + CELL_VIEW);
            const pair phase = pair_phase(pair_mul(lobe, pair_load(cell + CELL_G)), view);
            pair_store(cell + CELL_SEEN, pair_mul(fluence, phase));
        }
        if (absorbed != NULL) {
            pair_store(absorbed + i, pair_sub(lost, scattered));
        }
    }
    return pair_sum(under_way);
}

/* The beam itself: where it enters, or everywhere, absorbed to the middle of each cell. */
static double start_beam(const lanes_grid *self, size_t k)
{
    const bool boundary = self->run->params->start == AIR_ORDINATES_BOUNDARY;
    const pair half = pair_all(0.5f * self->run->cells->cell_m);
    const pair lobe = pair_all(self->run->params->lobe), deepest = pair_all(START_DEPTH);
    pair under_way = pair_all(0.0f);
    for (size_t i = 0; i < self->body; i += PAIR) {
        float *const cell = grid_cell(self, k, i);
        const pair depth = pair_min(pair_mul(half, pair_load(self->sigma_a + i)), deepest);
        pair beam = pair_load(self->beam + i), rest = pair_all(0.0f), unused;
        if (!boundary) {
            const pair to_middle = pair_transmittance(depth, &unused);
            beam = pair_mul(beam, to_middle);
            rest = pair_mul(beam, to_middle);
        }
        under_way = pair_add(under_way, beam);
        pair_store(cell + CELL_ENERGY, beam);
        pair_store(cell + CELL_MEAN, lobe);
        pair_store(self->beam + i, rest);
    }
    return pair_sum(under_way);
}

/* What enters, in units of the brightest cell's. */
static double start_entry(const lanes_grid *self)
{
    const float *const entry = self->run->cells->entry;
    double in = 0.0;
    for (size_t j = 0; j < self->size[1]; j++) {
        for (size_t i = 0; i < self->size[0]; i++) {
            const float enters = entry != NULL ? entry[j * self->size[0] + i] / self->scale : 1.0f;
            self->beam[j * self->row + i] = enters;
            in += (double)enters;
        }
    }
    return in;
}

/* Depths of CM are scaled to what pair_short_exp takes. */
static void scale_depths(lanes_grid *self, float greatest)
{
    float scale = 1.0f;
    for (self->squarings = 0; greatest * scale > 0.125f; self->squarings++) {
        scale *= 0.5f;
    }
    for (size_t k = 0; k < self->size[2] && self->squarings > 0; k++) {
        for (size_t i = 0; i < self->body; i += PAIR) {
            float *const cell = grid_cell(self, k, i);
            const pair by = pair_all(scale);
            pair_store(cell + CELL_ABSORB, pair_mul(by, pair_load(cell + CELL_ABSORB)));
            pair_store(cell + CELL_TURN, pair_mul(by, pair_load(cell + CELL_TURN)));
        }
    }
}

static float greatest_of(pair x)
{
    float parts[LANES], greatest = 0.0f;
    lanes_store(parts, lanes_max(x.a, x.b));
    for (int i = 0; i < LANES; i++) {
        greatest = float_max(greatest, parts[i]);
    }
    return greatest;
}

/* Depths from which nothing is left of any path. */
enum { SEALED_DEPTH = 4 };

/* Gives what enters, and what of it is then under way. */
static double start(lanes_grid *self, double *out_under_way)
{
    const bool scattered = self->run->params->start == AIR_ORDINATES_FIRST_SCATTER;
    const bool cm = self->run->params->stencil == AIR_ORDINATES_CM;
    float *const beam = self->run->results->beam;
    const size_t slice = self->size[0] * self->size[1];
    const double in = start_entry(self);
    pair greatest = pair_all(0.0f);
    *out_under_way = 0.0;
    for (size_t k = 0; k < self->size[2]; k++) {
        greatest = start_medium(self, k, greatest);
        if (scattered) {
            *out_under_way += start_first_scatter(self, k);
            ordinates_lanes_book_lost(self);
        } else {
            *out_under_way += start_beam(self, k);
        }
        if (beam != NULL) {
            ordinates_lanes_give_slice(self, self->spare, scattered ? self->scale : 0.0f,
                                       beam + k * slice);
        }
    }
    if (cm) {
        scale_depths(self, greatest_of(greatest));
    }
    for (size_t k = 0; k < self->size[2]; k++) {
        ordinates_lanes_seal(self, k, cm ? SEALED_DEPTH : 0.0f);
    }
    for (size_t i = 0; i < self->body && !scattered; i++) {
        self->beam[i] = 0.0f;
    }
    return in;
}

#endif
