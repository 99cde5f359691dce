/* lanes_grid.c: layout, books and results of runs in floats side by side. */
#include "ordinates/lanes_grid.h"

#include <string.h>

#include "core/vec.h"

enum { SINGLE_SLICES = 8 }; /* dark, beam, sigma_s, sigma_a, g, view, spare, lost */

static size_t whole(size_t floats, size_t unit) { return (floats + unit - 1) / unit * unit; }

static void measure(const air_ordinates_cells *cells, lanes_grid *out)
{
    out->size[0] = cells->size[0];
    out->size[1] = cells->size[1];
    out->size[2] = cells->size[2];
    out->row = cells->size[0] + 1;
    out->body = whole(out->row * cells->size[1], BLOCK_FLOATS);
    out->margin = whole(out->row, LINE_FLOATS);
}

size_t ordinates_scratch_lanes(const air_ordinates_cells *cells, const air_ordinates_params *params)
{
    lanes_grid grid;
    (void)params;
    measure(cells, &grid);
    const uint64_t slices = (uint64_t)cells->size[2] * CELL_ARRAYS + SINGLE_SLICES + RING_SLICES;
    const uint64_t floats = slices * grid.body + (uint64_t)2 * RING_SLICES * grid.margin;
    const uint64_t bytes = floats * sizeof(float);
    return bytes < SIZE_MAX ? (size_t)bytes : SIZE_MAX;
}

static float *take(float **at, size_t floats)
{
    float *const taken = *at;
    *at += floats;
    return memset(taken, 0, floats * sizeof *taken);
}

static float greatest_entry(const air_ordinates_cells *cells)
{
    float greatest = 0.0f;
    for (size_t i = 0; cells->entry != NULL && i < cells->size[0] * cells->size[1]; i++) {
        greatest = float_max(greatest, cells->entry[i]);
    }
    return greatest > 0.0f ? greatest : 1.0f;
}

void ordinates_lanes_lay_out(const ordinates_run *run, lanes_grid *out)
{
    float *at = run->scratch;
    *out = (lanes_grid){.run = run};
    measure(run->cells, out);
    out->cells = at;
    at += out->size[2] * CELL_ARRAYS * out->body;
    out->ring = take(&at, RING_SLICES * (out->body + 2 * out->margin));
    out->dark = take(&at, out->body);
    out->beam = take(&at, out->body);
    out->sigma_s = take(&at, out->body);
    out->sigma_a = take(&at, out->body);
    out->g = take(&at, out->body);
    out->view = take(&at, out->body);
    out->spare = take(&at, out->body);
    out->lost = run->results->books != NULL ? take(&at, out->body) : NULL;
    out->scale = greatest_entry(run->cells);
    out->fluence = run->results->fluence != NULL;
    out->seen = run->results->seen != NULL;
}

/* ---- books ---- */

static double sum_row(const float *row, size_t count, size_t step)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)row[i * step];
    }
    return sum;
}

/* Every SUMS-th column together: sums that do not wait for each other. */
static double sum_slice(const lanes_grid *self, const float *slice)
{
    enum { SUMS = 8 };
    const size_t n = self->size[0];
    double sums[SUMS] = {0.0}, all = 0.0;
    for (size_t j = 0; j < self->size[1]; j++) {
        const float *const row = slice + j * self->row;
        size_t i = 0;
        for (; i + SUMS <= n; i += SUMS) {
            for (size_t c = 0; c < SUMS; c++) {
                sums[c] += (double)row[i + c];
            }
        }
        all += sum_row(row + i, n - i, 1);
    }
    for (size_t c = 0; c < SUMS; c++) {
        all += sums[c];
    }
    return all;
}

void ordinates_lanes_book_faces(lanes_grid *self, size_t k)
{
    if (self->lost == NULL) {
        return;
    }
    const size_t *const size = self->size;
    const float *const side = grid_ring(self, RING_SIDE + k % 2);
    self->out[0] += sum_row(side, size[1], self->row);
    self->out[1] += sum_row(side + size[0] - 1, size[1], self->row);
    self->out[2] += sum_row(side, size[0], 1);
    self->out[3] += sum_row(side + (size[1] - 1) * self->row, size[0], 1);
    if (k == 0) {
        self->out[ORDINATES_BEHIND] += sum_slice(self, grid_ring(self, RING_BACK));
    }
    if (k + 1 == size[2]) {
        self->out[ORDINATES_AHEAD] += sum_slice(self, grid_ring(self, RING_FRONT + k % 3));
    }
}

void ordinates_lanes_book_lost(lanes_grid *self)
{
    if (self->lost != NULL) {
        self->absorbed += sum_slice(self, self->lost);
    }
}

void ordinates_lanes_seal(const lanes_grid *self, size_t k, float value)
{
    for (size_t i = self->size[0]; i < self->body; i += self->row) {
        grid_cell(self, k, i)[CELL_ABSORB] = value;
    }
    for (size_t i = self->row * self->size[1]; i < self->body; i++) {
        grid_cell(self, k, i)[CELL_ABSORB] = value;
    }
}

/* ---- results ---- */

static void give_books(const lanes_grid *self, uint32_t steps, double residual)
{
    const air_ordinates_cells *const cells = self->run->cells;
    const double face = (double)cells->cell_m * (double)cells->cell_m;
    const double unit = face * (double)self->scale;
    const size_t slice = cells->size[0] * cells->size[1];
    air_ordinates_books books = {
        .absorbed = unit * self->absorbed, .residual = unit * residual, .steps = steps};
    books.in = face * (cells->entry != NULL ? sum_row(cells->entry, slice, 1) : (double)slice);
    for (int i = 0; i < ORDINATES_FACES; i++) {
        books.out[i] = unit * self->out[i];
    }
    books.out[ORDINATES_AHEAD] += unit * sum_slice(self, self->beam);
    *self->run->results->books = books;
}

void ordinates_lanes_give_slice(const lanes_grid *self, const float *slice, float scale, float *out)
{
    const size_t n = self->size[0];
    for (size_t j = 0; j < self->size[1]; j++) {
        for (size_t i = 0; i < n; i++) {
            out[j * n + i] = scale * slice[j * self->row + i];
        }
    }
}

static void give_array(const lanes_grid *self, size_t array, float scale, float *out)
{
    const size_t slice = self->size[0] * self->size[1];
    for (size_t k = 0; k < self->size[2] && out != NULL; k++) {
        for (size_t i = 0; i < self->body; i += BLOCK_FLOATS) {
            memcpy(self->spare + i, grid_cell(self, k, i) + array, BLOCK_FLOATS * sizeof *out);
        }
        ordinates_lanes_give_slice(self, self->spare, scale, out + k * slice);
    }
}

void ordinates_lanes_give(const lanes_grid *self, uint32_t steps, double residual)
{
    const air_ordinates_results *const results = self->run->results;
    const double edge = (double)self->run->cells->cell_m;
    give_array(self, CELL_FLUENCE, self->scale, results->fluence);
    give_array(self, CELL_SEEN, self->scale * (float)(0.25 / AIR_PI), results->seen);
    give_array(self, CELL_ENERGY, (float)(edge * edge * (double)self->scale), results->energy);
    give_array(self, CELL_MEAN, 1.0f, results->asymmetry);
    if (results->books != NULL) {
        give_books(self, steps, residual);
    }
}
