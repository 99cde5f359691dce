/* Inline exponentials against the C library's in double, over floats spaced evenly in their bits:
 * every 97th of the range. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/exponential.h"

enum { STRIDE = 97 };

static double exp_exact(double x) { return exp(-x); }
static double loss_exact(double x) { return -expm1(-x); }
static double log_exact(double y) { return -log1p(-y); }
static float exp_negative(float x) { return air_exp(-x); }
static float loss(float x)
{
    float t, l;
    air_transmittance_and_loss(x, &t, &l);
    return l;
}
static float transmittance(float x)
{
    float t, l;
    air_transmittance_and_loss(x, &t, &l);
    return t;
}

/* The largest relative error over the positive floats from `low` up to but not including `high`. */
static double worst(float (*f)(float), double (*exact)(double), float low, float high)
{
    double error = 0.0;
    for (uint32_t bits = air_float_bits(low); bits < air_float_bits(high); bits += STRIDE) {
        const float x = air_float_from_bits(bits);
        const double e = exact((double)x);
        error = fmax(error, fabs(((double)f(x) - e) / e));
    }
    return error;
}

/* The header's figures; the polynomial's last steps and the scaling round to within an ulp, 1.2e-7.
 */
static void exp_is_within_its_bound(void **state)
{
    (void)state;
    assert_true(worst(exp_negative, exp_exact, 1e-20f, 87.0f) <= 1e-7);
}

static void transmittance_and_loss_are_within_their_bounds(void **state)
{
    (void)state;
    assert_true(worst(loss, loss_exact, 1e-30f, 200.0f) <= 2e-7);
    assert_true(worst(transmittance, exp_exact, 1e-20f, 87.0f) <= 1e-7);
}

static void logarithm_is_within_its_bound(void **state)
{
    (void)state;
    assert_true(worst(air_neg_log1m, log_exact, 1e-30f, 1.0f) <= 2.4e-7);
}

static void ends_are_exact(void **state)
{
    (void)state;
    assert_float_equal(air_exp(0.0f), 1.0f, 0.0f);
    assert_float_equal(air_exp(-INFINITY), 0.0f, 0.0f);
    assert_float_equal(loss(0.0f), 0.0f, 0.0f);
    assert_float_equal(loss(INFINITY), 1.0f, 0.0f);
    assert_float_equal(transmittance(0.0f), 1.0f, 0.0f);
    assert_float_equal(air_neg_log1m(0.0f), 0.0f, 0.0f);
    assert_true(isnan(air_exp(NAN)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exp_is_within_its_bound),
        cmocka_unit_test(transmittance_and_loss_are_within_their_bounds),
        cmocka_unit_test(logarithm_is_within_its_bound),
        cmocka_unit_test(ends_are_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
