/* memory_files.h: a context that reads one file from memory, and counts what it allocates, for
 * tests of loaders. */
#ifndef AIR_TESTS_MEMORY_FILES_H
#define AIR_TESTS_MEMORY_FILES_H

#include <string.h>

#include "cmocka_test.h"
#include "core/host.h"
#include "failing_allocator.h"

typedef struct memory_file {
    failing_allocator allocator;
    const void *data; /* what every path holds */
    size_t size;
    size_t warning_count;
    char warning[512]; /* the last one */
    air_context *context;
} memory_file;

static inline air_status memory_file_read(void *user, air_context *context, const char *path,
                                          void **out_data, size_t *out_size)
{
    const memory_file *self = user;
    (void)path;
    void *copy = air_allocate(context, self->size + 1, 1);
    if (copy == NULL) {
        return AIR_ERROR_MEMORY;
    }
    if (self->size > 0) {
        memcpy(copy, self->data, self->size);
    }
    *out_data = copy;
    *out_size = self->size;
    return AIR_OK;
}

static inline void memory_file_message(void *user, air_message_level level, const char *text)
{
    memory_file *self = user;
    if (level == AIR_MESSAGE_WARNING) {
        self->warning_count++;
        strncpy(self->warning, text, sizeof self->warning - 1);
    }
}

static inline void memory_file_init(memory_file *self)
{
    *self = (memory_file){0};
    air_context_params params = failing_params(&self->allocator, 1000000000);
    params.read_file = memory_file_read;
    params.read_user = self;
    params.message = memory_file_message;
    params.message_user = self;
    params.thread_count = 1;
    assert_int_equal(air_context_create(&params, &self->context), AIR_OK);
}

/* Fails the test if anything allocated was not freed. */
static inline void memory_file_finish(memory_file *self)
{
    air_context_destroy(self->context);
    assert_int_equal(atomic_load(&self->allocator.live), 0);
}

static inline void memory_file_serve(memory_file *self, const void *data, size_t size)
{
    self->data = data;
    self->size = size;
}

static inline void memory_file_expect(const memory_file *self, const char *part)
{
    const char *message = air_context_last_error(self->context);
    if (strstr(message, part) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", message, part);
    }
}

#endif
