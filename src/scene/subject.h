/* subject.h: messages about an object of a scene: which object, which field, what was expected. */
#ifndef AIR_SCENE_SUBJECT_H
#define AIR_SCENE_SUBJECT_H

#include "core/host.h"

/* Whom a message is about. */
typedef struct air_subject {
    air_context *context;
    const char *kind; /* "mesh" */
    const char *name; /* may be NULL or "" */
} air_subject;

/* air_fail with AIR_ERROR_ARGUMENT and 'KIND "NAME": ' before the sentence. */
air_status air_subject_fail(const air_subject *subject, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Fails unless all values are finite and in [low, high]; low -INFINITY and high INFINITY leave that
 * side open. */
air_status air_subject_check(const air_subject *subject, const char *field, const float *values,
                             size_t count, float low, float high);

/* Fails unless value is one of 0 .. count-1. */
air_status air_subject_check_enum(const air_subject *subject, const char *field, int value,
                                  int count);

/* Fails unless the affine map is finite and invertible. */
air_status air_subject_check_map(const air_subject *subject, const char *field,
                                 const float map[12]);

#endif
