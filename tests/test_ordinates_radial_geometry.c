/* The octahedral square and the shells, held against the sphere. */
#include <math.h>
#include <stdlib.h>

#include "airlight/ordinates_radial.h"
#include "cmocka_test.h"
#include "core/quadrature.h"
#include "core/vec.h"

enum { N_MOST = 64 };

static const uint32_t sizes[] = {4, 6, 16, 32, 64};
enum { SIZES = sizeof sizes / sizeof *sizes };

/* The octahedron unfolded, written down anew. */
static void decode(double x, double y, double d[3])
{
    d[0] = x;
    d[1] = y;
    d[2] = 1.0 - fabs(x) - fabs(y);
    if (d[2] < 0.0) {
        d[0] = copysign(1.0 - fabs(y), x);
        d[1] = copysign(1.0 - fabs(x), y);
    }
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int i = 0; i < 3; i++) {
        d[i] /= length;
    }
}

static double distance(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

/* A point of an edge, where s in [-1, 1] runs along it. */
static void edge_point(uint32_t n, uint32_t u, uint32_t v, int side, double s, double d[3])
{
    const double across = side % 2 == 0 ? 0.0 : 2.0, along = 1.0 + s;
    const double x = (2.0 * u + (side < 2 ? across : along)) / n - 1.0;
    const double y = (2.0 * v + (side < 2 ? along : across)) / n - 1.0;
    decode(x, y, d);
}

static void solid_angles_are_those_of_the_map(void **state)
{
    static double omega[N_MOST * N_MOST];
    double x[12], w[12];
    (void)state;
    air_gauss_legendre(12, x, w);
    for (size_t s = 0; s < SIZES; s++) {
        const uint32_t n = sizes[s];
        double sum = 0.0, error = 0.0;
        air_radial_solid_angles(n, omega);
        for (uint32_t c = 0; c < n * n; c++) {
            sum += omega[c];
            /* The plane x + y + z = 1 has du dv = cos dA, so d omega = du dv / |p|^3. Cells that
             * the fold crosses have a kink there: left to the sum. */
            const double u0 = 2.0 * (c % n) / n - 1.0, v0 = 2.0 * (c / n) / n - 1.0;
            const double u_mid = fabs(u0 + 1.0 / n), v_mid = fabs(v0 + 1.0 / n);
            if (fabs(u_mid + v_mid - 1.0) < 0.5 / n) {
                continue;
            }
            double integral = 0.0;
            for (int i = 0; i < 144; i++) {
                const double u = fabs(u0 + (1.0 + x[i / 12]) / n);
                const double v = fabs(v0 + (1.0 + x[i % 12]) / n);
                const double a = u + v > 1.0 ? 1.0 - v : u, b = u + v > 1.0 ? 1.0 - u : v;
                const double z = 1.0 - u - v;
                integral += w[i / 12] * w[i % 12] / pow(a * a + b * b + z * z, 1.5);
            }
            error = double_max(error, fabs(integral / ((double)n * n) / omega[c] - 1.0));
        }
        /* n^2 terms, each rounded to 2^-53 of 4 pi / n^2 and to 2^-53 of the sum so far. */
        assert_true(fabs(sum - 4.0 * AIR_PI) < n * n * 4.0 * AIR_PI * 0x1p-53);
        /* The integrand's nearest singularity is sqrt(1/3) away, cells are at most 1/2 wide: the
         * rule's error falls like (1/5)^24; atan2's rounding is left. */
        assert_true(error < 1e-12);
    }
}

static void cells_of_32_have_the_known_extent(void **state)
{
    static double omega[32 * 32];
    double least = 1.0, most = 0.0;
    (void)state;
    air_radial_solid_angles(32, omega);
    for (int c = 0; c < 32 * 32; c++) {
        least = double_min(least, omega[c]);
        most = double_max(most, omega[c]);
    }
    assert_true(fabs(least - 0.00443) < 5e-6 && fabs(most - 0.02012) < 5e-6); /* as printed */
}

static void neighbours_share_their_edge_on_the_sphere(void **state)
{
    (void)state;
    for (size_t s = 0; s < SIZES; s++) {
        const uint32_t n = sizes[s];
        for (uint32_t c = 0; c < 4 * n * n; c++) {
            const uint32_t u = c / 4 % n, v = c / 4 / n;
            const int side = (int)(c % 4);
            const uint32_t other = air_radial_neighbour(n, u, v, side);
            int found = 0;
            for (int back = 0; back < 4; back++) {
                /* On the square's rim the edge runs the other way round. */
                for (int turned = 0; turned < 2; turned++) {
                    double worst = 0.0;
                    for (int i = -1; i <= 1; i++) {
                        double a[3], b[3];
                        edge_point(n, u, v, side, 0.9 * i, a);
                        edge_point(n, other % n, other / n, back, turned ? -0.9 * i : 0.9 * i, b);
                        worst = double_max(worst, distance(a, b));
                    }
                    if (worst < 1e-15 * 8) { /* coordinates of size 1, a few operations */
                        found++;
                        assert_int_equal(air_radial_neighbour(n, other % n, other / n, back),
                                         v * n + u);
                        const double arc = air_radial_arc(n, u, v, side);
                        const double same = air_radial_arc(n, other % n, other / n, back);
                        assert_true(fabs(arc - same) < 1e-14);
                    }
                }
            }
            assert_int_equal(found, 1);
        }
    }
}

static void opposite_cells_look_opposite_ways(void **state)
{
    (void)state;
    for (size_t s = 0; s < SIZES; s++) {
        const uint32_t n = sizes[s];
        for (uint32_t c = 0; c < n * n; c++) {
            const uint32_t other = air_radial_opposite(n, c % n, c / n);
            double a[3], b[3];
            air_radial_direction(n, c % n, c / n, a);
            air_radial_direction(n, other % n, other / n, b);
            const double minus[3] = {-b[0], -b[1], -b[2]};
            assert_true(distance(a, minus) < 1e-15 * 8);
            assert_int_equal(air_radial_opposite(n, other % n, other / n), c);
        }
    }
}

/* The largest error of a linear function of the direction between cells, over many directions, the
 * axes, the edges and their surroundings among them. */
static double interpolation_error(uint32_t n)
{
    double error = 0.0;
    for (int i = 0; i <= 200; i++) {
        for (int j = 0; j <= 200; j++) {
            double d[3], sum = 0.0, weight = 0.0, weights[4];
            uint32_t cells[4];
            decode(i / 100.0 - 1.0, j / 100.0 - 1.0, d);
            air_radial_surrounding(n, d, cells, weights);
            for (int c = 0; c < 4; c++) {
                double e[3];
                assert_true(cells[c] < n * n && weights[c] >= 0.0);
                air_radial_direction(n, cells[c] % n, cells[c] / n, e);
                sum += weights[c] * (e[0] + 2.0 * e[1] + 3.0 * e[2]);
                weight += weights[c];
            }
            assert_true(fabs(weight - 1.0) < 1e-15 * 4);
            error = double_max(error, fabs(sum - (d[0] + 2.0 * d[1] + 3.0 * d[2])));
        }
    }
    return error;
}

static void surrounding_cells_are_near_everywhere(void **state)
{
    (void)state;
    /* Centres of touching cells are at most sqrt(2) 2/n apart on the square, which the map
     * stretches by at most sqrt(3); the function's slope is sqrt(14). A wrong gluing takes values
     * from other sides of the sphere: errors of size 1. At folds the map has kinks, so errors fall
     * like 1/n. */
    const double at_16 = interpolation_error(16), at_64 = interpolation_error(64);
    assert_true(at_16 < sqrt(14.0) * sqrt(6.0) / 16.0);
    assert_true(at_64 < at_16 / 3.0);
}

static void the_centre_of_a_cell_is_the_cell_alone(void **state)
{
    (void)state;
    for (uint32_t c = 0; c < 32 * 32; c++) {
        double d[3], weights[4], here = 0.0;
        uint32_t cells[4];
        air_radial_direction(32, c % 32, c / 32, d);
        for (int i = 0; i < 3; i++) {
            d[i] *= 2.5; /* of any length */
        }
        air_radial_surrounding(32, d, cells, weights);
        for (int i = 0; i < 4; i++) {
            here += cells[i] == c ? weights[i] : 0.0;
        }
        assert_true(here > 1.0 - 32 * 1e-15); /* n times the rounding of a coordinate */
    }
}

static void shells_are_as_deep_as_wide_and_fill_the_sphere(void **state)
{
    const air_radial_grid grid = {.directions = 32, .shells = 32, .radius_m = 2.5f};
    double volume = 0.0;
    (void)state;
    for (uint32_t k = 0; k < 32; k++) {
        const double inner = air_radial_radius(&grid, k), outer = air_radial_radius(&grid, k + 1);
        assert_true(fabs((outer - inner) / inner - sqrt(4.0 * AIR_PI / (32 * 32))) < 1e-13);
        volume += air_radial_volume(&grid, k, 4.0 * AIR_PI);
    }
    const double inner = air_radial_radius(&grid, 0);
    assert_true(air_radial_radius(&grid, 32) == 2.5);
    assert_true(fabs(inner - 0.0866688) < 5e-8); /* as printed with the public spheres */
    const double exact = 4.0 / 3.0 * AIR_PI * (2.5 * 2.5 * 2.5 - inner * inner * inner);
    assert_true(fabs(volume / exact - 1.0) < 1e-13);
}

static void a_cosine_lobe_has_the_power_1_and_the_shape(void **state)
{
    static const float normals[][3] = {{0, 0, 1}, {-1, 0, 0}, {0.48f, 0.6f, -0.64f}};
    static double omega[32 * 32];
    static float intensity[32 * 32];
    (void)state;
    air_radial_solid_angles(32, omega);
    for (size_t i = 0; i < 3; i++) {
        double power = 0.0, flow = 0.0;
        air_radial_cosine_lobe(32, normals[i], intensity);
        for (uint32_t c = 0; c < 32 * 32; c++) {
            double d[3];
            air_radial_direction(32, c % 32, c / 32, d);
            const double cosine = (double)normals[i][0] * d[0] + (double)normals[i][1] * d[1] +
                                  (double)normals[i][2] * d[2];
            power += (double)intensity[c] * omega[c];
            flow += (double)intensity[c] * omega[c] * cosine;
            /* cos / pi, but for the midpoint rule's error in the sum that normalises: h^2/24 of
             * second derivatives, and less than 1 % of cells cut by the horizon. */
            assert_true(fabs((double)intensity[c] - double_max(0.0, cosine) / AIR_PI) < 1e-3);
        }
        assert_true(fabs(power - 1.0) < 1e-7);      /* floats */
        assert_true(fabs(flow - 2.0 / 3.0) < 2e-3); /* the mean cosine of the lobe */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solid_angles_are_those_of_the_map),
        cmocka_unit_test(cells_of_32_have_the_known_extent),
        cmocka_unit_test(neighbours_share_their_edge_on_the_sphere),
        cmocka_unit_test(opposite_cells_look_opposite_ways),
        cmocka_unit_test(surrounding_cells_are_near_everywhere),
        cmocka_unit_test(the_centre_of_a_cell_is_the_cell_alone),
        cmocka_unit_test(shells_are_as_deep_as_wide_and_fill_the_sphere),
        cmocka_unit_test(a_cosine_lobe_has_the_power_1_and_the_shape),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
