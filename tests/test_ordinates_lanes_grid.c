/* Where the cells of a grid in lanes lie, what its books sum, what is given back. */
#include "ordinates/lanes_grid.h"

#include "ordinates_fixture.h"

typedef struct laid {
    ordinates_medium medium;
    air_ordinates_params params;
    air_ordinates_results results;
    air_ordinates_books books;
    ordinates_run run;
    lanes_grid grid;
    float *given;
    size_t bytes;
} laid;

static laid *lay(size_t x, size_t y, size_t z)
{
    laid *const self = calloc(1, sizeof *self);
    assert_non_null(self);
    self->medium = ordinates_even(x, y, z, 1.0f, 0.0f, 0.0f);
    self->given = ordinates_floats(self->medium.count, NAN);
    air_ordinates_params_default(&self->params);
    self->results = (air_ordinates_results){.energy = self->given, .books = &self->books};
    self->bytes = ordinates_scratch_lanes(&self->medium.cells, &self->params);
    self->run = (ordinates_run){.cells = &self->medium.cells,
                                .params = &self->params,
                                .results = &self->results,
                                .scratch = aligned_alloc(64, (self->bytes + 63) / 64 * 64)};
    assert_non_null(self->run.scratch);
    ordinates_lanes_lay_out(&self->run, &self->grid);
    return self;
}

static void laid_free(laid *self)
{
    ordinates_medium_free(&self->medium);
    free(self->given);
    free(self->run.scratch);
    free(self);
}

static const size_t sizes[5][3] = {{1, 1, 1}, {20, 20, 3}, {31, 2, 4}, {32, 5, 2}, {7, 40, 1}};

/* Slices begin at cache lines, in what was asked for; rows before and after a slice of the ring are
 * its own. */
static void slices_lie_in_the_scratch_at_cache_lines(void **state)
{
    (void)state;
    for (int i = 0; i < 5; i++) {
        laid *const self = lay(sizes[i][0], sizes[i][1], sizes[i][2]);
        const lanes_grid *const g = &self->grid;
        const char *const begin = self->run.scratch, *const end = begin + self->bytes;
        for (size_t k = 0; k < g->size[2]; k++) {
            assert_true((uintptr_t)grid_cell(g, k, 0) % 64 == 0);
            assert_true((const char *)grid_cell(g, k, 0) >= begin);
        }
        for (size_t k = 0; k < RING_SLICES; k++) {
            assert_true((uintptr_t)grid_ring(g, k) % 64 == 0);
            assert_true(grid_ring(g, k) - g->row >= g->cells + g->size[2] * g->body * CELL_ARRAYS);
        }
        assert_true(g->margin >= g->row && g->body >= g->row * g->size[1]);
        assert_true((const char *)(g->lost + g->body) <= end);
        laid_free(self);
    }
}

/* Each cell by itself: no two share a place, and all are given back where they belong. */
static void cells_are_given_back_in_order(void **state)
{
    (void)state;
    for (int i = 0; i < 5; i++) {
        laid *const self = lay(sizes[i][0], sizes[i][1], sizes[i][2]);
        const lanes_grid *const g = &self->grid;
        const size_t slice = g->size[0] * g->size[1];
        const float face = self->medium.cells.cell_m * self->medium.cells.cell_m;
        memset(g->cells, 0, g->size[2] * g->body * CELL_ARRAYS * sizeof(float));
        for (size_t c = 0; c < self->medium.count; c++) {
            const size_t at = c % slice / g->size[0] * g->row + c % g->size[0];
            grid_cell(g, c / slice, at)[CELL_ENERGY] = (float)(c + 1);
        }
        ordinates_lanes_give(g, 3, 0.25);
        for (size_t c = 0; c < self->medium.count; c++) {
            assert_true(fabsf(self->given[c] - face * (float)(c + 1)) <= 1e-6f * self->given[c]);
        }
        assert_int_equal(self->books.steps, 3);
        assert_true(fabs(self->books.residual / (double)face - 0.25) < 1e-6);
        laid_free(self);
    }
}

/* A slice's four edges, its ends where it is the first or the last. */
static void books_take_what_crosses_the_faces(void **state)
{
    laid *const self = lay(3, 2, 2);
    lanes_grid *const g = &self->grid;
    static const double expected[2][6] = {{5.0, 9.0, 6.0, 15.0, 2100.0, 0.0},
                                          {5.0, 9.0, 6.0, 15.0, 0.0, 21000.0}};
    (void)state;
    for (size_t k = 0; k < 2; k++) {
        for (size_t i = 0; i < 6; i++) {
            const size_t at = i / 3 * g->row + i % 3;
            grid_ring(g, RING_SIDE + k)[at] = (float)(i + 1);
            grid_ring(g, RING_BACK)[at] = 100.0f * (float)(i + 1);
            grid_ring(g, RING_FRONT + k)[at] = 1000.0f * (float)(i + 1);
        }
        memset(g->out, 0, sizeof g->out);
        ordinates_lanes_book_faces(g, k);
        for (int face = 0; face < 6; face++) {
            assert_true(g->out[face] == expected[k][face]);
        }
    }
    laid_free(self);
}

static void seals_lie_between_and_behind_rows(void **state)
{
    laid *const self = lay(5, 3, 2);
    const lanes_grid *const g = &self->grid;
    (void)state;
    memset(g->cells, 0, g->size[2] * g->body * CELL_ARRAYS * sizeof(float));
    ordinates_lanes_seal(g, 1, 4.0f);
    for (size_t i = 0; i < g->body; i++) {
        const bool inside = i / g->row < 3 && i % g->row < 5;
        assert_true(grid_cell(g, 1, i)[CELL_ABSORB] == (inside ? 0.0f : 4.0f));
        assert_true(grid_cell(g, 0, i)[CELL_ABSORB] == 0.0f);
        assert_true(grid_cell(g, 1, i)[CELL_TURN] == 0.0f);
    }
    laid_free(self);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_lie_in_the_scratch_at_cache_lines),
        cmocka_unit_test(cells_are_given_back_in_order),
        cmocka_unit_test(books_take_what_crosses_the_faces),
        cmocka_unit_test(seals_lie_between_and_behind_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
