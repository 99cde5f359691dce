/* parallel.c: the one parallel-for; OpenMP unless the host brings its own. */
#include <omp.h>

#include "core/context_state.h"

typedef void (*loop_body)(void *user, size_t index, size_t worker);

/* Inside another parallel region the loop runs on the calling thread, under that thread's worker
 * number: scratch memory per worker then stays unshared however deep the nesting. */
static void run_serial(size_t thread_count, size_t count, loop_body body, void *user)
{
    const size_t self = (size_t)omp_get_thread_num();
    const size_t worker = self < thread_count ? self : 0;
    for (size_t i = 0; i < count; ++i) {
        body(user, i, worker);
    }
}

void air_parallel_for(air_context *context, size_t count, loop_body body, void *user)
{
    const size_t thread_count = context->params.thread_count;
    if (context->params.parallel_for != NULL) {
        context->params.parallel_for(context->params.parallel_user, count, body, user);
        return;
    }
    if (thread_count == 1 || count <= 1 || omp_in_parallel()) {
        run_serial(thread_count, count, body, user);
        return;
    }
    const size_t team = count < thread_count ? count : thread_count;
#pragma omp parallel for schedule(dynamic, 1) num_threads((int)team)
    for (size_t i = 0; i < count; ++i) {
        body(user, i, (size_t)omp_get_thread_num());
    }
}
