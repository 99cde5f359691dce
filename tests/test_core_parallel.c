/* The parallel-for. */
#include <stdatomic.h>
#include <string.h>

#include "cmocka_test.h"
#include "core/host.h"

enum { COUNT = 10007, MAX_THREADS = 8, OUTER = 40, INNER = 50 };

typedef struct tally {
    air_context *context;
    size_t thread_count;
    atomic_int visits[COUNT];
    atomic_int busy[MAX_THREADS]; /* bodies running under each worker number */
    atomic_int wrong_worker, shared_worker;
} tally;

static air_context *create(size_t thread_count)
{
    air_context_params params;
    air_context_params_default(&params);
    params.thread_count = thread_count;
    air_context *context = NULL;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

static void visit(void *user, size_t index, size_t worker)
{
    tally *self = user;
    if (worker >= self->thread_count) {
        atomic_fetch_add(&self->wrong_worker, 1);
        return;
    }
    if (atomic_fetch_add(&self->busy[worker], 1) != 0) {
        atomic_fetch_add(&self->shared_worker, 1);
    }
    atomic_fetch_add(&self->visits[index], 1);
    atomic_fetch_sub(&self->busy[worker], 1);
}

static void check_covers(size_t thread_count, size_t count)
{
    assert_true(count <= COUNT);
    air_context *context = create(thread_count);
    tally *all = air_allocate(context, 1, sizeof *all);
    assert_non_null(all);
    all->context = context;
    all->thread_count = thread_count;
    air_parallel_for(context, count, visit, all);
    for (size_t i = 0; i < COUNT; ++i) {
        assert_int_equal(atomic_load(&all->visits[i]), i < count ? 1 : 0);
    }
    assert_int_equal(atomic_load(&all->wrong_worker), 0);
    assert_int_equal(atomic_load(&all->shared_worker), 0);
    air_free(context, all);
    air_context_destroy(context);
}

static void each_index_runs_once_under_a_valid_worker_of_its_own(void **state)
{
    (void)state;
    for (size_t threads = 1; threads <= MAX_THREADS; ++threads) {
        check_covers(threads, COUNT);
        check_covers(threads, 0);
        check_covers(threads, 1);
        check_covers(threads, threads - 1);
    }
}

typedef struct nest {
    air_context *context;
    atomic_int visits[OUTER * INNER];
    atomic_int changed_worker;
} nest;

typedef struct nest_row {
    nest *all;
    size_t row, worker;
} nest_row;

static void visit_inner(void *user, size_t index, size_t worker)
{
    nest_row *row = user;
    atomic_fetch_add(&row->all->visits[row->row * INNER + index], 1);
    if (worker != row->worker) {
        atomic_fetch_add(&row->all->changed_worker, 1);
    }
}

static void visit_outer(void *user, size_t index, size_t worker)
{
    nest *all = user;
    nest_row row = {all, index, worker};
    air_parallel_for(all->context, INNER, visit_inner, &row);
}

static void nested_loops_run_serially_under_the_same_worker(void **state)
{
    (void)state;
    air_context *context = create(4);
    nest *all = air_allocate(context, 1, sizeof *all);
    assert_non_null(all);
    all->context = context;
    air_parallel_for(context, OUTER, visit_outer, all);
    for (size_t i = 0; i < (size_t)OUTER * INNER; ++i) {
        assert_int_equal(atomic_load(&all->visits[i]), 1);
    }
    assert_int_equal(atomic_load(&all->changed_worker), 0);
    air_free(context, all);
    air_context_destroy(context);
}

static void backwards(void *user, size_t count, void (*body)(void *, size_t, size_t),
                      void *body_user)
{
    ++*(int *)user;
    while (count-- > 0) {
        body(body_user, count, 0);
    }
}

static void note_order(void *user, size_t index, size_t worker)
{
    (void)worker;
    size_t *next = user;
    assert_int_equal(index, --*next);
}

static void a_hosts_loop_is_used(void **state)
{
    (void)state;
    int calls = 0;
    size_t next = 10;
    air_context_params params;
    air_context_params_default(&params);
    params.parallel_for = backwards;
    params.parallel_user = &calls;
    air_context *context = NULL;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    air_parallel_for(context, 10, note_order, &next);
    assert_int_equal(calls, 1);
    assert_int_equal(next, 0);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_index_runs_once_under_a_valid_worker_of_its_own),
        cmocka_unit_test(nested_loops_run_serially_under_the_same_worker),
        cmocka_unit_test(a_hosts_loop_is_used),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
