/* memory_shortage.h: does a piece of work fail well, whichever of its allocations fails? */
#ifndef AIR_TESTS_MEMORY_SHORTAGE_H
#define AIR_TESTS_MEMORY_SHORTAGE_H

#include <limits.h>

#include "cmocka_test.h"
#include "failing_allocator.h"

/* Does the work with no allocation allowed, then with one, two and so on, fewer than `most`, until
 * it succeeds. Before that it must return AIR_ERROR_MEMORY. It frees what it makes, and nothing may
 * be left. */
static inline void assert_shortage_survived(air_status (*work)(air_context *context, void *user),
                                            void *user, long most)
{
    air_status status = AIR_ERROR_MEMORY;
    for (long allowed = 0; status != AIR_OK; allowed++) {
        failing_allocator allocator;
        air_context_params params = failing_params(&allocator, LONG_MAX);
        air_context *context;
        params.thread_count = 1; /* the same allocation fails each time */
        assert_true(allowed < most);
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        const long before = atomic_load(&allocator.live);
        atomic_store(&allocator.remaining, allowed);
        status = work(context, user);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        /* a message may be kept */
        assert_true(status != AIR_OK || atomic_load(&allocator.live) == before);
        air_context_destroy(context);
        assert_int_equal(atomic_load(&allocator.live), 0);
    }
}

#endif
