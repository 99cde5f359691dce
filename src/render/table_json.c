#include "render/table_json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/host.h"

enum { VERSION = 1 };

json_t *air_table_json_new(const char *kind)
{
    json_t *root = json_object();
    json_object_set_new(root, "airlight_table", json_integer(VERSION));
    json_object_set_new(root, "kind", json_string(kind));
    return root;
}

air_status air_table_json_write(air_context *context, json_t *root, const char *path)
{
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17));
    json_decref(root);
    if (text == NULL) {
        return air_fail_memory(context, path);
    }
    const air_status status = air_file_write(context, path, text, strlen(text));
    free(text);
    return status;
}

air_status air_table_json_wrong(air_context *context, const char *path, const char *place,
                                const char *expected)
{
    return air_fail(context, AIR_ERROR_FORMAT, "%s: %s: expected %s", path, place, expected);
}

air_status air_table_json_read(air_context *context, const char *path, json_t **out_root)
{
    void *data = NULL;
    size_t size = 0;
    json_error_t error;
    *out_root = NULL;
    const air_status status = air_file_read(context, path, &data, &size);
    if (status != AIR_OK) {
        return status;
    }
    json_t *root = json_loadb(data, size, JSON_REJECT_DUPLICATES, &error);
    air_free(context, data);
    if (root == NULL) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s:%d:%d: not JSON: %s", path, error.line,
                        error.column, error.text);
    }
    const json_t *version = json_object_get(root, "airlight_table");
    if (!json_is_integer(version) || json_integer_value(version) != VERSION) {
        json_decref(root);
        return air_table_json_wrong(context, path, "\"airlight_table\"", "the version number 1");
    }
    *out_root = root;
    return AIR_OK;
}

size_t air_table_json_index(const json_t *text, const char *const *names, size_t count)
{
    size_t i = 0;
    while (i < count && (!json_is_string(text) || strcmp(json_string_value(text), names[i]) != 0)) {
        i++;
    }
    return i;
}

void air_table_json_add_column(json_t *root, const air_table_column *column, const void *records,
                               size_t count, size_t size)
{
    json_t *array = json_array();
    for (size_t k = 0; k < count; k++) {
        double value;
        memcpy(&value, (const char *)records + k * size + column->offset, sizeof value);
        json_array_append_new(array, json_real(value));
    }
    json_object_set_new(root, column->name, array);
}

air_status air_table_json_read_column(air_context *context, const char *path, const json_t *root,
                                      const air_table_column *column, void *records, size_t count,
                                      size_t size)
{
    char place[64], expected[96];
    const json_t *array = json_object_get(root, column->name);
    snprintf(place, sizeof place, "\"%s\"", column->name);
    if (!json_is_array(array) || json_array_size(array) != count) {
        snprintf(expected, sizeof expected, "an array of %zu numbers", count);
        return air_table_json_wrong(context, path, place, expected);
    }
    for (size_t k = 0; k < count; k++) {
        const json_t *item = json_array_get(array, k);
        const double value = json_number_value(item);
        if (!json_is_number(item) || !(value >= column->least) || !(value <= column->largest)) {
            snprintf(place, sizeof place, "\"%s\"[%zu]", column->name, k);
            snprintf(expected, sizeof expected, "a number from %g to %g", column->least,
                     column->largest);
            return air_table_json_wrong(context, path, place, expected);
        }
        memcpy((char *)records + k * size + column->offset, &value, sizeof value);
    }
    return AIR_OK;
}

air_status air_table_json_check_knot(air_context *context, const char *path, const char *name,
                                     size_t k, double value, double knot)
{
    char place[64], expected[64];
    if (fabs(value - knot) < 1e-9) {
        return AIR_OK;
    }
    snprintf(place, sizeof place, "\"%s\"[%zu]", name, k);
    snprintf(expected, sizeof expected, "the knot %.9f", knot);
    return air_table_json_wrong(context, path, place, expected);
}
