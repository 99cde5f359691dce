/* context.c: making and unmaking a context, and the small things it answers. */
#include <limits.h>
#include <omp.h>
#include <stdio.h>
#include <time.h>

#include "core/context_state.h"
#include "core/cpu.h"
#include "core/ray_embree.h"

void air_context_params_default(air_context_params *params)
{
    *params = (air_context_params){0};
    params->thread_count = (size_t)omp_get_num_procs();
    params->cpu = AIR_CPU_AUTO;
}

/* Before there is a context a message can only go straight to the callback. */
static air_status refuse(const air_context_params *params, air_status status, const char *text)
{
    if (params->message != NULL) {
        params->message(params->message_user, AIR_MESSAGE_ERROR, text);
    }
    return status;
}

static air_status check_params(const air_context_params *params)
{
    if (params->thread_count == 0 || params->thread_count > INT_MAX) {
        return refuse(params, AIR_ERROR_ARGUMENT, "context: thread_count must be at least 1");
    }
    if ((int)params->cpu < (int)AIR_CPU_AUTO || params->cpu > AIR_CPU_AVX512) {
        return refuse(params, AIR_ERROR_ARGUMENT, "context: cpu is not an instruction set");
    }
    if (params->cpu > air_cpu_detect()) {
        return refuse(params, AIR_ERROR_UNSUPPORTED,
                      "context: the machine lacks the instruction set asked for");
    }
    return AIR_OK;
}

/* The locks of a zeroed context; false if the system has none left. */
static bool create_locks(air_context *context)
{
    pthread_mutexattr_t attributes;
    if (pthread_mutexattr_init(&attributes) != 0) {
        return false;
    }
    (void)pthread_mutexattr_settype(&attributes, PTHREAD_MUTEX_RECURSIVE);
    bool done = pthread_mutex_init(&context->callback_lock, &attributes) == 0;
    (void)pthread_mutexattr_destroy(&attributes);
    if (done && pthread_mutex_init(&context->error_lock_storage, NULL) != 0) {
        (void)pthread_mutex_destroy(&context->callback_lock);
        done = false;
    }
    context->error_lock = &context->error_lock_storage;
    return done;
}

air_status air_context_create(const air_context_params *params, air_context **out_context)
{
    air_context_params used;
    if (out_context == NULL) {
        return AIR_ERROR_ARGUMENT;
    }
    *out_context = NULL;
    if (params != NULL) {
        used = *params;
    } else {
        air_context_params_default(&used);
    }
    const air_status status = check_params(&used);
    if (status != AIR_OK) {
        return status;
    }
    air_context boot = {.params = used}; /* air_allocate wants a context to allocate from */
    air_context *context = air_allocate(&boot, 1, sizeof *context);
    if (context == NULL) {
        return refuse(&used, AIR_ERROR_MEMORY, "context: out of memory");
    }
    context->params = used;
    context->cpu = used.cpu != AIR_CPU_AUTO ? used.cpu : air_cpu_detect();
    context->ray_backend = used.ray_backend != NULL ? *used.ray_backend : air_ray_embree();
    if (!create_locks(context)) {
        air_free(&boot, context);
        return refuse(&used, AIR_ERROR_MEMORY, "context: no mutex could be made");
    }
    *out_context = context;
    return AIR_OK;
}

void air_context_destroy(air_context *context)
{
    if (context == NULL) {
        return;
    }
    while (context->errors != NULL) {
        air_thread_error *next = context->errors->next;
        air_free(context, context->errors);
        context->errors = next;
    }
    (void)pthread_mutex_destroy(&context->error_lock_storage);
    (void)pthread_mutex_destroy(&context->callback_lock);
    air_context boot = {.params = context->params};
    air_free(&boot, context);
}

size_t air_context_thread_count(const air_context *context)
{
    return context != NULL ? context->params.thread_count : 0;
}

air_cpu air_context_cpu(const air_context *context)
{
    return context != NULL ? context->cpu : AIR_CPU_AUTO;
}

const air_ray_backend *air_context_ray_backend(const air_context *context)
{
    return &context->ray_backend;
}

double air_clock(air_context *context)
{
    if (context->params.clock != NULL) {
        return context->params.clock(context->params.clock_user);
    }
    struct timespec now = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
