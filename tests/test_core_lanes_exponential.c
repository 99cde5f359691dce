/* Exponentials of many doubles against the C library's in long double, at every instruction set
 * that the machine has. */
#include <float.h>
#include <math.h>

#include "cmocka_test.h"
#include "core/cpu.h"
#include "core/random.h"
#include "lanes_probe.h"

enum { BLOCK = 1024, BLOCKS = 400 };

typedef long double exact_function(long double x);

static long double exp_exact(long double x) { return expl(x); }
static long double transmittance_exact(long double x) { return expl(-x); }
static long double loss_exact(long double x) { return -expm1l(-x); }
static long double log_exact(long double x) { return logl(x); }

static const lanes_probe *probe_of(air_cpu cpu)
{
    return cpu == AIR_CPU_AVX512 ? &lanes_probe_v4
           : cpu == AIR_CPU_AVX2 ? &lanes_probe_v3
                                 : &lanes_probe_v2;
}

static double unit(air_rng *rng)
{
    return (air_rng_next(rng) + air_rng_next(rng) * 0x1p-32) * 0x1p-32;
}

/* The largest relative error at sign * x, x random in [low, high] with log x uniform. */
static double worst(probe_function *f, exact_function *exact, double sign, double low, double high)
{
    static double x[BLOCK], y[BLOCK];
    air_rng rng = air_rng_from_keys(7, 1);
    double error = 0.0;
    for (int block = 0; block < BLOCKS; block++) {
        for (int i = 0; i < BLOCK; i++) {
            x[i] = sign * fmin(high, low * exp(unit(&rng) * log(high / low)));
        }
        f(x, y, BLOCK);
        for (int i = 0; i < BLOCK; i++) {
            const long double e = exact(x[i]);
            error = fmax(error, (double)fabsl((y[i] - e) / e));
        }
    }
    return error;
}

/* The header's figures. One rounding is 1.1e-16 at most; polynomials and scalings add to it. */
static void errors_are_within_their_bounds(void **state)
{
    (void)state;
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
        const lanes_probe *p = probe_of(cpu);
        const double exp_error = worst(p->exp, exp_exact, -1.0, 1e-18, 708.0),
                     transmittance =
                         worst(p->transmittance, transmittance_exact, 1.0, 1e-18, 708.0),
                     loss = worst(p->loss, loss_exact, 1.0, 1e-300, 1e4),
                     loss_near = worst(p->loss, loss_exact, 1.0, 0.1, 2.0),
                     log_error = worst(p->log, log_exact, 1.0, 5e-324, 1.7e308),
                     log_near = worst(p->log, log_exact, 1.0, 0.3, 3.0);
        print_message("level %d: exp %.2g, transmittance %.2g, loss %.2g %.2g, log %.2g %.2g\n",
                      (int)cpu, exp_error, transmittance, loss, loss_near, log_error, log_near);
        assert_true(exp_error <= 2.5e-16);
        assert_true(transmittance <= 2.5e-16);
        assert_true(loss <= 4e-16 && loss_near <= 4e-16);
        assert_true(log_error <= 4e-16 && log_near <= 4e-16);
    }
}

static void ends_of_the_ranges_are_exact(void **state)
{
    (void)state;
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
        const lanes_probe *p = probe_of(cpu);
        const double x[8] = {0.0, -0.0, -746.0, -1e6, -INFINITY, -1e-320, -DBL_MAX, -1400.0};
        const double e[8] = {1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
        const double thick[8] = {0.0, 1e-320, 40.0, 709.0, 1e300, INFINITY, 5e-324, 1e-200};
        const double loss[8] = {0.0, 1e-320, 1.0, 1.0, 1.0, 1.0, 5e-324, 1e-200};
        const double z[8] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
        double y[8];
        p->exp(x, y, 8);
        for (int i = 0; i < 8; i++) {
            assert_true(y[i] == e[i]);
        }
        p->loss(thick, y, 8);
        for (int i = 0; i < 8; i++) {
            assert_true(y[i] == loss[i]);
        }
        p->log(z, y, 8);
        assert_true(y[0] == 0.0);
    }
}

/* Below 2^-1022 an ulp is 5e-324; a product of roundings may be off by one. */
static void exp_underflows_gradually(void **state)
{
    (void)state;
    for (air_cpu cpu = AIR_CPU_SSE42; cpu <= air_cpu_detect(); cpu++) {
        double x[8], y[8];
        for (double at = -745.0; at < -708.0; at += 0.37) {
            for (int i = 0; i < 8; i++) {
                x[i] = at + 0.04 * i;
            }
            probe_of(cpu)->exp(x, y, 8);
            for (int i = 0; i < 8; i++) {
                assert_true(fabs(y[i] - (double)expl(x[i])) <= 5e-324 + 2.5e-16 * y[i]);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_are_within_their_bounds),
        cmocka_unit_test(ends_of_the_ranges_are_exact),
        cmocka_unit_test(exp_underflows_gradually),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
