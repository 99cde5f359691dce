/* frame.c: the paths of a sequence of files. */
#include "airlight/frame.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "core/host.h"

static const char *last_part(const char *path)
{
    const char *const slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

/* Where the run begins, NULL if there is none. */
static air_status find_run(air_context *context, const char *path, const char **out_run,
                           size_t *out_digits)
{
    const char *const run = strchr(last_part(path), '#');
    const size_t digits = run != NULL ? strspn(run, "#") : 0;
    if (digits > AIR_FRAME_DIGITS_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: %zu # in a run, expected at most %d for the number of a frame", path,
                        digits, (int)AIR_FRAME_DIGITS_MAX);
    }
    if (run != NULL && strchr(run + digits, '#') != NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: several runs of # in the name, expected one for the number of a frame",
                        path);
    }
    *out_run = run;
    *out_digits = digits;
    return AIR_OK;
}

air_status air_frame_digits(air_context *context, const char *path, size_t *out_digits)
{
    const char *run;
    if (path == NULL || out_digits == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "frame digits: a pointer given is NULL");
    }
    return find_run(context, path, &run, out_digits);
}

air_status air_frame_path(air_context *context, const char *path, int64_t frame, char *buffer,
                          size_t size)
{
    const char *run;
    size_t digits;
    char number[24];
    if (path == NULL || buffer == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "frame path: a pointer given is NULL");
    }
    const air_status status = find_run(context, path, &run, &digits);
    if (status != AIR_OK) {
        return status;
    }
    if (frame < 0 || frame > AIR_FRAME_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%s: frame %" PRId64 ", expected 0 to %d",
                        path, frame, (int)AIR_FRAME_MAX);
    }
    snprintf(number, sizeof number, "%0*" PRId64, (int)digits, frame);
    const size_t before = run != NULL ? (size_t)(run - path) : strlen(path);
    const size_t inserted = run != NULL ? strlen(number) : 0;
    const size_t after = strlen(path) - before - digits;
    if (before + inserted + after >= size) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: at frame %" PRId64 " the path has %zu bytes, expected at most %zu",
                        path, frame, before + inserted + after, size > 0 ? size - 1 : 0);
    }
    memcpy(buffer, path, before);
    memcpy(buffer + before, number, inserted);
    memcpy(buffer + before + inserted, path + before + digits, after + 1);
    return AIR_OK;
}
