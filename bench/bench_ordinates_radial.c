/* Radial grids: time of 40 steps of 32 x 32 x 32 cells by stencil and lateral exchange, and ns for
 * a look-up.
 *
 * Processor time, the least of many rounds, versions in turn; beside it a calibration kernel of
 * this run, one multiplication and one addition that wait for each other. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "airlight/ordinates_radial.h"
#include "core/random.h"

enum { N = 32, K = 32, CELLS = N * N * K, STEPS = 40, ROUNDS = 20, POINTS = 1 << 16, VERSIONS = 4 };

static float sigma_s[CELLS], sigma_a[CELLS], clear[CELLS], g[CELLS], fluence[CELLS];
static float x[POINTS], y[POINTS], z[POINTS], out[POINTS];

typedef struct version {
    const char *name;
    air_ordinates_stencil stencil;
    air_radial_lateral lateral;
    const float *sigma_a;
    double least;
} version;

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double calibrate(void)
{
    const double before = seconds();
    volatile double start = 0.7;
    double value = start;
    for (int i = 0; i < POINTS; i++) {
        value = value * 0.5 + 1.0;
    }
    start = value;
    return (seconds() - before) / POINTS;
}

static void fill(void)
{
    air_rng rng = air_rng_from_keys(12, 5);
    for (int i = 0; i < CELLS; i++) {
        sigma_s[i] = 2.0f * (float)(air_rng_next(&rng) * 0x1p-32);
        sigma_a[i] = 0.1f;
        g[i] = 0.7f;
    }
    for (int i = 0; i < POINTS; i++) {
        x[i] = 5.0f * (float)(air_rng_next(&rng) * 0x1p-32) - 2.5f;
        y[i] = 5.0f * (float)(air_rng_next(&rng) * 0x1p-32) - 2.5f;
        z[i] = 5.0f * (float)(air_rng_next(&rng) * 0x1p-32) - 2.5f;
    }
}

static double run(const air_radial_grid *grid, const version *self, void *scratch)
{
    const air_radial_cells cells = {
        .grid = *grid, .sigma_s = sigma_s, .sigma_a = self->sigma_a, .g = g};
    const air_radial_results results = {.fluence = fluence};
    air_radial_params params;
    air_radial_params_default(&params);
    params.stencil = self->stencil;
    params.lateral = self->lateral;
    params.steps = STEPS;
    params.residual = 0.0;
    const double before = seconds();
    if (air_radial_run(NULL, &cells, NULL, &params, scratch, &results) != AIR_OK) {
        return INFINITY;
    }
    return seconds() - before;
}

int main(void)
{
    const air_radial_grid grid = {.directions = N, .shells = K, .radius_m = 2.5f};
    version versions[VERSIONS] = {
        {"literal, sides", AIR_ORDINATES_LITERAL, AIR_RADIAL_SIDES, clear, INFINITY},
        {"cm, sides", AIR_ORDINATES_CM, AIR_RADIAL_SIDES, clear, INFINITY},
        {"cm, spread", AIR_ORDINATES_CM, AIR_RADIAL_SPREAD, clear, INFINITY},
        {"cm, spread, absorbing", AIR_ORDINATES_CM, AIR_RADIAL_SPREAD, sigma_a, INFINITY}};
    double calibration = INFINITY, look_up = INFINITY;
    void *const scratch = malloc(air_radial_scratch(&grid));
    if (scratch == NULL) {
        return 1;
    }
    fill();
    for (int round = 0; round < ROUNDS; round++) {
        calibration = fmin(calibration, calibrate());
        for (int i = 0; i < VERSIONS; i++) {
            versions[i].least = fmin(versions[i].least, run(&grid, &versions[i], scratch));
        }
        const double before = seconds();
        air_radial_look_up(&grid, fluence, POINTS, x, y, z, out);
        look_up = fmin(look_up, (seconds() - before) / POINTS);
    }
    printf("calibration %.2f ns\n", 1e9 * calibration);
    for (int i = 0; i < VERSIONS; i++) {
        printf("%-22s %6.1f ms, %5.1f ns per cell and step\n", versions[i].name,
               1e3 * versions[i].least, 1e9 * versions[i].least / ((double)CELLS * STEPS));
    }
    printf("look-up %.1f ns\n", 1e9 * look_up);
    free(scratch);
    return 0;
}
