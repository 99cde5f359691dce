/* Optical depths between points, and point lights in boxes of cells. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_beam.h"
#include "cmocka_test.h"
#include "core/vec.h"
#include "random_geometry.h"

enum { CHANNELS = 4, X = 5, Y = 4, Z = 3, CELLS = X * Y * Z };

static const double edges[3] = {0.2, 0.5, 0.25};
static const size_t sizes[3] = {X, Y, Z};

/* Every cell and channel its own. */
static air_beam_box random_box(float extinction[CELLS * CHANNELS])
{
    air_rng rng = air_rng_from_keys(8, 1);
    air_beam_box box = {{X, Y, Z}, {0.2f, 0.5f, 0.25f}, extinction};
    for (size_t i = 0; i < CELLS * CHANNELS; i++) {
        extinction[i] = (float)random_between(&rng, 0.1, 4.0);
    }
    return box;
}

/* Where the segment is inside a box, as shares of it: its length, 0 if nowhere. */
static double inside(const double from[3], const double dir[3], const double low[3],
                     const double high[3])
{
    double t0 = 0.0, t1 = 1.0;
    for (int k = 0; k < 3; k++) {
        if (dir[k] == 0.0) {
            t1 = from[k] < low[k] || from[k] > high[k] ? -1.0 : t1;
        } else {
            const double a = (low[k] - from[k]) / dir[k], b = (high[k] - from[k]) / dir[k];
            t0 = fmax(t0, fmin(a, b));
            t1 = fmin(t1, fmax(a, b));
        }
    }
    return fmax(t1 - t0, 0.0);
}

/* The sum over all cells of extinction times chord. */
static double expected_depth(const float *extinction, const float from[3], const float to[3],
                             size_t channel)
{
    double start[3], dir[3], square = 0.0, sum = 0.0;
    for (int k = 0; k < 3; k++) {
        start[k] = (double)from[k];
        dir[k] = (double)to[k] - start[k];
        square += dir[k] * dir[k];
    }
    for (size_t cell = 0; cell < CELLS; cell++) {
        const size_t at[3] = {cell % X, cell / X % Y, cell / X / Y};
        double low[3], high[3];
        for (int k = 0; k < 3; k++) {
            low[k] = (double)at[k] * edges[k];
            high[k] = ((double)at[k] + 1.0) * edges[k];
        }
        sum += (double)extinction[cell * CHANNELS + channel] * inside(start, dir, low, high);
    }
    return sum * sqrt(square);
}

static void random_point(air_rng *rng, double reach, float out[3])
{
    for (int k = 0; k < 3; k++) {
        const double side = (double)sizes[k] * edges[k];
        out[k] = (float)(side * random_between(rng, -reach, 1.0 + reach));
    }
}

/* ---- depths ---- */

/* Distances up to 6 m as shares of a segment in float: 2^-24 of them at each crossing, times
 * extinctions up to 4. */
static void depths_are_sums_of_chords(void **state)
{
    (void)state;
    float extinction[CELLS * CHANNELS];
    const air_beam_box box = random_box(extinction);
    air_rng rng = air_rng_from_keys(2, 3);
    for (int n = 0; n < 3000; n++) {
        float from[3], to[3], depth[CHANNELS];
        random_point(&rng, n % 3 == 0 ? 0.0 : 1.0, from);
        random_point(&rng, n % 2 == 0 ? 0.0 : 1.0, to);
        if (n % 5 == 0) { /* along an axis */
            to[n % 3] = from[n % 3];
            to[(n + 1) % 3] = from[(n + 1) % 3];
        }
        air_beam_depth(&box, from, to, depth);
        for (size_t c = 0; c < CHANNELS; c++) {
            const double expected = expected_depth(extinction, from, to, c);
            if (!(fabs((double)depth[c] - expected) < 1e-5)) {
                fail_msg("segment %d: %g, expected %g", n, (double)depth[c], expected);
            }
        }
    }
}

static void assert_depth(const air_beam_box *box, const float from[3], const float to[3],
                         double expected)
{
    float depth[CHANNELS], back[CHANNELS];
    air_beam_depth(box, from, to, depth);
    air_beam_depth(box, to, from, back);
    for (size_t c = 0; c < CHANNELS; c++) {
        /* places as shares of up to 30 m */
        if (!(fabs((double)depth[c] - expected) < 4e-6 &&
              fabs((double)back[c] - expected) < 4e-6)) {
            fail_msg("(%g, %g, %g) to (%g, %g, %g): %.8g and %.8g back, expected %.8g",
                     (double)from[0], (double)from[1], (double)from[2], (double)to[0],
                     (double)to[1], (double)to[2], (double)depth[c], (double)back[c], expected);
        }
    }
}

/* In a box that is alike everywhere it does not matter which side of a plane counts: on planes, on
 * edges, through corners, on the box's faces. What only touches the box has nothing. */
static void planes_edges_and_corners_are_crossed_once(void **state)
{
    (void)state;
    float extinction[CELLS * CHANNELS];
    const air_beam_box box = {{X, Y, Z}, {0.25f, 0.5f, 0.125f}, extinction}; /* to 1.25, 2, .375 */
    for (size_t i = 0; i < CELLS * CHANNELS; i++) {
        extinction[i] = 2.0f;
    }
    assert_depth(&box, (float[3]){-1, 0.5f, 0.125f}, (float[3]){3, 0.5f, 0.125f}, 2.5);
    assert_depth(&box, (float[3]){0.25f, 0.5f, -1}, (float[3]){0.25f, 0.5f, 1}, 0.75);
    assert_depth(&box, (float[3]){-1, 0, 0}, (float[3]){3, 0, 0}, 2.5);
    assert_depth(&box, (float[3]){-1, 2, 0.375f}, (float[3]){3, 2, 0.375f}, 2.5);
    assert_depth(&box, (float[3]){0.25f, 1, -1}, (float[3]){0.75f, 1, 1}, 0.75 * sqrt(1.0625));
    assert_depth(&box, (float[3]){0, 0, 0}, (float[3]){1.25f, 2.0f, 0.375f},
                 2.0 * sqrt(1.5625 + 4.0 + 0.140625));
    assert_depth(&box, (float[3]){-0.25f, -0.5f, 0.25f}, (float[3]){1, 2, 0.25f},
                 2.0 * 0.8 * sqrt(1.5625 + 6.25));
    assert_depth(&box, (float[3]){0.5f, 0.5f, 0.125f}, (float[3]){0.5f, 0.5f, 0.125f}, 0.0);
    assert_depth(&box, (float[3]){9, 9, 9}, (float[3]){9, 9, 9}, 0.0);
    assert_depth(&box, (float[3]){-1, 2.001f, 0.1f}, (float[3]){3, 2.001f, 0.1f}, 0.0);
    assert_depth(&box, (float[3]){1.25f, 1, 0.1f}, (float[3]){3, 1, 0.1f}, 0.0);
    assert_depth(&box, (float[3]){-1, 1, 0.1f}, (float[3]){0, 1, 0.1f}, 0.0);
    assert_depth(&box, (float[3]){0.1f, 1, 0.1f}, (float[3]){0.6f, 1, 0.1f}, 1.0);
    assert_depth(&box, (float[3]){0.6f, 1, 0.1f}, (float[3]){30, 1, 0.1f}, 1.3);
    /* On a corner, so near that the way is no longer a normal number. */
    assert_depth(&box, (float[3]){0, 0, 0}, (float[3]){1e-40f, 1e-40f, 0}, 0.0);
}

/* ---- points ---- */

static void transmittances_are_those_of_depths(void **state)
{
    (void)state;
    float extinction[CELLS * CHANNELS], found[CELLS * CHANNELS];
    const air_beam_box box = random_box(extinction);
    air_rng rng = air_rng_from_keys(7, 3);
    for (int n = 0; n < 40; n++) {
        float position[3], center[3];
        random_point(&rng, n % 2 == 0 ? 0.0 : 2.0, position);
        air_beam_point(&box, position, found);
        for (size_t cell = 0; cell < CELLS; cell++) {
            const size_t at[3] = {cell % X, cell / X % Y, cell / X / Y};
            for (int k = 0; k < 3; k++) {
                center[k] = (float)(((double)at[k] + 0.5) * edges[k]);
            }
            for (size_t c = 0; c < CHANNELS; c++) {
                const double depth = expected_depth(extinction, position, center, c);
                assert_true(fabs((double)found[cell * CHANNELS + c] - exp(-depth)) < 1e-5);
            }
        }
    }
}

/* At the centre of a cell there is no way to it. */
static void cells_at_the_light_have_all_of_it(void **state)
{
    (void)state;
    float extinction[CELLS * CHANNELS], found[CELLS * CHANNELS], spread[CELLS];
    const air_beam_box box = random_box(extinction);
    const float position[3] = {0.5f, 0.75f, 0.375f}; /* of cell (2, 1, 1) */
    const size_t cell = (1 * Y + 1) * X + 2;
    air_beam_point(&box, position, found);
    air_beam_spread(&box, position, spread);
    /* 1/r^2 over a ball: 3 / R^2 */
    const double volume = edges[0] * edges[1] * edges[2], radius = cbrt(0.75 / AIR_PI * volume);
    assert_true(fabs((double)spread[cell] * radius * radius / 3.0 - 1.0) < 1e-6);
    for (size_t c = 0; c < CHANNELS; c++) {
        assert_true(found[cell * CHANNELS + c] > 1.0f - 1e-6f);
    }
}

/* ---- the fall-off ---- */

/* Mean of 1/r^2 over a cell as seen from the origin, by Gauss's theorem: 1/r^2 is the divergence of
 * x/r^2, so it is the sum over the faces of h times the integral of 1/r^2 over them; these are
 * smooth but on planes through the point, where h is 0. Midpoints. */
static double mean_inverse_square(const double low[3], const double high[3])
{
    enum { POINTS = 48 };
    double sum = 0.0, volume = 1.0;
    for (int axis = 0; axis < 3; axis++) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const double du = (high[u] - low[u]) / POINTS, dv = (high[v] - low[v]) / POINTS;
        volume *= high[axis] - low[axis];
        for (int side = 0; side < 2; side++) {
            const double h = side == 0 ? -low[axis] : high[axis];
            const double plane = side == 0 ? low[axis] : high[axis];
            for (int n = 0; h != 0.0 && n < POINTS * POINTS; n++) {
                const double a = low[u] + (n % POINTS + 0.5) * du;
                const double b = low[v] + ((double)(n / POINTS) + 0.5) * dv;
                sum += h * du * dv / (a * a + b * b + plane * plane);
            }
        }
    }
    return sum / volume;
}

/* The worst of a box's cells, as a share, and that of the sum over cells. */
static void measure_spread(const air_beam_box *box, const double position[3], double *cell_error,
                           double *sum_error)
{
    const size_t *const n = box->size;
    const size_t cells = n[0] * n[1] * n[2];
    const float at[3] = {(float)position[0], (float)position[1], (float)position[2]};
    float *const found = calloc(cells, sizeof *found);
    double sum = 0.0, expected_sum = 0.0;
    assert_non_null(found);
    air_beam_spread(box, at, found);
    for (size_t cell = 0; cell < cells; cell++) {
        const size_t place[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
        double low[3], high[3];
        for (int k = 0; k < 3; k++) {
            low[k] = (double)place[k] * (double)box->cell_m[k] - position[k];
            high[k] = low[k] + (double)box->cell_m[k];
        }
        const double expected = mean_inverse_square(low, high);
        *cell_error = fmax(*cell_error, fabs((double)found[cell] / expected - 1.0));
        sum += (double)found[cell];
        expected_sum += expected;
    }
    *sum_error = fmax(*sum_error, fabs(sum / expected_sum - 1.0));
    free(found);
}

/* Measured for lights anywhere, and a tenth more. */
static void check_spread(const float cell_m[3], double cell_bound, double sum_bound)
{
    air_beam_box box = {{5, 5, 5}, {cell_m[0], cell_m[1], cell_m[2]}, NULL};
    air_rng rng = air_rng_from_keys(3, 3);
    double cell_error = 0.0, sum_error = 0.0;
    for (int n = 0; n < 24; n++) {
        double position[3];
        for (int k = 0; k < 3; k++) {
            const double side = 5.0 * (double)cell_m[k];
            position[k] = side * random_between(&rng, n % 3 == 0 ? -0.5 : 0.0, 1.0);
        }
        measure_spread(&box, position, &cell_error, &sum_error);
    }
    print_message("cells %g x %g x %g: a cell's mean within %.4f, the box's sum within %.4f\n",
                  (double)cell_m[0], (double)cell_m[1], (double)cell_m[2], cell_error, sum_error);
    assert_true(cell_error < cell_bound);
    assert_true(sum_error < sum_bound);
}

/* A ball has too little of what is near its side: the cells that meet where the light is, a fifth
 * at a corner. Of 5 x 5 x 5 cells the light in or near them gives a tenth too little at worst; of
 * n^3, a part that falls as 1/n. */
static void cubes_are_taken_for_balls(void **state)
{
    (void)state;
    check_spread((float[3]){0.1f, 0.1f, 0.1f}, 0.39, 0.11);
}

static void so_are_longer_cells(void **state)
{
    (void)state;
    check_spread((float[3]){0.1f, 0.15f, 0.2f}, 1.03, 0.18);
}

/* The two forms of the mean meet where they change. */
static void the_fall_off_is_smooth_and_ends_as_the_square(void **state)
{
    (void)state;
    const air_beam_box box = {{1, 1, 1}, {1.0f, 1.0f, 1.0f}, NULL};
    const double radius = cbrt(0.75 / AIR_PI);
    float last = INFINITY;
    for (int n = 0; n <= 4000; n++) {
        const double r = radius * 0.002 * n;
        const float position[3] = {0.5f, 0.5f, 0.5f + (float)r};
        float found;
        air_beam_spread(&box, position, &found);
        assert_true(isfinite(found));
        /* it falls, by rounding of the position up to 2^-23 / r of itself */
        assert_true(found <= last * (1.0f + 2e-6f));
        assert_true(r < 6.0 * radius || fabs((double)found * r * r - 1.0) < 0.2 / 36.0 + 1e-6);
        last = found;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(depths_are_sums_of_chords),
        cmocka_unit_test(planes_edges_and_corners_are_crossed_once),
        cmocka_unit_test(transmittances_are_those_of_depths),
        cmocka_unit_test(cells_at_the_light_have_all_of_it),
        cmocka_unit_test(cubes_are_taken_for_balls),
        cmocka_unit_test(so_are_longer_cells),
        cmocka_unit_test(the_fall_off_is_smooth_and_ends_as_the_square),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
