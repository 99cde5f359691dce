/* place.h: the JSON files of this room, read strictly: a value and where it stands, for messages.
 */
#ifndef AIR_LIGHTMAP_PLACE_H
#define AIR_LIGHTMAP_PLACE_H

#include <jansson.h>

#include "core/host.h"

enum { AIR_PLACE_TEXT = 160 };

typedef struct air_place {
    air_context *context;
    const char *file;          /* as messages show it */
    char text[AIR_PLACE_TEXT]; /* "$.pages[3].file" */
    json_t *value;             /* borrowed; NULL: absent */
} air_place;

/* Parses a whole text; the caller releases *out_root (json_decref). */
air_status air_place_parse(air_context *context, const char *file, const char *text, size_t size,
                           json_t **out_root);
air_place air_place_root(air_context *context, const char *file, json_t *root);
/* A member or an element; of something absent or of another kind, an absent place. */
air_place air_place_get(const air_place *object, const char *key);
air_place air_place_at(const air_place *array, size_t index);
/* Elements of an array, 0 if it is absent or none. */
size_t air_place_count(const air_place *array);

/* AIR_ERROR_FORMAT with "FILE: PLACE: expected WHAT". */
air_status air_place_wrong(const air_place *at, const char *what, ...)
    __attribute__((format(printf, 2, 3)));

/* All of these want the value to be there. */
air_status air_place_array(const air_place *at);
/* A whole number in [least, largest]. */
air_status air_place_integer(const air_place *at, int64_t least, int64_t largest, int64_t *out);
air_status air_place_size(const air_place *at, size_t largest, size_t *out);
air_status air_place_bool(const air_place *at, bool *out);
/* A copy, freed with air_free. */
air_status air_place_string(const air_place *at, char **out);
/* An array of exactly count numbers that are finite floats. */
air_status air_place_floats(const air_place *at, size_t count, float *out);
/* The same into fresh memory. */
air_status air_place_new_floats(const air_place *at, size_t count, float **out);
/* A plain file name: no folder in it. Borrowed from the JSON. */
air_status air_place_file_name(const air_place *at, const char **out);

/* A JSON string; bytes of a text that is no UTF-8 become '?'. */
json_t *air_place_text(const char *text);
/* An array of count numbers. */
json_t *air_place_numbers(const float *values, size_t count);

#endif
