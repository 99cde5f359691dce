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

/* A column of the file, and where a record, a struct of doubles, keeps it. */
typedef struct air_table_column {
    const char *name;
    size_t offset;
    double least, largest;
} air_table_column;

/* root[name]: an array of what all records keep. records: count of them, size bytes apart. */
void air_table_json_add_column(json_t *root, const air_table_column *column, const void *records,
                               size_t count, size_t size);

/* The way back: an array of count numbers in [least, largest]. */
air_status air_table_json_read_column(air_context *context, const char *path, const json_t *root,
                                      const air_table_column *column, void *records, size_t count,
                                      size_t size);

/* Is an axis' number k, as read, the knot that it should be? */
air_status air_table_json_check_knot(air_context *context, const char *path, const char *name,
                                     size_t k, double value, double knot);

#endif
