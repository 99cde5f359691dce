/* status.h: what a fallible function returns.
 *
 * Every fallible airlight function returns an air_status; AIR_OK is 0. The sentence that says which
 * file, which place and what was expected goes to the context's message callback and is kept per
 * thread (air_context_last_error). */
#ifndef AIRLIGHT_STATUS_H
#define AIRLIGHT_STATUS_H

#if defined(__GNUC__) && !defined(AIR_STATIC)
#define AIR_API __attribute__((visibility("default")))
#else
#define AIR_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum air_status {
    AIR_OK = 0,
    AIR_ERROR_ARGUMENT = 1,    /* a parameter is out of its stated range */
    AIR_ERROR_MEMORY = 2,      /* an allocation failed */
    AIR_ERROR_IO = 3,          /* a file could not be opened, read or written */
    AIR_ERROR_FORMAT = 4,      /* a file's content is not what its format demands */
    AIR_ERROR_UNSUPPORTED = 5, /* valid, but not supported by this build */
    AIR_ERROR_INTERRUPTED = 6, /* the progress callback asked to stop */
    AIR_ERROR_INTERNAL = 7     /* a library below failed in a way it should not */
} air_status;

/* The status as a short English word, "ok" for AIR_OK. Static storage; thread-safe. */
AIR_API const char *air_status_name(air_status status);

#ifdef __cplusplus
}
#endif
#endif
