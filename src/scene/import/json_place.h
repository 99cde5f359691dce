/* json_place.h: JSON values that know where they stand, and typed getters whose errors say so.
 *
 * A place is a value and the way to it; places refer to their parents, which must outlive them. A
 * place whose value is NULL stands for something absent; getting a member of it gives an absent
 * place again. */
#ifndef AIR_SCENE_IMPORT_JSON_PLACE_H
#define AIR_SCENE_IMPORT_JSON_PLACE_H

#include <jansson.h>

#include "core/host.h"

/* Where in a command-line argument a part of the JSON made from it was said. */
typedef struct air_json_column {
    const char *path;   /* ".density.grid.file" */
    const char *option; /* "grid" */
    size_t column;      /* from 1 */
} air_json_column;

/* A JSON text, or a part of one. */
typedef struct air_json_document {
    air_context *context;
    const char *file;   /* as shown in messages */
    const char *prefix; /* path of the root value: "$", or "$.nodes[3].extras.airlight" */
    const char *folder; /* what relative paths start from: "" or with a final slash */
    const air_json_column
        *columns; /* made from a command-line argument: then places are columns; or NULL */
    size_t column_count;
} air_json_document;

typedef struct air_json {
    const air_json_document *document;
    const struct air_json *parent; /* NULL: the root */
    const char *key;               /* NULL: an element of an array */
    size_t index;
    json_t *value; /* borrowed; NULL: absent */
} air_json;

/* What a number may be; all must fit a finite float. */
typedef enum air_json_range {
    AIR_JSON_ANY = 0,
    AIR_JSON_NON_NEGATIVE = 1,
    AIR_JSON_POSITIVE = 2,
    AIR_JSON_UNIT = 3,        /* [0, 1] */
    AIR_JSON_SIGNED_OPEN = 4, /* (-1, 1) */
    AIR_JSON_AT_LEAST_1 = 5
} air_json_range;

/* Parses a whole text; *out_json is a new reference. The message names file, line and column. */
air_status air_json_parse(const air_json_document *document, const char *text, size_t size,
                          json_t **out_json);

air_json air_json_root(const air_json_document *document, json_t *value);
air_json air_json_get(const air_json *object, const char *key);
air_json air_json_at(const air_json *array, size_t index);
/* Elements of an array, 0 if it is absent or none. */
size_t air_json_count(const air_json *array);

/* "$.materials[3].alphaCutoff", or for an argument "column 14 (g)"; always terminated, cut at size.
 */
void air_json_describe(const air_json *at, char *buffer, size_t size);

/* AIR_ERROR_FORMAT with "FILE: PLACE: expected WHAT, found VALUE". */
air_status air_json_expected(const air_json *at, const char *what, ...)
    __attribute__((format(printf, 2, 3)));
/* The given status with "FILE: PLACE: SENTENCE". */
air_status air_json_fail(const air_json *at, air_status status, const char *sentence, ...)
    __attribute__((format(printf, 3, 4)));
/* 'NAME (FILE: PLACE)' as a fresh string, for messages about an object; NULL when memory is out. */
char *air_json_annotate(const air_json *at, const char *name);
/* After a callee failed with a message of its own: says it again with the place before it. */
air_status air_json_place_error(const air_json *at, air_status status);

/* Fails unless the place is absent or an object (array); a required one may not be absent. */
air_status air_json_check_object(const air_json *at, bool required);
air_status air_json_check_array(const air_json *at, bool required);
/* Fails if the object has a key that is not in keys; the message names the nearest one. "comment"
 * is always allowed. */
air_status air_json_check_keys(const air_json *object, const char *const *keys, size_t key_count);

/* Getters by place. An absent place leaves *out as it is; a required one may not be absent. */
air_status air_json_number(const air_json *at, air_json_range range, double *out);
air_status air_json_float(const air_json *at, air_json_range range, float *out);
/* An array of exactly count numbers. */
air_status air_json_floats(const air_json *at, air_json_range range, size_t count, float *out);
/* A number, which stands for three equal ones, or an array of three. */
air_status air_json_color(const air_json *at, air_json_range range, float out[3]);
air_status air_json_bool(const air_json *at, bool *out);
/* Borrowed from the document. */
air_status air_json_string(const air_json *at, const char **out);
/* A whole number in [0, 2^53]. */
air_status air_json_size(const air_json *at, size_t *out);
/* A whole number below limit; what: "a node". */
air_status air_json_index(const air_json *at, size_t limit, const char *what, size_t *out);
/* One of count names; *out is its index. */
air_status air_json_choice(const air_json *at, const char *const *names, size_t count, size_t *out);
/* Fails if absent. */
air_status air_json_require(const air_json *at, const char *what);

/* The name nearest to `text` if it is near enough to be a slip of the pen, or NULL. */
const char *air_nearest_name(const char *text, const char *const *names, size_t count);

#endif
