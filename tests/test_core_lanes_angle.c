/* Angles, roots and inverses of many numbers against the C library's in long double, at every
 * instruction set that the machine has, in double and in float. */
#include <float.h>
#include <math.h>

#include "cmocka_test.h"
#include "core/cpu.h"
#include "core/random.h"
#include "lanes_angle_probe.h"

enum { BLOCK = 1024, BLOCKS = 400 };

static const lanes_angle_probe *probe_of(air_cpu cpu, bool floats)
{
    if (floats) {
        return cpu == AIR_CPU_AVX512 ? &lanes_angle_v4_float
               : cpu == AIR_CPU_AVX2 ? &lanes_angle_v3_float
                                     : &lanes_angle_v2_float;
    }
    return cpu == AIR_CPU_AVX512 ? &lanes_angle_v4_double
           : cpu == AIR_CPU_AVX2 ? &lanes_angle_v3_double
                                 : &lanes_angle_v2_double;
}

/* log x uniform; a float. */
static double random_size(air_rng *rng, double low, double high)
{
    return (double)(float)(low * exp(air_rng_next(rng) * 0x1p-32 * log(high / low)));
}

typedef struct errors {
    double inverse_root, inverse, root, angle;
} errors;

static double relative(double value, long double exact)
{
    return (double)fabsl((value - exact) / exact);
}

/* The largest relative errors: of numbers in [1e-35, 1e35], and of vectors whose components, each
 * of either size, are in [1e-15, 1e15]. */
static errors worst(const lanes_angle_probe *probe)
{
    static double x[BLOCK], y[BLOCK], a[4][BLOCK];
    air_rng rng = air_rng_from_keys(29, 1);
    errors e = {0.0, 0.0, 0.0, 0.0};
    for (int block = 0; block < BLOCKS; block++) {
        for (int i = 0; i < BLOCK; i++) {
            x[i] = random_size(&rng, 1e-35, 1e35);
        }
        probe->inverse_root(x, a[0], BLOCK);
        probe->inverse(x, a[1], BLOCK);
        probe->root(x, a[2], BLOCK);
        for (int i = 0; i < BLOCK; i++) {
            e.inverse_root = fmax(e.inverse_root, relative(a[0][i], 1.0L / sqrtl(x[i])));
            e.inverse = fmax(e.inverse, relative(a[1][i], 1.0L / x[i]));
            e.root = fmax(e.root, relative(a[2][i], sqrtl(x[i])));
            const double size = block % 2 == 0 ? random_size(&rng, 1e-15, 1e15) : 1.0;
            x[i] = (double)(float)(size * (2.0 * air_rng_next(&rng) * 0x1p-32 - 1.0));
            y[i] = block % 4 == 0 ? random_size(&rng, 1e-15, 1e15)
                                  : (double)(float)(size * random_size(&rng, 1e-5, 1.0));
        }
        probe->angle(x, y, a[3], BLOCK);
        for (int i = 0; i < BLOCK; i++) {
            e.angle = fmax(e.angle, relative(a[3][i], atan2l(y[i], x[i])));
        }
    }
    return e;
}

/* The header's figures. An inverse root by Newton's rule ends with three roundings, an angle is a
 * chain of two halvings, a quotient and a polynomial. */
static void errors_are_within_their_bounds(void **state)
{
    (void)state;
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
        for (int floats = 0; floats < 2; floats++) {
            const double rounding = floats ? FLT_EPSILON : DBL_EPSILON;
            const errors e = worst(probe_of(cpu, floats != 0));
            print_message("level %d, %s: in roundings of 1: inverse root %.2f, inverse %.2f, root "
                          "%.2f, angle %.2f\n",
                          (int)cpu, floats ? "float" : "double", e.inverse_root / rounding,
                          e.inverse / rounding, e.root / rounding, e.angle / rounding);
            assert_true(e.inverse_root <= 1.0 * rounding);
            assert_true(e.inverse <= 1.0 * rounding);
            assert_true(e.root <= 1.5 * rounding);
            assert_true(e.angle <= (floats ? 5e-7 : 8e-16));
        }
    }
}

/* 9e-8 of the polynomials, and a rounding or two after them. */
static void powers_and_logarithms_of_floats(void **state)
{
    static double x[BLOCK], out[BLOCK];
    air_rng rng = air_rng_from_keys(29, 2);
    (void)state;
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
        const lanes_angle_probe *const probe = probe_of(cpu, true);
        double power = 0.0, logarithm = 0.0;
        for (int block = 0; block < BLOCKS; block++) {
            const double most = block % 2 == 0 ? 125.0 : 1.0;
            for (int i = 0; i < BLOCK; i++) {
                x[i] = (double)(float)(-most * air_rng_next(&rng) * 0x1p-32);
            }
            probe->exp2(x, out, BLOCK);
            for (int i = 0; i < BLOCK; i++) {
                power = fmax(power, relative(out[i], exp2l(x[i])));
                x[i] = block % 2 == 0 ? random_size(&rng, 1e-35, 1e35)
                                      : 1.0 + (double)(float)(x[i] * 0x1p-8);
            }
            probe->log2(x, out, BLOCK);
            for (int i = 0; i < BLOCK; i++) {
                const double exact = (double)log2l((long double)(float)x[i]);
                logarithm = fmax(logarithm, fabs(out[i] - exact) / fmax(fabs(exact), 1e-3));
            }
        }
        print_message("level %d: exp2 %.1e, log2 %.1e\n", (int)cpu, power, logarithm);
        assert_true(power < 2e-7 && logarithm < 3e-7);
    }
}

static void ends_of_the_range(void **state)
{
    (void)state;
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
        for (int floats = 0; floats < 2; floats++) {
            const double x[16] = {1.0, 0.0, -1.0, 1.0, -1.0, 0.0, 1e15, -1e15, 1.0, 1.0},
                         y[16] = {0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1e-15, 1e15};
            const double pi = acos(-1.0), rounding = floats ? FLT_EPSILON : DBL_EPSILON;
            const double exact[10] = {0.0, pi / 2.0, pi, pi / 4.0, 0.75 * pi,
                                      0.0, 0.0,      pi, 1e-15,    pi / 2.0};
            double out[16];
            probe_of(cpu, floats != 0)->angle(x, y, out, 16);
            for (int i = 0; i < 10; i++) {
                assert_true(fabs(out[i] - exact[i]) <=
                            4.0 * rounding * exact[i] + 1e-15 * (i == 9));
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_are_within_their_bounds),
        cmocka_unit_test(powers_and_logarithms_of_floats),
        cmocka_unit_test(ends_of_the_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
