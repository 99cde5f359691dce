/* Diffusion between the directions of a shell. */
#include <math.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/vec.h"
#include "ordinates/radial.h"

enum { N = 32, COUNT = N * N };

static double omega[COUNT], link[3][COUNT], mobility[COUNT], rings[5][COUNT];
static double power[COUNT], momentum[COUNT];
static uint32_t opposite[COUNT], order[3][COUNT];
static radial_run run;

static int set_up(void **state)
{
    const air_radial_params params = {.lateral = AIR_RADIAL_SPREAD};
    (void)state;
    run.mesh = (radial_mesh){.n = N,
                             .count = COUNT,
                             .omega = omega,
                             .opposite = opposite,
                             .order = {order[0], order[1], order[2]},
                             .link = {link[0], link[1], link[2]}};
    run.mobility = mobility;
    for (int i = 0; i < 5; i++) {
        run.rings[i] = rings[i];
    }
    radial_mesh_fill(&run.mesh, &params);
    return 0;
}

static void set_mobility(double square_radians, bool rugged)
{
    for (uint32_t c = 0; c < COUNT; c++) {
        const double factor = rugged ? (double)(c * 2654435761u) * 0x1p-31 : 1.0;
        mobility[c] = square_radians * factor / omega[c];
    }
}

static void uniform_fields_are_stationary(void **state)
{
    (void)state;
    for (int i = -6; i <= 6; i += 3) {
        set_mobility(pow(10.0, i), false);
        for (int c = 0; c < COUNT; c++) {
            power[c] = omega[c];
            momentum[c] = -0.3 * omega[c];
        }
        radial_spread(&run, power, momentum);
        for (int c = 0; c < COUNT; c++) {
            /* Kernels have power up to 0.3 n times the cell's going both ways; the difference
             * rounds to that times 2^-53, along rings of 2n. Beyond, in proportion. */
            const double tolerance = 1e-12 * double_max(1.0, pow(10.0, i));
            assert_true(fabs(power[c] / omega[c] - 1.0) < tolerance);
            assert_true(fabs(momentum[c] / power[c] + 0.3) < tolerance);
        }
    }
}

static void power_is_kept_and_stays_positive(void **state)
{
    (void)state;
    for (int i = -3; i <= 3; i++) {
        double sum = 0.0;
        set_mobility(pow(10.0, i), true);
        memset(power, 0, sizeof power);
        memset(momentum, 0, sizeof momentum);
        power[5] = 1.0; /* on the rim: across the gluing too */
        momentum[5] = -0.7;
        radial_spread(&run, power, momentum);
        for (int c = 0; c < COUNT; c++) {
            sum += power[c];
            assert_true(power[c] >= 0.0 && fabs(momentum[c] + 0.7 * power[c]) <= 1e-12 * power[c]);
        }
        assert_true(fabs(sum - 1.0) < 1e-9 * pow(10.0, double_max(0.0, i - 1)));
    }
}

/* Harmonics of degree 1 fall by 1 / (1 + 2 D) per step where the diffusivity D = mobility omega is
 * small, whatever their axis. Three implicit steps with D = 0.005 in place of one are off by as
 * much as D, and finite elements of 0.1 rad by 1 %: 3 % together. */
static void the_first_harmonic_falls_at_the_right_rate(void **state)
{
    const double square_radians = 0.005;
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        double before = 0.0, after = 0.0, d[3];
        set_mobility(square_radians, false);
        memset(momentum, 0, sizeof momentum);
        for (uint32_t c = 0; c < COUNT; c++) {
            air_radial_direction(N, c % N, c / N, d);
            power[c] = omega[c] * (1.0 + d[axis]);
            before += omega[c] * d[axis] * d[axis];
        }
        radial_spread(&run, power, momentum);
        for (uint32_t c = 0; c < COUNT; c++) {
            air_radial_direction(N, c % N, c / N, d);
            after += power[c] * d[axis];
        }
        const double rate = (before / after - 1.0) / (2.0 * square_radians);
        assert_true(fabs(rate - 1.0) < 0.03);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uniform_fields_are_stationary),
        cmocka_unit_test(power_is_kept_and_stays_positive),
        cmocka_unit_test(the_first_harmonic_falls_at_the_right_rate),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
