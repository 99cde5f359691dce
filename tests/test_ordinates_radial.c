/* Light carried through radial grids: books, symmetry, the beam, directions, arguments. */
#include <string.h>

#include "radial_fixture.h"

static float visibility[CELLS_MOST];

/* Any but regular. */
static float scramble(uint32_t i) { return (float)(i * 2654435761u) * 0x1p-32f; }

static air_radial_cells rugged(uint32_t n, uint32_t shells)
{
    const air_radial_cells cells = uniform(n, shells, 0.0f, 0.0f, 0.0f);
    for (uint32_t i = 0; i < n * n * shells; i++) {
        sigma_s[i] = 3.0f * scramble(3 * i);
        sigma_a[i] = scramble(3 * i + 1);
        g[i] = 1.8f * scramble(3 * i + 2) - 0.9f;
        visibility[i] = scramble(i + 7);
    }
    return cells;
}

static double imbalance(void)
{
    return fabs(books.in - books.out - books.absorbed - books.hidden - books.residual) / books.in;
}

static void the_books_balance(void **state)
{
    (void)state;
    for (int variant = 0; variant < 24; variant++) {
        air_radial_params params = defaults();
        params.stencil = variant % 3 == 0 ? AIR_ORDINATES_LITERAL : AIR_ORDINATES_CM;
        params.lateral = variant % 3 == 1 ? AIR_RADIAL_SPREAD : AIR_RADIAL_SIDES;
        params.start = variant / 3 % 2 == 0 ? AIR_ORDINATES_FIRST_SCATTER : AIR_ORDINATES_BOUNDARY;
        params.decay =
            variant / 6 % 2 == 0 ? AIR_ORDINATES_DECAY_POISSON : AIR_ORDINATES_DECAY_PAPER;
        params.curvature = variant / 12 == 0;
        params.steps = 30;
        const air_radial_cells cells = rugged(variant % 2 == 0 ? 8 : 12, 9);
        for (uint32_t i = 0; i < N_MOST * N_MOST; i++) {
            intensity[i] = scramble(i) > 0.6f ? 5.0f * scramble(i + 99) : 0.0f;
        }
        const air_radial_light light = {
            .intensity = intensity, .visibility = visibility, .lobe = 0.8f};
        run(&cells, &light, &params);
        double in = 0.0, left = 0.0;
        for (uint32_t c = 0; c < cells.grid.directions * cells.grid.directions; c++) {
            in += (double)intensity[c] * omega[c];
        }
        for (size_t i = 0; i < 9u * cells.grid.directions * cells.grid.directions; i++) {
            assert_true(energy[i] >= 0.0f && fabsf(asymmetry[i]) <= 1.0f);
            assert_true(fluence[i] >= 0.0f && beam[i] >= 0.0f);
            left += (double)energy[i];
        }
        assert_true(fabs(books.in / in - 1.0) < 1e-14);
        assert_true(imbalance() < 1e-12); /* 30 steps of 1e3 cells, each rounding to 1e-16 */
        assert_true(fabs(left - books.residual) < 1e-6 * books.residual); /* floats */
        assert_true(books.hidden > 0.0 && books.absorbed > 0.0 && books.out > 0.0);
    }
}

/* Radial media and lights keep all directions alike, whatever their cells' sizes. */
static void spherical_symmetry_is_kept(void **state)
{
    (void)state;
    for (int variant = 0; variant < 3; variant++) {
        air_radial_params params = defaults();
        params.stencil = variant == 2 ? AIR_ORDINATES_LITERAL : AIR_ORDINATES_CM;
        params.lateral = variant == 0 ? AIR_RADIAL_SPREAD : AIR_RADIAL_SIDES;
        const air_radial_cells cells = uniform(16, 17, 0.0f, 0.0f, 0.0f);
        for (uint32_t i = 0; i < 16 * 16 * 17; i++) {
            sigma_s[i] = 4.0f * scramble(i / 256);
            sigma_a[i] = 0.3f * scramble(i / 256 + 50);
            g[i] = 0.9f * scramble(i / 256 + 100);
        }
        run(&cells, NULL, &params);
        for (size_t i = 0; i < 16 * 16 * 17; i++) {
            /* The doubles agree to 1e-14; floats are off by half of 2^-23 each. */
            assert_true(fabsf(fluence[i] / fluence[i / 256 * 256] - 1.0f) < 3e-7f);
            assert_true(fabsf(beam[i] / beam[i / 256 * 256] - 1.0f) < 3e-7f);
        }
    }
}

static void without_a_medium_the_beam_falls_with_the_square(void **state)
{
    const air_radial_params params = defaults();
    const air_radial_cells cells = uniform(8, 10, 0.0f, 0.0f, 0.5f);
    (void)state;
    run(&cells, NULL, &params);
    assert_true(fabs(books.in / (4.0 * AIR_PI) - 1.0) < 1e-14);
    assert_true(fabs(books.out - books.in) < 1e-14 * books.in && books.steps == 0);
    for (uint32_t k = 0; k < 10; k++) {
        const double inner = air_radial_radius(&cells.grid, k);
        const double outer = air_radial_radius(&cells.grid, k + 1);
        /* The mean of 1/r^2 over the shell's volume. */
        const double exact = 3.0 / (inner * inner + inner * outer + outer * outer);
        assert_true(fabs((double)beam[k * 64] / exact - 1.0) < 1e-7);
        assert_true(fluence[k * 64] == 0.0f);
    }
}

static void the_beam_is_attenuated_and_surfaces_hide_it(void **state)
{
    const air_radial_params params = defaults();
    const air_radial_cells cells = uniform(8, 10, 0.7f, 0.4f, 0.3f);
    const uint32_t wall = 6, cell = 19;
    (void)state;
    for (uint32_t i = 0; i < 640; i++) {
        visibility[i] = i % 64 == cell && i / 64 >= wall ? 0.0f : 1.0f;
    }
    const air_radial_light light = {.visibility = visibility, .lobe = 1.0f};
    run(&cells, &light, &params);
    const double r = air_radial_radius(&cells.grid, wall), sigma_t = (double)0.7f + (double)0.4f;
    assert_true(fabs(books.hidden / (omega[cell] * exp(-sigma_t * r)) - 1.0) < 1e-13);
    assert_true(imbalance() < 1e-12);
    for (uint32_t i = 0; i < 640; i++) {
        const double inner = air_radial_radius(&cells.grid, i / 64);
        const double outer = air_radial_radius(&cells.grid, i / 64 + 1);
        const double volume = air_radial_volume(&cells.grid, i / 64, 1.0);
        const double exact = (exp(-sigma_t * inner) - exp(-sigma_t * outer)) / (sigma_t * volume);
        const bool hidden = visibility[i] == 0.0f;
        assert_true(hidden ? beam[i] == 0.0f : fabs((double)beam[i] / exact - 1.0) < 1e-6);
    }
    /* Scattered light comes round the wall, but less than beside it. */
    const uint32_t behind = 8 * 64 + cell;
    assert_true(fluence[behind] > 0.0f && fluence[behind] < fluence[behind + 1]);
}

/* Bins and what is seen are the fluence, shared out: to floats' rounding in each of the steps. */
static void directions_add_up_to_the_fluence(void **state)
{
    const air_radial_params params = defaults();
    const air_radial_cells cells = uniform(8, 10, 1.5f, 0.1f, 0.0f);
    (void)state;
    for (uint32_t i = 0; i < 640; i++) {
        view[i] = 2.0f * scramble(i) - 1.0f;
    }
    run(&cells, NULL, &params);
    for (size_t i = 0; i < 640; i++) {
        double sum = 0.0;
        for (size_t b = 0; b < BINS; b++) {
            sum += (double)binned[i * BINS + b];
        }
        assert_true(fabs(sum / (double)fluence[i] - 1.0) < 1e-5);
        /* g = 0: the same towards all observers */
        const double all = ((double)fluence[i] + (double)beam[i]) / (4.0 * AIR_PI);
        assert_true(fabs((double)seen[i] / all - 1.0) < 3e-7);
    }
}

/* Over the directions to the observer, on a rule that integrates the cosine exactly, the phase
 * function is normalised and its mean cosine is a g: forward light is seen from ahead. */
static void forward_light_is_seen_from_ahead(void **state)
{
    const air_radial_params params = defaults();
    const air_radial_cells cells = uniform(8, 10, 1.0f, 0.0f, 0.6f);
    double sum = 0.0, ahead = 0.0, behind = 0.0;
    (void)state;
    for (int step = 0; step < 200; step++) {
        for (uint32_t i = 0; i < 640; i++) {
            view[i] = (float)((step + 0.5) / 100.0 - 1.0);
        }
        run(&cells, NULL, &params);
        sum += 4.0 * AIR_PI / 200.0 * (double)seen[300];
        *(step < 100 ? &behind : &ahead) += (double)seen[300];
    }
    /* Midpoints, 200 of them: h^2/24 of the peak's second derivative, for a g = 0.6 below 3e-4. */
    assert_true(fabs(sum / ((double)fluence[300] + (double)beam[300]) - 1.0) < 1e-3);
    assert_true(ahead > 2.0 * behind);
}

/* ---- arguments ---- */

static air_status try_with(const air_radial_cells *cells, const air_radial_light *light,
                           const air_radial_params *params, const air_radial_results *results)
{
    fluence[0] = -7.0f;
    const air_status status = air_radial_run(NULL, cells, light, params, scratch, results);
    assert_true(status == AIR_OK || fluence[0] == -7.0f);
    return status;
}

static void bad_parameters_are_refused(void **state)
{
    const air_radial_cells cells = uniform(8, 10, 1.0f, 0.0f, 0.5f);
    const air_radial_results results = {.fluence = fluence};
    (void)state;
    scratch = realloc(scratch, air_radial_scratch(&cells.grid));
    for (int fault = 0; fault < 9; fault++) {
        air_radial_params params = defaults();
        switch (fault) {
        case 0:
            params.stencil = AIR_ORDINATES_SIX;
            break;
        case 1:
            params.stencil = AIR_ORDINATES_LITERAL;
            break; /* with SPREAD */
        case 2:
            params.start = AIR_ORDINATES_ALL_CELLS;
            break;
        case 3:
            params.decay = (air_ordinates_decay)7;
            break;
        case 4:
            params.lateral = (air_radial_lateral)7;
            break;
        case 5:
            params.steps = 0;
            break;
        case 6:
            params.steps = AIR_ORDINATES_STEPS_MAX + 1;
            break;
        case 7:
            params.residual = -1.0;
            break;
        default:
            params.residual = NAN;
            break;
        }
        assert_int_equal(try_with(&cells, NULL, &params, &results), AIR_ERROR_ARGUMENT);
    }
    const air_radial_params params = defaults();
    assert_int_equal(try_with(&cells, NULL, &params, &results), AIR_OK);
}

static void bad_grids_coefficients_and_lights_are_refused(void **state)
{
    static const float bad[][2] = {{0, -1.0f}, {0, INFINITY}, {1, NAN}, {2, 1.0f}, {2, -1.0f}};
    static const air_radial_grid grids[] = {{7, 10, 1.0f}, {2, 10, 1.0f},  {130, 10, 1.0f},
                                            {8, 1, 1.0f},  {8, 257, 1.0f}, {8, 10, 0.0f},
                                            {8, 10, NAN},  {4, 44, 1.0f}};
    const air_radial_params params = defaults();
    const air_radial_results results = {.fluence = fluence};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const air_radial_cells cells = uniform(8, 10, 1.0f, 0.0f, 0.5f);
        *(bad[i][0] == 0 ? &sigma_s[77] : bad[i][0] == 1 ? &sigma_a[77] : &g[77]) = bad[i][1];
        assert_int_equal(try_with(&cells, NULL, &params, &results), AIR_ERROR_ARGUMENT);
    }
    air_radial_cells cells = uniform(8, 10, 1.0f, 0.0f, 0.5f);
    for (size_t i = 0; i < sizeof grids / sizeof *grids; i++) {
        cells.grid = grids[i];
        assert_int_equal(try_with(&cells, NULL, &params, &results), AIR_ERROR_ARGUMENT);
        assert_int_equal(air_radial_scratch(&grids[i]), 0);
    }
    cells = uniform(8, 10, 1.0f, 0.0f, 0.5f);
    memset(intensity, 0, sizeof intensity);
    intensity[5] = -1.0f;
    visibility[9] = 1.5f;
    const air_radial_light lights[] = {
        {.intensity = intensity, .lobe = 1.0f}, {.visibility = visibility}, {.lobe = 1.5f}};
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(try_with(&cells, &lights[i], &params, &results), AIR_ERROR_ARGUMENT);
    }
    const air_radial_results blind = {.fluence = fluence, .seen = seen};
    assert_int_equal(try_with(&cells, NULL, &params, &blind), AIR_ERROR_ARGUMENT);
    const air_radial_results binless = {.fluence = fluence, .binned = binned};
    assert_int_equal(try_with(&cells, NULL, &params, &binless), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_radial_run(NULL, &cells, NULL, &params, NULL, &results),
                     AIR_ERROR_ARGUMENT);
}

/* No light, a medium that nothing leaves, the thickest numbers: no NaN, books in order. */
static void extremes_stay_finite(void **state)
{
    const air_radial_params params = defaults();
    (void)state;
    air_radial_cells cells = uniform(4, 2, 1e30f, 1e30f, -0.9999999f);
    run(&cells, NULL, &params);
    assert_true(imbalance() < 1e-12);
    cells = uniform(6, 3, 1e6f, 0.0f, 0.9999999f);
    run(&cells, NULL, &params);
    assert_true(imbalance() < 1e-12);
    for (int i = 0; i < 36 * 3; i++) {
        assert_true(isfinite(fluence[i]) && isfinite(seen[i]) && isfinite(binned[i]));
    }
    memset(intensity, 0, sizeof intensity);
    const air_radial_light dark = {.intensity = intensity, .lobe = 1.0f};
    run(&cells, &dark, &params);
    assert_true(books.in == 0.0 && books.out == 0.0 && fluence[5] == 0.0f && asymmetry[5] == 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_books_balance),
        cmocka_unit_test(spherical_symmetry_is_kept),
        cmocka_unit_test(without_a_medium_the_beam_falls_with_the_square),
        cmocka_unit_test(the_beam_is_attenuated_and_surfaces_hide_it),
        cmocka_unit_test(directions_add_up_to_the_fluence),
        cmocka_unit_test(forward_light_is_seen_from_ahead),
        cmocka_unit_test(bad_parameters_are_refused),
        cmocka_unit_test(bad_grids_coefficients_and_lights_are_refused),
        cmocka_unit_test(extremes_stay_finite),
    };
    return cmocka_run_group_tests(tests, NULL, tear_down);
}
