/* The largest of numbers by their bits: of any count, wherever it is, by every instruction set. */
#include <float.h>

#include "core/exponential.h"
#include "core/random.h"
#include "ordinates/run.h"

#include "cmocka_test.h"

enum { NUMBERS = 70, LEVELS = 4 };

static ordinates_greatest *const sets[LEVELS] = {ordinates_greatest_plain,
#if defined(__x86_64__)
                                                 ordinates_greatest_sse42, ordinates_greatest_avx2,
                                                 ordinates_greatest_avx512
#endif
};

static int levels;

static int set_up(void **state)
{
    air_context *context;
    (void)state;
    if (air_context_create(NULL, &context) != AIR_OK) {
        return 1;
    }
    levels = (int)air_context_cpu(context); /* C is 1 */
    air_context_destroy(context);
    return 0;
}

static void it_is_found_wherever_it_is(void **state)
{
    float x[NUMBERS];
    (void)state;
    for (int i = 0; i < levels * NUMBERS * 2; i++) {
        ordinates_greatest *const greatest = sets[i % levels];
        const size_t count = (size_t)(i / levels % NUMBERS) + 1;
        const bool with_sign = i / levels / NUMBERS != 0;
        for (size_t at = 0; at < count; at++) {
            for (size_t k = 0; k < count; k++) {
                x[k] = 1e-3f * (float)k;
            }
            x[at] = 7.5f;
            assert_int_equal(greatest(x, count, with_sign), air_float_bits(7.5f));
        }
        assert_int_equal(greatest(x, 0, with_sign), 0);
    }
}

/* -0 is 0; numbers below, NaN of either sign and infinities are above all others. */
static void what_is_no_size_is_above_all(void **state)
{
    static const float odd[5] = {-1e-45f, -3.0f, NAN, INFINITY, -INFINITY};
    (void)state;
    for (int level = 0; level < levels; level++) {
        float x[NUMBERS] = {0.0f};
        x[33] = -0.0f;
        assert_int_equal(sets[level](x, NUMBERS, true), 0);
        assert_int_equal(sets[level](x, NUMBERS, false), 0);
        for (int i = 0; i < 5; i++) {
            x[33] = odd[i];
            assert_true(sets[level](x, NUMBERS, true) > air_float_bits(FLT_MAX));
            assert_true((sets[level](x, NUMBERS, false) > air_float_bits(FLT_MAX)) == (i >= 2));
        }
        x[33] = -NAN;
        assert_true(sets[level](x, NUMBERS, false) > air_float_bits(FLT_MAX));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_found_wherever_it_is),
        cmocka_unit_test(what_is_no_size_is_above_all),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
