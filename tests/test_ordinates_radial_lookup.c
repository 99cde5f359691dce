/* Values of radial grids at points. */
#include <math.h>

#include "airlight/ordinates_radial.h"
#include "cmocka_test.h"
#include "core/vec.h"

enum { N = 16, K = 12, CELLS = N * N * K, POINTS = 4000 };

static const air_radial_grid grid = {.directions = N, .shells = K, .radius_m = 3.0f};
static float values[CELLS], x[POINTS], y[POINTS], z[POINTS], out[POINTS];

static double shell_centre(double k)
{
    return 3.0 * pow(1.0 + sqrt(4.0 * AIR_PI) / N, k + 0.5 - K);
}

/* Any but regular. */
static double scramble(uint32_t i) { return (double)(i * 2654435761u) * 0x1p-32; }

static void some_points(void)
{
    for (uint32_t i = 0; i < POINTS; i++) {
        const double cosine = 2.0 * scramble(3 * i) - 1.0, r = 3.3 * scramble(3 * i + 1);
        const double sine = sqrt(1.0 - cosine * cosine), phi = 2.0 * AIR_PI * scramble(3 * i + 2);
        x[i] = (float)(r * sine * cos(phi));
        y[i] = (float)(r * sine * sin(phi));
        z[i] = (float)(r * cosine);
    }
}

static double length_of(size_t i)
{
    return sqrt((double)x[i] * (double)x[i] + (double)y[i] * (double)y[i] +
                (double)z[i] * (double)z[i]);
}

static void centres_of_cells_give_their_values(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < CELLS; i++) {
        values[i] = (float)scramble(i);
    }
    for (uint32_t k = 0; k < K; k++) {
        for (uint32_t c = 0; c < N * N; c++) {
            double d[3];
            air_radial_direction(N, c % N, c / N, d);
            x[c] = (float)(shell_centre(k) * d[0]);
            y[c] = (float)(shell_centre(k) * d[1]);
            z[c] = (float)(shell_centre(k) * d[2]);
        }
        air_radial_look_up(&grid, values, N * N, x, y, z, out);
        for (uint32_t c = 0; c < N * N; c++) {
            /* Coordinates up to n and K/ln rho from floats: 16 * 2^-23 cells off, values differ by
             * up to 1 per cell in each of three axes. */
            assert_true(fabs((double)out[c] - (double)values[k * N * N + c]) < 6e-6);
        }
    }
}

static void a_constant_is_kept_inside_and_nothing_is_outside(void **state)
{
    (void)state;
    some_points();
    for (uint32_t i = 0; i < CELLS; i++) {
        values[i] = 1.0f;
    }
    air_radial_look_up(&grid, values, POINTS, x, y, z, out);
    for (size_t i = 0; i < POINTS; i++) {
        const double r = length_of(i);
        if (fabs(r - 3.0) > 1e-6) { /* floats */
            assert_true(r > 3.0 ? out[i] == 0.0f : fabs((double)out[i] - 1.0) < 1e-6);
        }
    }
}

/* Linear in log r, and in the square's coordinates within one face of the octahedron. */
static void functions_linear_in_the_grids_coordinates_are_exact(void **state)
{
    (void)state;
    some_points();
    for (uint32_t i = 0; i < CELLS; i++) {
        values[i] = (float)(i / (N * N)) + 0.25f * (float)(i % N) - 0.5f * (float)(i / N % N);
    }
    air_radial_look_up(&grid, values, POINTS, x, y, z, out);
    int tried = 0;
    for (size_t i = 0; i < POINTS; i++) {
        const double r = length_of(i);
        const double sum = fabs((double)x[i]) + fabs((double)y[i]) + fabs((double)z[i]);
        const double u = ((double)x[i] / sum + 1.0) * N / 2 - 0.5;
        const double v = ((double)y[i] / sum + 1.0) * N / 2 - 0.5;
        /* The upper faces lie side by side in the square; not beyond its outermost centres. */
        const bool middle =
            double_max(fabs((double)x[i]), fabs((double)y[i])) / sum < 1.0 - 1.0 / N;
        if (r < 2.999 && z[i] > 0.0f && middle) {
            const double shell = log(r / shell_centre(0)) / log(1.0 + sqrt(4.0 * AIR_PI) / N);
            const double exact = double_max(0.0, double_min(K - 1, shell)) + 0.25 * u - 0.5 * v;
            assert_true(fabs((double)out[i] - exact) < 1e-5); /* as above, values up to 20 */
            tried++;
        }
    }
    assert_true(tried > POINTS / 3);
}

static void all_directions_agree_with_the_surrounding_cells(void **state)
{
    (void)state;
    some_points();
    for (uint32_t i = 0; i < CELLS; i++) {
        values[i] = (float)scramble(i % (N * N)); /* the same in all shells */
    }
    air_radial_look_up(&grid, values, POINTS, x, y, z, out);
    for (size_t i = 0; i < POINTS; i++) {
        const double d[3] = {(double)x[i], (double)y[i], (double)z[i]};
        double weights[4], sum = 0.0;
        uint32_t cells[4];
        air_radial_surrounding(N, d, cells, weights);
        for (int c = 0; c < 4; c++) {
            sum += weights[c] * (double)values[cells[c]];
        }
        if (length_of(i) < 2.999) {
            assert_true(fabs((double)out[i] - sum) < 6e-6);
        }
    }
}

static void the_light_itself_and_an_output_in_place_are_legal(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < CELLS; i++) {
        values[i] = i < N * N ? 2.0f : 1.0f;
    }
    float px[2] = {0.0f, 1e-20f}, py[2] = {0.0f, 0.0f}, pz[2] = {0.0f, -1e-20f};
    air_radial_look_up(&grid, values, 2, px, py, pz, px);
    assert_true(fabs((double)px[0] - 2.0) < 1e-6 && fabs((double)px[1] - 2.0) < 1e-6);
    air_radial_look_up(&grid, values, 0, NULL, NULL, NULL, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(centres_of_cells_give_their_values),
        cmocka_unit_test(a_constant_is_kept_inside_and_nothing_is_outside),
        cmocka_unit_test(functions_linear_in_the_grids_coordinates_are_exact),
        cmocka_unit_test(all_directions_agree_with_the_surrounding_cells),
        cmocka_unit_test(the_light_itself_and_an_output_in_place_are_legal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
