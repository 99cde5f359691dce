/* Steps in floats side by side: what the plain version gives, by every instruction set of this
 * machine; their own books, early ends and light that is too dim or too bright. */
#include "ordinates/plain.h"

#include "ordinates_fixture.h"

static air_context *contexts[ORDINATES_LEVELS];

static int set_up(void **state)
{
    (void)state;
    for (int level = 0; level < ORDINATES_LEVELS; level++) {
        contexts[level] = ordinates_context(level);
    }
    return contexts[0] == NULL ? 1 : 0;
}

static int tear_down(void **state)
{
    (void)state;
    for (int level = 0; level < ORDINATES_LEVELS; level++) {
        air_context_destroy(contexts[level]);
    }
    return 0;
}

enum { SIZES = 8, STEPS = 12 };

/* Rows shorter and longer than vectors, equal to them and one off. */
static const size_t sizes[SIZES][3] = {{1, 1, 1},   {3, 2, 5},  {7, 5, 4},   {16, 16, 3},
                                       {15, 17, 2}, {33, 4, 6}, {20, 20, 8}, {31, 1, 12}};

static double greatest_of(const float *x, size_t count)
{
    double greatest = 0.0;
    for (size_t i = 0; i < count; i++) {
        greatest = double_max(greatest, fabs((double)x[i]));
    }
    return greatest;
}

/* The largest difference as a share of the largest value. */
static double difference(const float *found, const float *expected, size_t count)
{
    double worst = 0.0;
    for (size_t i = 0; i < count; i++) {
        assert_true(isfinite(found[i]));
        worst = double_max(worst, fabs((double)found[i] - (double)expected[i]));
    }
    return worst > 0.0 ? worst / greatest_of(expected, count) : 0.0;
}

/* Of the mean cosines of cells with a hundredth of the largest energy. */
static double difference_of_means(const ordinates_outcome *found, const ordinates_outcome *expected,
                                  size_t count)
{
    const double least = 0.01 * greatest_of(expected->energy, count);
    double worst = 0.0;
    for (size_t i = 0; i < count; i++) {
        assert_true(isfinite(found->asymmetry[i]));
        if ((double)expected->energy[i] > least) {
            worst = double_max(worst,
                               fabs((double)found->asymmetry[i] - (double)expected->asymmetry[i]));
        }
    }
    return worst;
}

static double difference_of_books(const air_ordinates_books *found,
                                  const air_ordinates_books *expected)
{
    double worst = double_max(fabs(found->absorbed - expected->absorbed),
                              fabs(found->residual - expected->residual));
    for (int i = 0; i < 6; i++) {
        worst = double_max(worst, fabs(found->out[i] - expected->out[i]));
    }
    assert_true(fabs(found->in - expected->in) <= 1e-6 * expected->in);
    assert_int_equal(found->steps, expected->steps);
    return worst / expected->in;
}

/* Fast shares are off by 3.5e-5 at the front and behind, sides by half of it, 1.4e-4 of a cell's
 * light in a step; 12 steps and what they add up to: 1.7e-3 of the brightest cell, the light seen
 * likewise. Means: moments off by 2.6e-5 of the light of a bright neighbour, against a hundredth of
 * the brightest: 3e-3 a step, and half of what came before; 6e-3. Random media stay well within. */
static void all_sets_give_what_the_plain_version_gives(void **state)
{
    double worst[6] = {0.0};
    (void)state;
    for (int i = 0; i < SIZES * 2 * 2 * 3; i++) {
        const size_t *const size = sizes[i % SIZES];
        ordinates_medium medium = ordinates_random(size[0], size[1], size[2], (uint32_t)i);
        air_ordinates_params params = ordinates_params((air_ordinates_stencil)(i / SIZES % 2),
                                                       (air_ordinates_decay)(i / SIZES / 2 % 2),
                                                       (air_ordinates_start)(i / SIZES / 4), STEPS);
        params.lobe = i % 3 == 0 ? 0.8f : 1.0f;
        medium.entry[0] = 1.0f;
        ordinates_outcome plain = ordinates_run_all(contexts[0], &medium, &params, 0);
        for (int level = 1; level < ORDINATES_LEVELS && contexts[level] != NULL; level++) {
            ordinates_outcome found = ordinates_run_all(contexts[level], &medium, &params, 0);
            const double off[6] = {difference(found.fluence, plain.fluence, medium.count),
                                   difference(found.seen, plain.seen, medium.count),
                                   difference(found.beam, plain.beam, medium.count),
                                   difference(found.energy, plain.energy, medium.count),
                                   difference_of_means(&found, &plain, medium.count),
                                   difference_of_books(&found.books, &plain.books)};
            for (int k = 0; k < 6; k++) {
                worst[k] = double_max(worst[k], off[k]);
            }
            ordinates_outcome_free(&found);
        }
        ordinates_outcome_free(&plain);
        ordinates_medium_free(&medium);
    }
    print_message("fluence %.1e, seen %.1e, beam %.1e, energy %.1e, mean %.1e, books %.1e\n",
                  worst[0], worst[1], worst[2], worst[3], worst[4], worst[5]);
    assert_true(worst[0] < 1.7e-3 && worst[1] < 1.7e-3 && worst[3] < 1.7e-3);
    assert_true(worst[2] < 1e-5); /* 12 cells' transmittances of 3e-7 */
    assert_true(worst[4] < 6e-3);
    assert_true(worst[5] < 1.7e-3);
}

/* The goal of floats; a sum of a few hundred roundings of 6e-8 of what each cell has. */
static void books_balance_in_floats(void **state)
{
    double worst = 0.0;
    (void)state;
    for (int i = 0; i < SIZES * 2 * 2; i++) {
        const size_t *const size = sizes[i % SIZES];
        ordinates_medium medium = ordinates_random(size[0], size[1], size[2], (uint32_t)(90 + i));
        const air_ordinates_params params =
            ordinates_params((air_ordinates_stencil)(i / SIZES % 2), AIR_ORDINATES_DECAY_POISSON,
                             (air_ordinates_start)(i / SIZES / 2), 300);
        medium.entry[0] = 1.0f;
        for (int level = 1; level < ORDINATES_LEVELS && contexts[level] != NULL; level++) {
            ordinates_outcome found = ordinates_run_all(contexts[level], &medium, &params, 0);
            worst = double_max(worst, ordinates_imbalance(&found.books));
            ordinates_outcome_free(&found);
        }
        ordinates_medium_free(&medium);
    }
    print_message("imbalance %.1e\n", worst);
    assert_true(worst <= 1e-5);
}

/* Only what is asked for is written, and what is left out changes nothing. */
static void results_do_not_depend_on_what_else_is_wanted(void **state)
{
    ordinates_medium medium = ordinates_random(20, 9, 7, 5);
    air_ordinates_params params;
    float *const alone = ordinates_floats(medium.count, NAN);
    (void)state;
    air_ordinates_params_default(&params);
    for (int level = 1; level < ORDINATES_LEVELS && contexts[level] != NULL; level++) {
        ordinates_outcome all = ordinates_run_all(contexts[level], &medium, &params, 0);
        void *const scratch =
            aligned_alloc(64, (air_ordinates_scratch(&medium.cells, &params) + 63) / 64 * 64);
        for (int i = 0; i < 3; i++) {
            const air_ordinates_results results = {.fluence = i == 0 ? alone : NULL,
                                                   .view_cosine = medium.view_cosine,
                                                   .seen = i == 1 ? alone : NULL,
                                                   .energy = i == 2 ? alone : NULL};
            const float *const expected = i == 0 ? all.fluence : i == 1 ? all.seen : all.energy;
            assert_int_equal(
                air_ordinates_run(contexts[level], &medium.cells, &params, scratch, &results),
                AIR_OK);
            assert_memory_equal(alone, expected, medium.count * sizeof *alone);
        }
        free(scratch);
        ordinates_outcome_free(&all);
    }
    free(alone);
    ordinates_medium_free(&medium);
}

/* The residual falls by some percent in a step: floats may end a step earlier or later. */
static void runs_end_at_the_residual(void **state)
{
    ordinates_medium cube = ordinates_cube(12);
    (void)state;
    for (int stencil = 0; stencil < 2; stencil++) {
        air_ordinates_params params;
        air_ordinates_params_default(&params);
        params.stencil = (air_ordinates_stencil)stencil;
        params.steps = 2000;
        params.residual = 0.01;
        ordinates_outcome plain = ordinates_run_all(contexts[0], &cube, &params, 0);
        assert_true(plain.books.steps < 2000 && plain.books.residual <= 0.01 * plain.books.in);
        for (int level = 1; level < ORDINATES_LEVELS && contexts[level] != NULL; level++) {
            ordinates_outcome found = ordinates_run_all(contexts[level], &cube, &params, 0);
            assert_true(abs((int)found.books.steps - (int)plain.books.steps) <= 1);
            assert_true(found.books.residual <= 0.01 * found.books.in);
            ordinates_outcome_free(&found);
        }
        ordinates_outcome_free(&plain);
    }
    ordinates_medium_free(&cube);
}

/* The shares of the plain version's values to 2e-3 hold for light of any brightness, and media from
 * clear to opaque leave numbers. */
static void extremes_leave_numbers(void **state)
{
    static const float sigmas[7] = {0.0f, 1e-30f, 1e-6f, 1.0f, 1e3f, 1e20f, 3e38f};
    (void)state;
    for (int i = 0; i < 7 * 7 * 2; i++) {
        ordinates_medium medium = ordinates_even(5, 4, 6, sigmas[i % 7], sigmas[i / 7 % 7], 0.9f);
        const float bright = i % 3 == 0 ? 1e-30f : i % 3 == 1 ? 1.0f : 1e30f;
        air_ordinates_params params;
        air_ordinates_params_default(&params);
        params.stencil = (air_ordinates_stencil)(i / 49);
        for (int k = 0; k < 20; k++) {
            medium.entry[k] *= bright;
        }
        ordinates_outcome plain = ordinates_run_all(contexts[0], &medium, &params, 0);
        for (int level = 1; level < ORDINATES_LEVELS && contexts[level] != NULL; level++) {
            ordinates_outcome found = ordinates_run_all(contexts[level], &medium, &params, 0);
            for (size_t k = 0; k < medium.count; k++) {
                const float sum = plain.fluence[k] + plain.beam[k];
                const float off = found.fluence[k] + found.beam[k] - sum;
                assert_true(isfinite(found.seen[k]) && isfinite(found.asymmetry[k]));
                assert_true(fabsf(off) <= 2e-3f * sum + 1e-6f * bright);
            }
            assert_true(ordinates_imbalance(&found.books) <= 1e-5);
            ordinates_outcome_free(&found);
        }
        ordinates_outcome_free(&plain);
        ordinates_medium_free(&medium);
    }
}

/* Bins and six lobes are the plain version's whatever the set. */
static void what_lanes_lack_is_plain(void **state)
{
    ordinates_medium medium = ordinates_random(9, 5, 6, 8);
    (void)state;
    for (int i = 0; i < 2; i++) {
        air_ordinates_params params;
        air_ordinates_params_default(&params);
        params.stencil = i == 0 ? AIR_ORDINATES_SIX : AIR_ORDINATES_CM;
        ordinates_outcome plain = ordinates_run_all(contexts[0], &medium, &params, 3);
        for (int level = 1; level < ORDINATES_LEVELS && contexts[level] != NULL; level++) {
            ordinates_outcome found = ordinates_run_all(contexts[level], &medium, &params, 3);
            assert_memory_equal(found.fluence, plain.fluence, medium.count * sizeof(float));
            assert_memory_equal(found.binned, plain.binned, 3 * medium.count * sizeof(float));
            ordinates_outcome_free(&found);
        }
        ordinates_outcome_free(&plain);
    }
    ordinates_medium_free(&medium);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_sets_give_what_the_plain_version_gives),
        cmocka_unit_test(books_balance_in_floats),
        cmocka_unit_test(results_do_not_depend_on_what_else_is_wanted),
        cmocka_unit_test(runs_end_at_the_residual),
        cmocka_unit_test(extremes_leave_numbers),
        cmocka_unit_test(what_lanes_lack_is_plain),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
