/* failing_allocator.h: an allocator that counts live blocks and fails when told to. For tests of
 * allocation failure. */
#ifndef AIR_TESTS_FAILING_ALLOCATOR_H
#define AIR_TESTS_FAILING_ALLOCATOR_H

#include <stdatomic.h>
#include <stdlib.h>

#include "airlight/context.h"

typedef struct failing_allocator {
    atomic_long remaining; /* allocations that still succeed */
    atomic_long live;      /* blocks not yet freed */
} failing_allocator;

static inline void *failing_reallocate(void *user, void *pointer, size_t size)
{
    failing_allocator *self = user;
    if (size == 0) {
        if (pointer != NULL) {
            atomic_fetch_sub(&self->live, 1);
        }
        free(pointer);
        return NULL;
    }
    if (atomic_fetch_sub(&self->remaining, 1) <= 0) {
        return NULL;
    }
    void *moved = realloc(pointer, size);
    if (moved != NULL && pointer == NULL) {
        atomic_fetch_add(&self->live, 1);
    }
    return moved;
}

/* Context parameters that use *self, which allows `remaining` allocations. */
static inline air_context_params failing_params(failing_allocator *self, long remaining)
{
    air_context_params params;
    air_context_params_default(&params);
    atomic_store(&self->remaining, remaining);
    atomic_store(&self->live, 0);
    params.reallocate = failing_reallocate;
    params.allocate_user = self;
    return params;
}

#endif
