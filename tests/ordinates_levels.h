/* ordinates_levels.h: a context of each instruction set of this machine, to compare kernels. */
#ifndef AIR_TESTS_ORDINATES_LEVELS_H
#define AIR_TESTS_ORDINATES_LEVELS_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/context.h"
#include "cmocka_test.h"

enum { LEVELS_MOST = 4 };

typedef struct levels {
    air_context *contexts[LEVELS_MOST]; /* plain C first */
    int count;
} levels;

static inline air_context *levels_context(air_cpu cpu)
{
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.cpu = cpu;
    params.thread_count = 1;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

static inline levels levels_make(void)
{
    levels self = {.count = 0};
    air_context *const automatic = levels_context(AIR_CPU_AUTO);
    const int best = (int)air_context_cpu(automatic);
    air_context_destroy(automatic);
    for (int cpu = AIR_CPU_C; cpu <= best; cpu++) {
        self.contexts[self.count++] = levels_context((air_cpu)cpu);
    }
    return self;
}

static inline void levels_finish(levels *self)
{
    for (int i = 0; i < self->count; i++) {
        air_context_destroy(self->contexts[i]);
    }
}

/* The largest difference between a and b. */
static inline double levels_difference(const float *a, const float *b, size_t count)
{
    double worst = 0.0;
    for (size_t i = 0; i < count; i++) {
        assert_true(isfinite(b[i]));
        worst = fmax(worst, fabs((double)a[i] - (double)b[i]));
    }
    return worst;
}

#endif
