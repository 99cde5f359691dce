/* context_state.h: what is inside an air_context; only src/core looks. */
#ifndef AIR_CORE_CONTEXT_STATE_H
#define AIR_CORE_CONTEXT_STATE_H

#include <pthread.h>

#include "core/host.h"

enum { AIR_MESSAGE_SIZE = 2048 };

/* The last error of one thread. */
typedef struct air_thread_error {
    struct air_thread_error *next;
    pthread_t thread;
    char text[AIR_MESSAGE_SIZE];
} air_thread_error;

struct air_context {
    air_context_params
        params; /* as given; reallocate, parallel_for, clock, read_file may be NULL: built in */
    air_ray_backend ray_backend;
    air_cpu cpu; /* never AUTO */

    /* Entries live as long as the context. The lock is reached through a pointer as const queries
     * take it too. */
    air_thread_error *errors;
    pthread_mutex_t error_lock_storage;
    pthread_mutex_t *error_lock;

    /* Held while a message or progress callback runs; recursive, as a callback may call the
     * library. */
    pthread_mutex_t callback_lock;
};

#endif
