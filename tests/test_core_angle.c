/* The polynomials of core/angle.h against the C library in double. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/angle.h"

enum { STEPS = 1000000 };

static void sines_and_cosines_of_turns_are_those_of_the_c_library(void **state)
{
    (void)state;
    for (int i = 0; i <= STEPS; i++) {
        const double turn = (double)i / STEPS;
        float s, c;
        double s64, c64;
        air_sincos_turn((float)turn, &s, &c);
        air_sincos_turn64(turn, &s64, &c64);
        const double exact = 2.0 * AIR_PI * (double)(float)turn, exact64 = 2.0 * AIR_PI * turn;
        assert_true(fabs((double)s - sin(exact)) < 1.2e-7);
        assert_true(fabs((double)c - cos(exact)) < 1.2e-7);
        /* the products themselves are rounded: half a digit of 2 pi */
        assert_true(fabs(s64 - sin(exact64)) < 1e-15);
        assert_true(fabs(c64 - cos(exact64)) < 1e-15);
        assert_true(fabs(s64 * s64 + c64 * c64 - 1.0) < 1e-15);
    }
}

static void the_angle_of_a_vector_is_that_of_the_c_library(void **state)
{
    (void)state;
    for (int i = 0; i <= STEPS; i++) {
        const double angle = AIR_PI * (double)i / STEPS, length = exp(40.0 * sin(7.0 * i));
        const float x = (float)(length * cos(angle)), y = (float)fabs(length * sin(angle));
        const double exact = atan2((double)y, (double)x);
        assert_true(fabs((double)air_plane_angle(x, y) - exact) <= 3e-7 * exact);
    }
    assert_true(air_plane_angle(1.0f, 0.0f) == 0.0f);
    assert_true(air_plane_angle(1.0f, 1e-30f) == 1e-30f);
    assert_true(air_plane_angle(-1.0f, 0.0f) == AIR_PI_F);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sines_and_cosines_of_turns_are_those_of_the_c_library),
        cmocka_unit_test(the_angle_of_a_vector_is_that_of_the_c_library),
    };
    return cmocka_run_group_tests_name("core_angle", tests, NULL, NULL);
}
