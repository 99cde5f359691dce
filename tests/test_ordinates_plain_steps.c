/* One step of each stencil, in doubles: what leaves a cell in the middle and where it goes. */
#include "ordinates/plain.h"

#include "ordinates_fixture.h"

enum { N = 5, CELLS = N * N * N, MIDDLE = (2 * N + 2) * N + 2 };

/* A grid with light in its middle alone. */
typedef struct middle {
    plain_grid grid;
    ordinates_upwind_row *rows;
    double arrays[4 * PLAIN_LOBES + 2][CELLS];
} middle;

static middle *middle_make(int lobes, double absorb, double turn)
{
    middle *const self = calloc(1, sizeof *self);
    assert_non_null(self);
    self->rows = malloc(ORDINATES_ROWS * sizeof *self->rows);
    assert_non_null(self->rows);
    ordinates_upwind_tabulate(self->rows);
    self->grid = (plain_grid){.size = {N, N, N},
                              .stride = {1, N, N * N},
                              .count = CELLS,
                              .lobes = lobes,
                              .absorb = self->arrays[4 * PLAIN_LOBES],
                              .turn = self->arrays[4 * PLAIN_LOBES + 1],
                              .rows = self->rows};
    for (int i = 0; i < lobes; i++) {
        self->grid.energy[i] = self->arrays[4 * i];
        self->grid.mean[i] = self->arrays[4 * i + 1];
        self->grid.sent[i] = self->arrays[4 * i + 2];
        self->grid.moment[i] = self->arrays[4 * i + 3];
    }
    for (int i = 0; i < CELLS; i++) {
        self->grid.absorb[i] = absorb;
        self->grid.turn[i] = turn;
    }
    return self;
}

static void middle_free(middle *self)
{
    free(self->rows);
    free(self);
}

static double sum_of_moments(const plain_grid *grid, int lobe)
{
    double sum = 0.0;
    for (size_t i = 0; i < grid->count; i++) {
        sum += grid->energy[lobe][i] * grid->mean[lobe][i];
    }
    return sum;
}

/* Without decay, sums of a few doubles. */
static void moments_carry_the_mean_cosine_on(void **state)
{
    (void)state;
    for (double a = -0.95; a < 1.0; a += 0.05) {
        middle *const self = middle_make(1, 0.0, 0.0);
        self->grid.energy[0][MIDDLE] = 1.0;
        self->grid.mean[0][MIDDLE] = a;
        plain_step_cm(&self->grid);
        assert_true(fabs(sum_of_moments(&self->grid, 0) - a) < 1e-14);
        plain_step_cm(&self->grid);
        assert_true(fabs(sum_of_moments(&self->grid, 0) - a) < 1e-14);
        assert_true(self->grid.books.out[0] == 0.0);
        middle_free(self);
    }
}

/* What went ahead has mean cosine MF/F, and so for the other patches; over half a cell on either
 * side both are lessened by their depth times the path of the lobe that is there. */
static void each_patch_has_its_own_mean_cosine(void **state)
{
    const double absorb = 0.03, turn = 0.05, a = 0.6;
    const air_ordinates_shares s = air_ordinates_shares_of(a);
    const double share[3] = {s.front, s.side, s.back};
    const double mean[3] = {s.front_mean, s.side_mean, s.back_mean};
    const size_t to[3] = {MIDDLE + N * N, MIDDLE + 1, MIDDLE - N * N};
    middle *const self = middle_make(1, absorb, turn);
    (void)state;
    self->grid.energy[0][MIDDLE] = 2.0;
    self->grid.mean[0][MIDDLE] = a;
    plain_step_cm(&self->grid);
    for (int i = 0; i < 3; i++) {
        const double before = ordinates_path(a), arrived = mean[i] / share[i] * exp(-turn * before);
        const double after = ordinates_path(arrived);
        const double energy = 2.0 * share[i] * exp(-absorb * (before + after));
        assert_true(fabs(self->grid.energy[0][to[i]] / energy - 1.0) < 1e-14);
        assert_true(fabs(self->grid.mean[0][to[i]] / (arrived * exp(-turn * after)) - 1.0) < 1e-14);
    }
    middle_free(self);
}

/* Merged again, light from two sides has the mean cosine of both by power, decayed by half a cell
 * on either side. LITERAL holds factors instead of depths. */
static void the_papers_light_is_merged_by_power(void **state)
{
    const double e = 0.9, q = 0.8;
    const air_ordinates_shares low = air_ordinates_shares_of(0.9),
                               high = air_ordinates_shares_of(0.2);
    middle *const self = middle_make(1, e, q);
    const double from_low = 1.0 * e * low.front, from_high = 3.0 * e * high.back;
    (void)state;
    self->grid.energy[0][MIDDLE - N * N] = 1.0;
    self->grid.mean[0][MIDDLE - N * N] = 0.9;
    self->grid.energy[0][MIDDLE + N * N] = 3.0;
    self->grid.mean[0][MIDDLE + N * N] = 0.2;
    plain_step_literal(&self->grid);
    const double mean = q * q * (0.9 * from_low + 0.2 * from_high) / (from_low + from_high);
    assert_true(fabs(self->grid.energy[0][MIDDLE] - e * (from_low + from_high)) < 1e-15);
    assert_true(fabs(self->grid.mean[0][MIDDLE] - mean) < 1e-15);
    middle_free(self);
}

/* Six lobes' momentum is the beam's as long as no mean cosine is cut at 1: of isotropic light all
 * goes to the lobes of the faces it leaves by. */
static void six_lobes_of_even_light_stay_even(void **state)
{
    middle *const self = middle_make(PLAIN_LOBES, 0.0, 0.0);
    (void)state;
    self->grid.energy[ORDINATES_AHEAD][MIDDLE] = 6.0;
    plain_step_six(&self->grid);
    for (int lobe = 0; lobe < PLAIN_LOBES; lobe++) {
        const size_t step = lobe / 2 == 0 ? 1 : lobe / 2 == 1 ? N : N * N;
        const size_t to = lobe % 2 == 0 ? MIDDLE - step : MIDDLE + step;
        /* the table's integrals hold to 1e-11 */
        assert_true(fabs(self->grid.energy[lobe][to] - 1.0) < 1e-10);
        assert_true(fabs(self->grid.mean[lobe][to] -
                         self->grid.mean[ORDINATES_AHEAD][MIDDLE + N * N]) < 1e-10);
    }
    middle_free(self);
}

/* The axial momentum that comes out is what went in, but where the cut takes some of it. */
static void six_lobes_lose_momentum_only_to_the_cut(void **state)
{
    (void)state;
    for (double a = 0.0; a < 1.0; a += 0.1) {
        middle *const self = middle_make(PLAIN_LOBES, 0.0, 0.0);
        self->grid.energy[ORDINATES_AHEAD][MIDDLE] = 1.0;
        self->grid.mean[ORDINATES_AHEAD][MIDDLE] = a;
        plain_step_six(&self->grid);
        const double along = sum_of_moments(&self->grid, ORDINATES_AHEAD) -
                             sum_of_moments(&self->grid, ORDINATES_BEHIND);
        print_message("a %.1f: %.4f\n", a, along);
        assert_true(along <= a + 1e-14 && along > a - 0.05);
        middle_free(self);
    }
}

/* At a corner of the grid all three outer faces let light out, once. */
static void light_leaves_through_the_faces(void **state)
{
    (void)state;
    for (int stencil = 0; stencil < 3; stencil++) {
        plain_step *const steps[3] = {plain_step_literal, plain_step_cm, plain_step_six};
        middle *const self = middle_make(stencil == 2 ? PLAIN_LOBES : 1, stencil == 0 ? 1.0 : 0.0,
                                         stencil == 0 ? 1.0 : 0.0);
        const int lobe = stencil == 2 ? ORDINATES_AHEAD : 0;
        self->grid.energy[lobe][0] = 1.0;
        self->grid.mean[lobe][0] = 0.5;
        steps[stencil](&self->grid);
        const air_ordinates_shares s = air_ordinates_shares_of(0.5);
        const ordinates_upwind u = ordinates_upwind_at(self->rows, 0.5);
        const double *const out = self->grid.books.out;
        const double side = stencil == 2 ? u.side : s.side, back = stencil == 2 ? u.back : s.back;
        assert_true(fabs(out[0] - side) < 1e-15 && fabs(out[2] - side) < 1e-15);
        assert_true(fabs(out[4] - back) < 1e-15);
        assert_true(out[1] == 0.0 && out[3] == 0.0 && out[5] == 0.0);
        middle_free(self);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_carry_the_mean_cosine_on),
        cmocka_unit_test(each_patch_has_its_own_mean_cosine),
        cmocka_unit_test(the_papers_light_is_merged_by_power),
        cmocka_unit_test(six_lobes_of_even_light_stay_even),
        cmocka_unit_test(six_lobes_lose_momentum_only_to_the_cut),
        cmocka_unit_test(light_leaves_through_the_faces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
