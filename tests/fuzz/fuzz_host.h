/* fuzz_host.h: what all harnesses share: files in memory and a bound on memory. */
#ifndef AIR_TESTS_FUZZ_HOST_H
#define AIR_TESTS_FUZZ_HOST_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/context.h"

/* One allocation may have this much: enough for the files of a corpus, and no reason to run out of
 * memory. */
enum { FUZZ_MAX_ALLOCATION = 1 << 26, FUZZ_MAX_FILES = 5 };

typedef struct fuzz_file {
    const char *ending; /* of the paths that give this file; "": of all */
    const void *data;
    size_t size;
} fuzz_file;

typedef struct fuzz_files {
    fuzz_file files[FUZZ_MAX_FILES];
    size_t count;
} fuzz_files;

static inline void *fuzz_reallocate(void *user, void *pointer, size_t size)
{
    (void)user;
    if (size == 0) {
        free(pointer);
        return NULL;
    }
    return size <= FUZZ_MAX_ALLOCATION ? realloc(pointer, size) : NULL;
}

static inline air_status fuzz_read(void *user, air_context *context, const char *path,
                                   void **out_data, size_t *out_size)
{
    const fuzz_files *self = user;
    const size_t length = strlen(path);
    (void)context;
    for (size_t i = 0; i < self->count; ++i) {
        const fuzz_file *file = &self->files[i];
        const size_t ending = strlen(file->ending);
        if (length < ending || strcmp(path + length - ending, file->ending) != 0)
            continue;
        void *copy = malloc(file->size + 1);
        if (copy == NULL)
            return AIR_ERROR_MEMORY;
        if (file->size > 0)
            memcpy(copy, file->data, file->size);
        *out_data = copy;
        *out_size = file->size;
        return AIR_OK;
    }
    return AIR_ERROR_IO;
}

/* A context of one thread that reads these files; backend NULL: Embree. NULL when out of memory. */
static inline air_context *fuzz_context(fuzz_files *files, const air_ray_backend *backend)
{
    air_context_params params;
    air_context *context = NULL;
    air_context_params_default(&params);
    params.thread_count = 1;
    params.reallocate = fuzz_reallocate;
    params.read_file = fuzz_read;
    params.read_user = files;
    params.ray_backend = backend;
    (void)air_context_create(&params, &context);
    return context;
}

/* A loader gives a result or an error, never both or neither, and an error says something. */
static inline void fuzz_check_outcome(air_context *context, air_status status, const void *result)
{
    if ((status == AIR_OK) != (result != NULL) ||
        (status != AIR_OK && air_context_last_error(context)[0] == '\0'))
        abort();
}

#endif
