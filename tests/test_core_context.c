/* Contexts: parameters, refusals, clock. */
#include <string.h>

#include "cmocka_test.h"
#include "core/cpu.h"
#include "core/host.h"
#include "failing_allocator.h"

static void count_message(void *user, air_message_level level, const char *text)
{
    assert_int_equal(level, AIR_MESSAGE_ERROR);
    assert_true(strlen(text) > 0);
    ++*(int *)user;
}

static void defaults_make_a_context_of_the_best_cpu(void **state)
{
    (void)state;
    air_context *context = NULL;
    air_context_params params;
    air_context_params_default(&params);
    assert_true(params.thread_count >= 1);
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    assert_int_equal(air_context_thread_count(context), params.thread_count);
    assert_int_equal(air_context_cpu(context), air_cpu_detect());
    assert_non_null(air_context_ray_backend(context)->intersect);
    assert_string_equal(air_context_last_error(context), "");
    air_context_destroy(context);
    air_context_destroy(NULL);
}

static void lower_cpu_levels_are_kept_as_asked(void **state)
{
    (void)state;
    air_context_params params;
    air_context_params_default(&params);
    for (air_cpu cpu = AIR_CPU_C; cpu <= air_cpu_detect(); ++cpu) {
        air_context *context = NULL;
        params.cpu = cpu;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        assert_int_equal(air_context_cpu(context), cpu);
        air_context_destroy(context);
    }
}

static void bad_parameters_are_refused_with_one_message(void **state)
{
    (void)state;
    int messages = 0;
    air_context *context = (air_context *)&messages;
    air_context_params params;
    air_context_params_default(&params);
    params.message = count_message;
    params.message_user = &messages;
    params.thread_count = 0;
    assert_int_equal(air_context_create(&params, &context), AIR_ERROR_ARGUMENT);
    assert_null(context);
    assert_int_equal(messages, 1);
    params.thread_count = SIZE_MAX;
    assert_int_equal(air_context_create(&params, &context), AIR_ERROR_ARGUMENT);
    params.thread_count = 1;
    params.cpu = (air_cpu)17;
    assert_int_equal(air_context_create(&params, &context), AIR_ERROR_ARGUMENT);
    assert_int_equal(messages, 3);
    if (air_cpu_detect() < AIR_CPU_AVX512) {
        params.cpu = AIR_CPU_AVX512;
        assert_int_equal(air_context_create(&params, &context), AIR_ERROR_UNSUPPORTED);
    }
    assert_int_equal(air_context_create(&params, NULL), AIR_ERROR_ARGUMENT);
}

static void no_memory_gives_no_context(void **state)
{
    (void)state;
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, 0);
    air_context *context = NULL;
    assert_int_equal(air_context_create(&params, &context), AIR_ERROR_MEMORY);
    assert_null(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

static void everything_allocated_is_freed(void **state)
{
    (void)state;
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, 1000);
    air_context *context = NULL;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    (void)air_fail(context, AIR_ERROR_IO, "an entry for this thread");
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

static double fixed_clock(void *user) { return *(double *)user; }

static void clock_is_monotonic_or_the_hosts(void **state)
{
    (void)state;
    air_context *context = NULL;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    double last = air_clock(context);
    for (int i = 0; i < 1000; ++i) {
        const double now = air_clock(context);
        assert_true(now >= last);
        last = now;
    }
    air_context_destroy(context);

    double time = 42.5;
    air_context_params params;
    air_context_params_default(&params);
    params.clock = fixed_clock;
    params.clock_user = &time;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_true(air_clock(context) == 42.5);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_make_a_context_of_the_best_cpu),
        cmocka_unit_test(lower_cpu_levels_are_kept_as_asked),
        cmocka_unit_test(bad_parameters_are_refused_with_one_message),
        cmocka_unit_test(no_memory_gives_no_context),
        cmocka_unit_test(everything_allocated_is_freed),
        cmocka_unit_test(clock_is_monotonic_or_the_hosts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
