/* plain.c: runs in doubles: the start, the passes, the results. */
#include "ordinates/plain.h"

#include <stdint.h>
#include <string.h>

/* ---- scratch ---- */

static int lobes_of(const air_ordinates_params *params)
{
    return params->stencil == AIR_ORDINATES_SIX ? PLAIN_LOBES : 1;
}

/* Sizes are at most 512: 2^27 cells of 28 doubles fit into 64 bits, not into 32. */
size_t ordinates_scratch_plain(const air_ordinates_cells *cells, const air_ordinates_params *params)
{
    const uint64_t slice = (uint64_t)cells->size[0] * cells->size[1];
    const uint64_t arrays = 4 * (uint64_t)lobes_of(params) + 4;
    const uint64_t rows =
        params->stencil == AIR_ORDINATES_SIX ? ORDINATES_ROWS * sizeof(ordinates_upwind_row) : 0;
    const uint64_t bytes = (slice * cells->size[2] * arrays + slice) * sizeof(double) + rows;
    return bytes < SIZE_MAX ? (size_t)bytes : SIZE_MAX;
}

static double *take(double **at, size_t count)
{
    double *const taken = *at;
    *at += count;
    return memset(taken, 0, count * sizeof *taken);
}

static plain_grid lay_out(const ordinates_run *run)
{
    const air_ordinates_cells *const cells = run->cells;
    const size_t slice = cells->size[0] * cells->size[1];
    plain_grid out = {.run = run,
                      .size = {cells->size[0], cells->size[1], cells->size[2]},
                      .stride = {1, cells->size[0], slice},
                      .count = slice * cells->size[2],
                      .lobes = lobes_of(run->params)};
    double *at = run->scratch;
    for (int i = 0; i < out.lobes; i++) {
        out.energy[i] = take(&at, out.count);
        out.mean[i] = take(&at, out.count);
        out.sent[i] = take(&at, out.count);
        out.moment[i] = take(&at, out.count);
    }
    out.absorb = take(&at, out.count);
    out.turn = take(&at, out.count);
    out.fluence = take(&at, out.count);
    out.seen = take(&at, out.count);
    out.beam = take(&at, slice);
    out.rows = (ordinates_upwind_row *)(void *)at;
    if (out.lobes > 1) {
        ordinates_upwind_tabulate(out.rows);
    }
    return out;
}

/* ---- the start ---- */

static void put(plain_grid *self, size_t cell, double energy, double a)
{
    const int lobe = self->lobes == 1 ? 0 : a < 0.0 ? ORDINATES_BEHIND : ORDINATES_AHEAD;
    self->energy[lobe][cell] = energy;
    self->mean[lobe][cell] = lobe == ORDINATES_BEHIND ? -a : a;
}

/* What the beam loses on its way through a cell is scattered there but for what is absorbed; its
 * fluence is the mean over the way. */
static void start_first_scatter(plain_grid *self, size_t cell, double *beam)
{
    const air_ordinates_cells *const cells = self->run->cells;
    const air_ordinates_results *const results = self->run->results;
    const double sigma_s = (double)cells->sigma_s[cell], g = (double)cells->g[cell];
    const double sigma_t = sigma_s + (double)cells->sigma_a[cell];
    const double lobe = (double)self->run->params->lobe;
    const double tau = sigma_t * (double)cells->cell_m, lost = *beam * -expm1(-tau);
    const double scattered = sigma_t > 0.0 ? lost * (sigma_s / sigma_t) : 0.0;
    const double fluence = tau > 0.0 ? lost / tau : *beam;
    put(self, cell, scattered, lobe * g);
    self->books.absorbed += lost - scattered;
    if (results->beam != NULL) {
        results->beam[cell] = (float)fluence;
    }
    if (results->seen != NULL) {
        self->seen[cell] =
            fluence * ordinates_phase(lobe * ordinates_dull(g), (double)results->view_cosine[cell]);
    }
    *beam -= lost;
}

static void start_cell(plain_grid *self, size_t k, size_t cell, double *beam)
{
    const air_ordinates_cells *const cells = self->run->cells;
    const air_ordinates_params *const params = self->run->params;
    const double edge = (double)cells->cell_m, g = (double)cells->g[cell];
    self->absorb[cell] = 0.5 * edge * (double)cells->sigma_a[cell];
    self->turn[cell] =
        0.5 * edge * (double)cells->sigma_s[cell] * ordinates_decay_rate(params->decay, g);
    if (params->start == AIR_ORDINATES_FIRST_SCATTER) {
        start_first_scatter(self, cell, beam);
        return;
    }
    if (params->start == AIR_ORDINATES_BOUNDARY) {
        put(self, cell, k == 0 ? *beam : 0.0, (double)params->lobe);
    } else {
        const double half = exp(-self->absorb[cell]); /* to the middle of the cell */
        put(self, cell, *beam * half, (double)params->lobe);
        *beam *= half * half;
    }
    if (self->run->results->beam != NULL) {
        self->run->results->beam[cell] = 0.0f;
    }
}

static void start(plain_grid *self)
{
    const air_ordinates_cells *const cells = self->run->cells;
    const size_t slice = self->stride[2];
    for (size_t i = 0; i < slice; i++) {
        self->beam[i] = cells->entry != NULL ? (double)cells->entry[i] : 1.0;
        self->books.in += self->beam[i];
    }
    for (size_t i = 0; i < self->count; i++) {
        start_cell(self, i / slice, i, &self->beam[i % slice]);
        if (self->run->params->stencil == AIR_ORDINATES_LITERAL) {
            self->absorb[i] = exp(-self->absorb[i]);
            self->turn[i] = exp(-self->turn[i]);
        }
    }
    for (size_t i = 0; i < slice && self->run->params->start == AIR_ORDINATES_FIRST_SCATTER; i++) {
        self->books.out[ORDINATES_AHEAD] += self->beam[i];
    }
}

/* ---- passes ---- */

/* A cell's fluence in this pass, and the mean cosine of its light. Power times path over volume, in
 * units of one cell's entering power: the path in cells. */
static double pass_of(const plain_grid *self, size_t cell, double *out_a)
{
    const double energy = self->energy[0][cell];
    if (self->lobes == 1) {
        const double a = *out_a = self->mean[0][cell];
        return self->run->params->stencil == AIR_ORDINATES_CM ? energy * ordinates_path(a) : energy;
    }
    double fluence = 0.0, sum = 0.0, along = 0.0;
    for (int lobe = 0; lobe < PLAIN_LOBES; lobe++) {
        const double e = self->energy[lobe][cell], a = self->mean[lobe][cell];
        if (e > 0.0) {
            fluence += e * ordinates_upwind_at(self->rows, a).path;
            sum += e;
            along += lobe == ORDINATES_AHEAD ? e * a : lobe == ORDINATES_BEHIND ? -e * a : 0.0;
        }
    }
    *out_a = sum > 0.0 ? along / sum : 0.0;
    return fluence;
}

static void add_bins(const air_ordinates_results *results, size_t cell, double fluence, double a)
{
    float *const bins = results->binned + cell * results->bins;
    double below = 0.0;
    for (size_t i = 0; i < results->bins; i++) {
        const double edge = 2.0 * (double)(i + 1) / (double)results->bins - 1.0;
        const double up_to = ordinates_cumulative(a, i + 1 < results->bins ? edge : 1.0);
        bins[i] += (float)(fluence * (up_to - below));
        below = up_to;
    }
}

static void add_pass(plain_grid *self, double weight)
{
    const air_ordinates_results *const results = self->run->results;
    for (size_t i = 0; i < self->count; i++) {
        double a;
        const double fluence = weight * pass_of(self, i, &a);
        if (fluence == 0.0) {
            continue;
        }
        self->fluence[i] += fluence;
        if (results->seen != NULL) {
            const double g = ordinates_dull((double)self->run->cells->g[i]);
            self->seen[i] += fluence * ordinates_phase(a * g, (double)results->view_cosine[i]);
        }
        if (results->binned != NULL) {
            add_bins(results, i, fluence, a);
        }
    }
}

static double under_way(const plain_grid *self)
{
    double sum = 0.0;
    for (int lobe = 0; lobe < self->lobes; lobe++) {
        for (size_t i = 0; i < self->count; i++) {
            sum += self->energy[lobe][i];
        }
    }
    return sum;
}

/* ---- results ---- */

static void give(const plain_grid *self)
{
    const air_ordinates_results *const results = self->run->results;
    const double face = (double)self->run->cells->cell_m * (double)self->run->cells->cell_m;
    for (size_t i = 0; i < self->count; i++) {
        if (results->fluence != NULL) {
            results->fluence[i] = (float)self->fluence[i];
        }
        if (results->seen != NULL) {
            results->seen[i] = (float)self->seen[i];
        }
        double sum = 0.0, a;
        for (int lobe = 0; lobe < self->lobes; lobe++) {
            sum += self->energy[lobe][i];
        }
        (void)pass_of(self, i, &a);
        if (results->energy != NULL) {
            results->energy[i] = (float)(face * sum);
        }
        if (results->asymmetry != NULL) {
            results->asymmetry[i] = (float)a;
        }
    }
    if (results->books != NULL) {
        air_ordinates_books books = self->books;
        books.in *= face;
        books.absorbed *= face;
        books.residual *= face;
        for (int i = 0; i < ORDINATES_FACES; i++) {
            books.out[i] *= face;
        }
        *results->books = books;
    }
}

void ordinates_steps_plain(const ordinates_run *run)
{
    static plain_step *const stencils[3] = {plain_step_literal, plain_step_cm, plain_step_six};
    const air_ordinates_params *const params = run->params;
    plain_grid grid = lay_out(run);
    air_ordinates_books *const books = &grid.books;
    if (run->results->binned != NULL) {
        memset(run->results->binned, 0,
               grid.count * run->results->bins * sizeof *run->results->binned);
    }
    start(&grid);
    /* light that starts within a cell has half of it before it */
    add_pass(&grid, params->start == AIR_ORDINATES_FIRST_SCATTER ? 0.5 : 1.0);
    books->residual = under_way(&grid);
    while (books->steps < params->steps && books->residual > params->residual * books->in) {
        stencils[params->stencil](&grid);
        add_pass(&grid, 1.0);
        books->residual = under_way(&grid);
        books->steps++;
    }
    give(&grid);
}
