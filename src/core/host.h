/* host.h: what the rest of the library asks of the context: memory, messages, threads, clock,
 * files. */
#ifndef AIR_CORE_HOST_H
#define AIR_CORE_HOST_H

#include <stdarg.h>
#include <stdint.h>

#include "airlight/context.h"

/* count*size bytes set to 0, NULL when that overflows or fails (no message). count 0 gives a valid
 * pointer. */
void *air_allocate(air_context *context, size_t count, size_t size);
/* Grows or shrinks; new bytes are not set. On failure the old block stays. */
void *air_reallocate(air_context *context, void *pointer, size_t count, size_t size);
void air_free(air_context *context, void *pointer);
/* The first place in a block that kernels' lanes may load from: AIR_ALIGNMENT - 1 bytes further on
 * at most, which are to be allocated beside what is wanted. */
enum { AIR_ALIGNMENT = 64 };
static inline void *air_align(void *block)
{
    return (char *)block + (AIR_ALIGNMENT - (uintptr_t)block % AIR_ALIGNMENT) % AIR_ALIGNMENT;
}
/* Bytes of memory that the machine has, whoever uses them; 0: not known. */
double air_machine_memory(void);
char *air_string_copy(air_context *context, const char *text); /* NULL gives "" */
/* printf into a fresh string; NULL on failure. */
char *air_string_format(air_context *context, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Keeps the sentence as the thread's last error, sends it to the message callback, returns status.
 * A NULL context hears nothing: kernels do without one. */
air_status air_fail(air_context *context, air_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* air_fail(AIR_ERROR_MEMORY) with "what: out of memory". */
air_status air_fail_memory(air_context *context, const char *what);
void air_warn(air_context *context, const char *format, ...) __attribute__((format(printf, 2, 3)));
void air_inform(air_context *context, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void air_parallel_for(air_context *context, size_t count,
                      void (*body)(void *user, size_t index, size_t worker), void *user);
double air_clock(air_context *context);
/* True: go on. */
bool air_progress(air_context *context, double fraction, const char *what);
const air_ray_backend *air_context_ray_backend(const air_context *context);

/* Reads a whole file through the context's reader; free *out_data with air_free. One NUL byte
 * follows the data. */
air_status air_file_read(air_context *context, const char *path, void **out_data, size_t *out_size);

/* The same for a file that may be absent: then AIR_OK, *out_data NULL, *out_size 0 and no message.
 * Absent means ENOENT to the file system and AIR_ERROR_IO to a reader of the host's. */
air_status air_file_read_optional(air_context *context, const char *path, void **out_data,
                                  size_t *out_size);

/* Writes beside `path`, then renames: the file appears whole or not at all. */
air_status air_file_write(air_context *context, const char *path, const void *data, size_t size);

#endif
