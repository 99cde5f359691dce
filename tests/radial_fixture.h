/* radial_fixture.h: arrays for radial grids of up to 32 shells of 32 x 32, and runs that fill all
 * of them. */
#ifndef AIR_TESTS_RADIAL_FIXTURE_H
#define AIR_TESTS_RADIAL_FIXTURE_H

#include <math.h>
#include <stdlib.h>

#include "airlight/ordinates_radial.h"
#include "cmocka_test.h"
#include "core/vec.h"

enum { N_MOST = 32, K_MOST = 32, CELLS_MOST = N_MOST * N_MOST * K_MOST, BINS = 20 };

static float sigma_s[CELLS_MOST], sigma_a[CELLS_MOST], g[CELLS_MOST];
static float fluence[CELLS_MOST], beam[CELLS_MOST], seen[CELLS_MOST], view[CELLS_MOST];
static float energy[CELLS_MOST], asymmetry[CELLS_MOST];
static float binned[CELLS_MOST * BINS], intensity[N_MOST * N_MOST];
static double omega[N_MOST * N_MOST];
static air_radial_books books;
static void *scratch;
static bool without_directions; /* neither seen nor binned: faster */

/* The same everywhere, R = 2.5; fills omega too. */
static air_radial_cells uniform(uint32_t n, uint32_t shells, float s, float a, float mean)
{
    const air_radial_grid grid = {.directions = n, .shells = shells, .radius_m = 2.5f};
    for (size_t i = 0; i < (size_t)n * n * shells; i++) {
        sigma_s[i] = s;
        sigma_a[i] = a;
        g[i] = mean;
    }
    air_radial_solid_angles(n, omega);
    return (air_radial_cells){.grid = grid, .sigma_s = sigma_s, .sigma_a = sigma_a, .g = g};
}

static void run(const air_radial_cells *cells, const air_radial_light *light,
                const air_radial_params *params)
{
    const air_radial_results results = {.fluence = fluence,
                                        .beam = beam,
                                        .view_cosine = view,
                                        .seen = without_directions ? NULL : seen,
                                        .bins = BINS,
                                        .binned = without_directions ? NULL : binned,
                                        .energy = energy,
                                        .asymmetry = asymmetry,
                                        .books = &books};
    scratch = realloc(scratch, air_radial_scratch(&cells->grid));
    assert_non_null(scratch);
    assert_int_equal(air_radial_run(NULL, cells, light, params, scratch, &results), AIR_OK);
}

static air_radial_params defaults(void)
{
    air_radial_params params;
    air_radial_params_default(&params);
    return params;
}

/* Of the group. */
static int tear_down(void **state)
{
    (void)state;
    free(scratch);
    return 0;
}

#endif
