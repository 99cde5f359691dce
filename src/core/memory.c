/* memory.c: checked sizes on top of the context's allocator. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/context_state.h"

/* count * size, at least 1; false on overflow. */
static bool byte_count(size_t count, size_t size, size_t *out_bytes)
{
    if (size != 0 && count > SIZE_MAX / size) {
        return false;
    }
    *out_bytes = count * size;
    if (*out_bytes == 0) {
        *out_bytes = 1;
    }
    return true;
}

void *air_allocate(air_context *context, size_t count, size_t size)
{
    size_t bytes = 0;
    if (!byte_count(count, size, &bytes)) {
        return NULL;
    }
    if (context->params.reallocate == NULL) {
        return calloc(1,
                      bytes); /* large blocks come zeroed from the system without being touched */
    }
    void *pointer = context->params.reallocate(context->params.allocate_user, NULL, bytes);
    if (pointer != NULL) {
        memset(pointer, 0, bytes);
    }
    return pointer;
}

void *air_reallocate(air_context *context, void *pointer, size_t count, size_t size)
{
    size_t bytes = 0;
    if (!byte_count(count, size, &bytes)) {
        return NULL;
    }
    if (context->params.reallocate == NULL) {
        return realloc(pointer, bytes);
    }
    return context->params.reallocate(context->params.allocate_user, pointer, bytes);
}

void air_free(air_context *context, void *pointer)
{
    if (pointer == NULL) {
        return;
    }
    if (context->params.reallocate == NULL) {
        free(pointer);
    } else {
        (void)context->params.reallocate(context->params.allocate_user, pointer, 0);
    }
}

double air_machine_memory(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (double)pages * (double)size : 0.0;
}

char *air_string_copy(air_context *context, const char *text)
{
    const size_t size = text != NULL ? strlen(text) + 1 : 1;
    char *copy = air_allocate(context, size, 1);
    if (copy != NULL && text != NULL) {
        memcpy(copy, text, size);
    }
    return copy;
}

char *air_string_format(air_context *context, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (length < 0) {
        return NULL;
    }
    const size_t size = (size_t)length + 1;
    char *text = air_allocate(context, size, 1);
    if (text != NULL) {
        va_start(arguments, format);
        (void)vsnprintf(text, size, format, arguments);
        va_end(arguments);
    }
    return text;
}
