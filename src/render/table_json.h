/* table_json.h: what files of tables have in common (docs/table-format.md). */
#ifndef AIR_RENDER_TABLE_JSON_H
#define AIR_RENDER_TABLE_JSON_H

#include <jansson.h>

#include "airlight/context.h"

/* An object with the format's version and a kind. */
json_t *air_table_json_new(const char *kind);

/* Writes and releases root; the file appears whole or not at all. */
air_status air_table_json_write(air_context *context, json_t *root, const char *path);

/* The object in a file of the right version; the caller releases it (NULL on failure). */
air_status air_table_json_read(air_context *context, const char *path, json_t **out_root);

/* "PATH: PLACE: expected WHAT". */
air_status air_table_json_wrong(air_context *context, const char *path, const char *place,
                                const char *expected);

/* The index of a text among names; count if it is none of them. */
size_t air_table_json_index(const json_t *text, const char *const *names, size_t count);

/* Reads root[name], an array of `count` numbers in [least, largest]. */
air_status air_table_json_numbers(air_context *context, const char *path, const json_t *root,
                                  const char *name, double least, double largest, size_t count,
                                  double *out);

#endif
