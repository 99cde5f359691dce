/* Runs in doubles: stored results of two independent programs, books, symmetry, starts, bins, and
 * the public reference. */
#include "ordinates/plain.h"

#include "ordinates_fixture.h"
#include "ordinates_golden.h"

static air_context *context;

static int set_up(void **state)
{
    (void)state;
    context = ordinates_context(0);
    return context == NULL ? 1 : 0;
}

static int tear_down(void **state)
{
    (void)state;
    air_context_destroy(context);
    return 0;
}

static double mean_of(const ordinates_outcome *outcome, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)outcome->fluence[i] + (double)outcome->beam[i];
    }
    return sum / (double)count;
}

static void expect_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance)) {
        print_message("found %.10g, expected %.10g\n", found, expected);
        fail();
    }
}

/* Two independent programs agree to 1e-8; results and g are floats: 3e-8 of 0.7, which 10 to 64
 * steps of decay raise to 1e-7 relatively, values are of order 1. Books have six digits printed. */
static void results_are_the_golden_ones(void **state)
{
    ordinates_medium cube = ordinates_cube(CUBE_SIDE);
    const size_t at = (8 * CUBE_SIDE + 7) * CUBE_SIDE + 7;
    (void)state;
    for (int i = 0; i < ORDINATES_GOLDEN; i++) {
        const ordinates_golden *const golden = &ordinates_goldens[i];
        const air_ordinates_params params =
            ordinates_params(golden->stencil, golden->decay, golden->start, golden->steps);
        ordinates_outcome found = ordinates_run_all(context, &cube, &params, 0);
        expect_near(mean_of(&found, CUBE_CELLS), golden->mean, 1e-6);
        expect_near((double)found.fluence[at] + (double)found.beam[at], golden->fluence, 1e-6);
        expect_near((double)found.energy[at] * 256.0, golden->energy, 1e-6);
        expect_near((double)found.asymmetry[at], golden->a, 1e-6);
        expect_near(found.books.out[0], golden->out[0], 1e-6);
        expect_near(found.books.out[4], golden->out[1], 1e-6);
        expect_near(found.books.out[5], golden->out[2], 1e-6);
        expect_near(found.books.residual, golden->residual, 1e-6);
        assert_int_equal(found.books.steps, golden->steps);
        ordinates_outcome_free(&found);
    }
    ordinates_medium_free(&cube);
}

/* Sums of as many doubles as there are cells and steps, 1e5 at most, of random rounding errors. */
static void books_balance(void **state)
{
    static const size_t sizes[5][3] = {{1, 1, 1}, {5, 7, 9}, {16, 3, 11}, {33, 2, 5}, {12, 12, 12}};
    double worst = 0.0;
    (void)state;
    for (int i = 0; i < 5 * 3 * 2 * 2; i++) {
        const size_t *const size = sizes[i % 5];
        ordinates_medium medium = ordinates_random(size[0], size[1], size[2], (uint32_t)i);
        air_ordinates_params params =
            ordinates_params((air_ordinates_stencil)(i / 5 % 3), (air_ordinates_decay)(i / 15 % 2),
                             (air_ordinates_start)(i / 30), 25);
        params.lobe = i % 4 == 0 ? 0.6f : 1.0f;
        medium.entry[0] = 1.0f;
        ordinates_outcome found = ordinates_run_all(context, &medium, &params, 0);
        worst = double_max(worst, ordinates_imbalance(&found.books));
        double energy = 0.0;
        for (size_t k = 0; k < medium.count; k++) {
            energy += (double)found.energy[k];
            assert_true(found.energy[k] >= 0.0f && fabsf(found.asymmetry[k]) <= 1.0f);
            assert_true(found.fluence[k] >= 0.0f && found.seen[k] >= 0.0f);
        }
        /* energies are floats, rounded to 6e-8 each */
        assert_true(fabs(energy - found.books.residual) <= 1e-7 * found.books.in);
        ordinates_outcome_free(&found);
        ordinates_medium_free(&medium);
    }
    print_message("imbalance %.1e\n", worst);
    assert_true(worst <= 1e-12);
}

/* The order of sums differs: doubles by 1e-15, floats by one rounding, 1.2e-7. */
static void mirrored_cells_are_equal(void **state)
{
    enum { N = 8 };
    ordinates_medium cube = ordinates_even(N, N, N, 4.0f, 0.3f, 0.5f);
    (void)state;
    for (int stencil = 0; stencil < 3; stencil++) {
        const air_ordinates_params params =
            ordinates_params((air_ordinates_stencil)stencil, AIR_ORDINATES_DECAY_POISSON,
                             AIR_ORDINATES_FIRST_SCATTER, 20);
        ordinates_outcome found = ordinates_run_all(context, &cube, &params, 0);
        for (size_t i = 0; i < cube.count; i++) {
            const size_t x = i % N, y = i / N % N, slice = i / (N * N) * (N * N);
            const float here = found.fluence[i];
            const float mirrored = found.fluence[slice + y * N + (N - 1 - x)];
            const float swapped = found.fluence[slice + x * N + y];
            assert_true(fabsf(here - mirrored) <= 1.3e-7f * here);
            assert_true(fabsf(here - swapped) <= 1.3e-7f * here);
        }
        ordinates_outcome_free(&found);
    }
    ordinates_medium_free(&cube);
}

/* Twice the light is twice of everything, in powers of two exactly. */
static void results_scale_with_what_enters(void **state)
{
    ordinates_medium one = ordinates_random(6, 5, 7, 3), two = ordinates_random(6, 5, 7, 3);
    air_ordinates_params params;
    (void)state;
    air_ordinates_params_default(&params);
    for (size_t i = 0; i < 30; i++) {
        two.entry[i] *= 2.0f;
    }
    ordinates_outcome a = ordinates_run_all(context, &one, &params, 4);
    ordinates_outcome b = ordinates_run_all(context, &two, &params, 4);
    for (size_t i = 0; i < one.count; i++) {
        assert_true(b.fluence[i] == 2.0f * a.fluence[i] && b.seen[i] == 2.0f * a.seen[i]);
        assert_true(b.beam[i] == 2.0f * a.beam[i] && b.energy[i] == 2.0f * a.energy[i]);
        assert_true(b.asymmetry[i] == a.asymmetry[i]);
    }
    assert_int_equal(a.books.steps, b.books.steps);
    ordinates_outcome_free(&a);
    ordinates_outcome_free(&b);
    ordinates_medium_free(&one);
    ordinates_medium_free(&two);
}

/* Clear air: a beam arrives whole, whatever the start; all cells of it are in the paper's. */
static void a_beam_crosses_clear_air(void **state)
{
    ordinates_medium clear = ordinates_even(3, 4, 5, 0.0f, 0.0f, 0.9f);
    (void)state;
    for (int i = 0; i < 6; i++) {
        const air_ordinates_start start = (air_ordinates_start)(i / 3);
        air_ordinates_params params = ordinates_params((air_ordinates_stencil)(i % 3),
                                                       AIR_ORDINATES_DECAY_POISSON, start, 10);
        params.residual = 1e-12; /* rounding leaves 1e-17 behind */
        ordinates_outcome found = ordinates_run_all(context, &clear, &params, 0);
        for (size_t k = 0; k < clear.count; k++) {
            expect_near((double)found.fluence[k] + (double)found.beam[k], 1.0, 0.0);
        }
        /* 12 cells of 0.2 m, a float */
        expect_near(found.books.in, 12 * 0.04, 1e-7);
        expect_near(found.books.out[5], 12 * 0.04, 1e-7);
        assert_int_equal(found.books.steps, start == AIR_ORDINATES_BOUNDARY ? 5 : 0);
        ordinates_outcome_free(&found);
    }
    const air_ordinates_params all = ordinates_params(
        AIR_ORDINATES_LITERAL, AIR_ORDINATES_DECAY_PAPER, AIR_ORDINATES_ALL_CELLS, 10);
    ordinates_outcome found = ordinates_run_all(context, &clear, &all, 0);
    for (size_t k = 0; k < clear.count; k++) {
        expect_near((double)found.fluence[k], 1.0 + (double)(k / 12), 0.0);
    }
    ordinates_outcome_free(&found);
    ordinates_medium_free(&clear);
}

/* Absorption alone: exp(-sigma z), and the mean of it over a cell for the unscattered beam. The
 * paper's start sees the middle of cells. Floats. */
static void absorbed_light_falls_off_exponentially(void **state)
{
    ordinates_medium medium = ordinates_even(2, 2, 8, 0.0f, 1.5f, 0.9f);
    const double tau = 1.5 / 8.0;
    (void)state;
    for (int stencil = 0; stencil < 3; stencil++) {
        const air_ordinates_params params =
            ordinates_params((air_ordinates_stencil)stencil, AIR_ORDINATES_DECAY_POISSON,
                             AIR_ORDINATES_FIRST_SCATTER, 10);
        air_ordinates_params other = params;
        other.start = AIR_ORDINATES_BOUNDARY;
        ordinates_outcome found = ordinates_run_all(context, &medium, &params, 0);
        ordinates_outcome carried = ordinates_run_all(context, &medium, &other, 0);
        for (size_t i = 0; i < medium.count; i++) {
            const double k = (double)(i / 4), begin = exp(-k * tau);
            expect_near((double)found.beam[i], begin * (1.0 - exp(-tau)) / tau, 1e-6);
            expect_near((double)carried.fluence[i], begin, 1e-6);
        }
        expect_near(found.books.absorbed / found.books.in, 1.0 - exp(-1.5), 1e-6);
        ordinates_outcome_free(&found);
        ordinates_outcome_free(&carried);
    }
    ordinates_medium_free(&medium);
}

/* Bins of one pass are floats, added up: 21 passes of 1e-7; even the sharpest lobe is in them. */
static void bins_sum_to_the_fluence_and_give_its_mean_cosine(void **state)
{
    enum { BINS = 7 };
    ordinates_medium medium = ordinates_random(5, 6, 7, 11);
    (void)state;
    for (int stencil = 0; stencil < 3; stencil++) {
        const air_ordinates_params params =
            ordinates_params((air_ordinates_stencil)stencil, AIR_ORDINATES_DECAY_POISSON,
                             (air_ordinates_start)(stencil % 2), 20);
        ordinates_outcome found = ordinates_run_all(context, &medium, &params, BINS);
        for (size_t i = 0; i < medium.count; i++) {
            double sum = 0.0;
            for (size_t k = 0; k < BINS; k++) {
                assert_true(found.binned[i * BINS + k] >= 0.0f);
                sum += (double)found.binned[i * BINS + k];
            }
            expect_near(sum, (double)found.fluence[i], 3e-6 * (double)found.fluence[i]);
        }
        ordinates_outcome_free(&found);
    }
    ordinates_medium_free(&medium);
}

/* seen over all cosines, 2 pi times its integral, is the fluence of the cells' light and of the
 * beam: the phase function is normalised. Midpoint rule of 400 cosines for g = 0.6: an error of
 * (1/200)^2/24 times the greatest slope, 56 (of 2 pi times the function): 6e-5. */
static void what_is_seen_integrates_to_the_fluence(void **state)
{
    enum { N = 400 };
    ordinates_medium medium = ordinates_even(2, 2, 3, 3.0f, 0.4f, 0.6f);
    double sum[12] = {0.0}, fluence[12];
    (void)state;
    for (int i = 0; i < N; i++) {
        const air_ordinates_params params = ordinates_params(
            AIR_ORDINATES_CM, AIR_ORDINATES_DECAY_POISSON, AIR_ORDINATES_FIRST_SCATTER, 9);
        for (size_t k = 0; k < 12; k++) {
            medium.view_cosine[k] = (float)(2.0 * (i + 0.5) / N - 1.0);
        }
        ordinates_outcome found = ordinates_run_all(context, &medium, &params, 0);
        for (size_t k = 0; k < 12; k++) {
            sum[k] += 4.0 * AIR_PI / N * (double)found.seen[k];
            fluence[k] = (double)found.fluence[k] + (double)found.beam[k];
        }
        ordinates_outcome_free(&found);
    }
    for (size_t k = 0; k < 12; k++) {
        expect_near(sum[k], fluence[k], 1e-4 * fluence[k]);
    }
    ordinates_medium_free(&medium);
}

/* ---- the public cube ---- */

static double rms_fluence(const ordinates_outcome *found, const float *reference)
{
    double squares = 0.0, sum = 0.0;
    for (int i = 0; i < CUBE_CELLS; i++) {
        const double off =
            (double)found->fluence[i] + (double)found->beam[i] - (double)reference[i];
        squares += off * off;
        sum += (double)reference[i];
    }
    return sqrt(squares / CUBE_CELLS) / (sum / CUBE_CELLS);
}

/* Half the L1 distance of normalised histograms, mean over cells of the slice between j = 7 and 8;
 * the beam is in the last bin. */
static double total_variation(const ordinates_outcome *found, const float *reference,
                              const float *beam)
{
    double sum = 0.0;
    for (size_t k = 0; k < CUBE_SIDE; k++) {
        for (size_t i = 0; i < CUBE_SIDE; i++) {
            double h[2][CUBE_BINS], whole[2] = {0.0, 0.0};
            for (size_t bin = 0; bin < CUBE_BINS; bin++) {
                const size_t low = (k * CUBE_SIDE + 7) * CUBE_SIDE + i, high = low + CUBE_SIDE;
                const double last = bin == CUBE_BINS - 1 ? 0.5 : 0.0;
                h[0][bin] = 0.5 * ((double)found->binned[low * CUBE_BINS + bin] +
                                   (double)found->binned[high * CUBE_BINS + bin]) +
                            last * ((double)found->beam[low] + (double)found->beam[high]);
                h[1][bin] = (double)reference[(k * CUBE_SIDE + i) * CUBE_BINS + bin] +
                            last * ((double)beam[low] + (double)beam[high]);
                whole[0] += h[0][bin];
                whole[1] += h[1][bin];
            }
            for (size_t bin = 0; bin < CUBE_BINS; bin++) {
                sum += 0.5 * fabs(h[0][bin] / whole[0] - h[1][bin] / whole[1]);
            }
        }
    }
    return sum / (CUBE_SIDE * CUBE_SIDE);
}

/* The errors that the method is known to have, printed with two or three digits; -1: not known. */
static void errors_are_the_known_ones(void **state)
{
    static const struct {
        air_ordinates_stencil stencil;
        air_ordinates_decay decay;
        uint32_t steps;
        double rms, tv, half_digit, residual;
    } known[7] = {{AIR_ORDINATES_LITERAL, AIR_ORDINATES_DECAY_PAPER, 10, 0.261, -1.0, 6e-4, 0.0},
                  {AIR_ORDINATES_LITERAL, AIR_ORDINATES_DECAY_PAPER, 16, 0.396, -1.0, 6e-4, 0.0},
                  {AIR_ORDINATES_LITERAL, AIR_ORDINATES_DECAY_PAPER, 4096, 3.28, 0.32, 6e-3, 1e-4},
                  {AIR_ORDINATES_CM, AIR_ORDINATES_DECAY_POISSON, 10, 0.305, -1.0, 6e-4, 0.0},
                  {AIR_ORDINATES_CM, AIR_ORDINATES_DECAY_POISSON, 64, 0.206, -1.0, 6e-4, 0.0},
                  {AIR_ORDINATES_CM, AIR_ORDINATES_DECAY_POISSON, 4096, 0.23, 0.11, 6e-3, 1e-4},
                  {AIR_ORDINATES_SIX, AIR_ORDINATES_DECAY_POISSON, 4096, 0.104, 0.086, 6e-4, 1e-4}};
    float *const fluence = ordinates_floats(3 * CUBE_CELLS, 0.0f);
    float *const angular = ordinates_floats(CUBE_SIDE * CUBE_SIDE * CUBE_BINS, 0.0f);
    const bool there =
        ordinates_reference("cube_g07_fluence.f32", 3 * CUBE_CELLS, fluence) &&
        ordinates_reference("cube_g07_angular.f32", CUBE_SIDE * CUBE_SIDE * CUBE_BINS, angular);
    (void)state;
    for (int i = 0; i < 7 && there; i++) {
        ordinates_medium cube = ordinates_cube(CUBE_SIDE);
        air_ordinates_params params = ordinates_params(known[i].stencil, known[i].decay,
                                                       AIR_ORDINATES_FIRST_SCATTER, known[i].steps);
        params.residual = known[i].residual;
        ordinates_outcome found =
            ordinates_run_all(context, &cube, &params, known[i].tv > 0.0 ? CUBE_BINS : 0);
        const double rms = rms_fluence(&found, fluence);
        const double tv =
            known[i].tv > 0.0 ? total_variation(&found, angular, fluence + 2 * CUBE_CELLS) : -1.0;
        print_message("%d, %u steps: rms %.4f, total variation %.4f\n", (int)known[i].stencil,
                      found.books.steps, rms, tv);
        expect_near(rms, known[i].rms, known[i].half_digit);
        expect_near(tv, known[i].tv, 6e-3);
        ordinates_outcome_free(&found);
        ordinates_medium_free(&cube);
    }
    free(fluence);
    free(angular);
    if (!there) {
        skip();
    }
}

/* Converged means of the public cube, truth 0.890: the paper's stencil walks at random whatever the
 * medium, and in finer cells for longer. Printed with three digits. */
static void the_papers_stencil_diverges_and_moments_do_not(void **state)
{
    double mean[2][2];
    (void)state;
    for (int i = 0; i < 4; i++) {
        const size_t side = i % 2 == 0 ? 8 : 16;
        const bool literal = i < 2;
        ordinates_medium cube = ordinates_cube(side);
        air_ordinates_params params =
            ordinates_params(literal ? AIR_ORDINATES_LITERAL : AIR_ORDINATES_CM,
                             literal ? AIR_ORDINATES_DECAY_PAPER : AIR_ORDINATES_DECAY_POISSON,
                             literal ? AIR_ORDINATES_BOUNDARY : AIR_ORDINATES_FIRST_SCATTER, 4096);
        params.residual = 1e-5;
        ordinates_outcome found = ordinates_run_all(context, &cube, &params, 0);
        mean[i / 2][i % 2] = mean_of(&found, cube.count);
        print_message("%s %zu: %.4f\n", literal ? "literal" : "cm", side, mean[i / 2][i % 2]);
        ordinates_outcome_free(&found);
        ordinates_medium_free(&cube);
    }
    expect_near(mean[0][0], 2.23, 6e-3);
    expect_near(mean[0][1], 3.48, 6e-3);
    assert_true(mean[1][1] < 1.1 * mean[1][0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_are_the_golden_ones),
        cmocka_unit_test(books_balance),
        cmocka_unit_test(mirrored_cells_are_equal),
        cmocka_unit_test(results_scale_with_what_enters),
        cmocka_unit_test(a_beam_crosses_clear_air),
        cmocka_unit_test(absorbed_light_falls_off_exponentially),
        cmocka_unit_test(bins_sum_to_the_fluence_and_give_its_mean_cosine),
        cmocka_unit_test(what_is_seen_integrates_to_the_fluence),
        cmocka_unit_test(errors_are_the_known_ones),
        cmocka_unit_test(the_papers_stencil_diverges_and_moments_do_not),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
