/* message.c: errors, warnings and progress to the host; the last error of each thread. */
#include <stdio.h>
#include <string.h>

#include "core/context_state.h"

/* Formats into text[AIR_MESSAGE_SIZE]; what is too long ends in "...". */
__attribute__((format(printf, 2, 0))) static void format_text(char *text, const char *format,
                                                              va_list arguments)
{
    const int length = vsnprintf(text, AIR_MESSAGE_SIZE, format, arguments);
    if (length < 0) {
        text[0] = '\0';
    } else if (length >= AIR_MESSAGE_SIZE) {
        memcpy(text + AIR_MESSAGE_SIZE - 4, "...", 4);
    }
}

static void send(air_context *context, air_message_level level, const char *text)
{
    if (context->params.message == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&context->callback_lock);
    context->params.message(context->params.message_user, level, text);
    (void)pthread_mutex_unlock(&context->callback_lock);
}

/* The calling thread's entry, NULL if it has none. error_lock is held. */
static air_thread_error *find_error(const air_context *context)
{
    const pthread_t self = pthread_self();
    air_thread_error *entry = context->errors;
    while (entry != NULL && !pthread_equal(entry->thread, self)) {
        entry = entry->next;
    }
    return entry;
}

static void keep_error(air_context *context, const char *text)
{
    (void)pthread_mutex_lock(context->error_lock);
    air_thread_error *entry = find_error(context);
    if (entry == NULL) {
        entry = air_allocate(context, 1, sizeof *entry);
        if (entry != NULL) {
            entry->thread = pthread_self();
            entry->next = context->errors;
            context->errors = entry;
        }
    }
    if (entry != NULL) {
        memcpy(entry->text, text, strlen(text) + 1);
    }
    (void)pthread_mutex_unlock(context->error_lock);
}

air_status air_fail(air_context *context, air_status status, const char *format, ...)
{
    char text[AIR_MESSAGE_SIZE]; /* the arguments may point into the text that is being replaced */
    va_list arguments;
    if (context == NULL) {
        return status;
    }
    va_start(arguments, format);
    format_text(text, format, arguments);
    va_end(arguments);
    keep_error(context, text);
    send(context, AIR_MESSAGE_ERROR, text);
    return status;
}

air_status air_fail_memory(air_context *context, const char *what)
{
    return air_fail(context, AIR_ERROR_MEMORY, "%s: out of memory", what);
}

void air_warn(air_context *context, const char *format, ...)
{
    char text[AIR_MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    format_text(text, format, arguments);
    va_end(arguments);
    send(context, AIR_MESSAGE_WARNING, text);
}

void air_inform(air_context *context, const char *format, ...)
{
    char text[AIR_MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    format_text(text, format, arguments);
    va_end(arguments);
    send(context, AIR_MESSAGE_INFO, text);
}

bool air_progress(air_context *context, double fraction, const char *what)
{
    if (context->params.progress == NULL) {
        return true;
    }
    (void)pthread_mutex_lock(&context->callback_lock);
    const bool go_on = context->params.progress(context->params.progress_user, fraction, what);
    (void)pthread_mutex_unlock(&context->callback_lock);
    return go_on;
}

const char *air_context_last_error(const air_context *context)
{
    if (context == NULL) {
        return "";
    }
    (void)pthread_mutex_lock(context->error_lock);
    const air_thread_error *entry = find_error(context);
    (void)pthread_mutex_unlock(context->error_lock);
    return entry != NULL ? entry->text : "";
}
