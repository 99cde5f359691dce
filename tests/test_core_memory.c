/* Allocation through the context. */
#include <string.h>

#include "cmocka_test.h"
#include "core/host.h"
#include "failing_allocator.h"

static air_context *create(const air_context_params *params)
{
    air_context *context = NULL;
    assert_int_equal(air_context_create(params, &context), AIR_OK);
    return context;
}

static void sizes_that_overflow_give_null(air_context *context)
{
    assert_null(air_allocate(context, SIZE_MAX, 2));
    assert_null(air_allocate(context, SIZE_MAX / 8 + 1, 8));
    assert_null(air_reallocate(context, NULL, SIZE_MAX / 2 + 1, 2));
    char *block = air_allocate(context, 4, 1);
    assert_non_null(block);
    block[3] = 'x';
    assert_null(air_reallocate(context, block, SIZE_MAX, 3));
    assert_int_equal(block[3], 'x'); /* the old block stays */
    air_free(context, block);
}

static void blocks_are_zeroed_grow_and_keep_their_bytes(air_context *context)
{
    unsigned char *block = air_allocate(context, 100, 3);
    assert_non_null(block);
    for (size_t i = 0; i < 300; ++i) {
        assert_int_equal(block[i], 0);
        block[i] = (unsigned char)i;
    }
    block = air_reallocate(context, block, 1000, 7);
    assert_non_null(block);
    for (size_t i = 0; i < 300; ++i) {
        assert_int_equal(block[i], (unsigned char)i);
    }
    air_free(context, block);
    void *empty = air_allocate(context, 0, 8);
    assert_non_null(empty);
    air_free(context, empty);
    air_free(context, NULL);
}

static void strings_are_copied_and_formatted(air_context *context)
{
    char *copy = air_string_copy(context, "haze");
    char *none = air_string_copy(context, NULL);
    char *text = air_string_format(context, "%s %d%%", "fog", 42);
    assert_string_equal(copy, "haze");
    assert_string_equal(none, "");
    assert_string_equal(text, "fog 42%");
    air_free(context, copy);
    air_free(context, none);
    air_free(context, text);
}

static void check_all(air_context *context)
{
    sizes_that_overflow_give_null(context);
    blocks_are_zeroed_grow_and_keep_their_bytes(context);
    strings_are_copied_and_formatted(context);
}

static void the_c_librarys_allocator_keeps_the_promises(void **state)
{
    (void)state;
    air_context *context = create(NULL);
    check_all(context);
    air_context_destroy(context);
}

static void a_hosts_allocator_keeps_the_promises_and_leaks_nothing(void **state)
{
    (void)state;
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, 1000);
    air_context *context = create(&params);
    check_all(context);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

static void failure_gives_null_and_no_message_is_lost(void **state)
{
    (void)state;
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, 2);
    air_context *context = create(&params);
    assert_int_equal(air_fail_memory(context, "first"),
                     AIR_ERROR_MEMORY); /* makes this thread's entry */
    atomic_store(&allocator.remaining, 0);
    assert_null(air_allocate(context, 1, 1));
    assert_null(air_string_copy(context, "x"));
    assert_null(air_string_format(context, "x"));
    assert_int_equal(air_fail_memory(context, "grid"), AIR_ERROR_MEMORY);
    assert_string_equal(air_context_last_error(context), "grid: out of memory");
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_c_librarys_allocator_keeps_the_promises),
        cmocka_unit_test(a_hosts_allocator_keeps_the_promises_and_leaks_nothing),
        cmocka_unit_test(failure_gives_null_and_no_message_is_lost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
