/* area_table_file.c: tables of fitted lobes as JSON (docs/table-format.md). */
#include <jansson.h>
#include <string.h>

#include "airlight/area_table.h"
#include "core/host.h"

enum { VERSION = 1 };

static const char *const source_names[] = {"ltsd", "mix"};
static const char *const loss_names[AIR_AREA_LOSSES] = {"kl", "l2", "l3", "cdf-l2"};

/* A column of the file, and where a lobe keeps it. */
typedef struct column {
    const char *name;
    size_t offset;
    double least, largest;
} column;

static const column columns[] = {
    {"g", offsetof(air_area_lobe, g), 0.0, 0.99},
    {"s_near", offsetof(air_area_lobe, s_near), 1e-3, 1e4},
    {"w_near", offsetof(air_area_lobe, w_near), -1.0, 1.0},
    {"s_far", offsetof(air_area_lobe, s_far), 1e-3, 1e4},
    {"w_far", offsetof(air_area_lobe, w_far), -1.0, 1.0},
};
enum { COLUMNS = sizeof columns / sizeof columns[0] };

static double *field(air_area_lobe *lobe, size_t c)
{
    return (double *)((char *)lobe + columns[c].offset);
}

/* ---- writing ---- */

static json_t *describe(const air_area_table *table)
{
    json_t *root = json_object();
    json_object_set_new(root, "airlight_table", json_integer(VERSION));
    json_object_set_new(root, "kind", json_string(source_names[table->source]));
    json_object_set_new(root, "loss", json_string(loss_names[table->loss]));
    for (size_t c = 0; c < COLUMNS; c++) {
        json_t *array = json_array();
        for (size_t k = 0; k < AIR_AREA_KNOTS; k++) {
            air_area_lobe lobe = table->knots[k];
            json_array_append_new(array, json_real(*field(&lobe, c)));
        }
        json_object_set_new(root, columns[c].name, array);
    }
    return root;
}

air_status air_area_table_save(air_context *context, const air_area_table *table, const char *path)
{
    if ((unsigned)table->source > AIR_AREA_SOURCE_MIX || (unsigned)table->loss >= AIR_AREA_LOSSES) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%s: only ltsd and mix make tables", path);
    }
    json_t *root = describe(table);
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17));
    json_decref(root);
    if (text == NULL) {
        return air_fail_memory(context, path);
    }
    const air_status status = air_file_write(context, path, text, strlen(text));
    free(text);
    return status;
}

/* ---- reading ---- */

static air_status wrong(air_context *context, const char *path, const char *place,
                        const char *expected)
{
    return air_fail(context, AIR_ERROR_FORMAT, "%s: %s: expected %s", path, place, expected);
}

/* The index of a text among names; count if it is none of them. */
static size_t index_of(const json_t *text, const char *const *names, size_t count)
{
    size_t i = 0;
    while (i < count && (!json_is_string(text) || strcmp(json_string_value(text), names[i]) != 0)) {
        i++;
    }
    return i;
}

static air_status read_column(air_context *context, const char *path, const json_t *root, size_t c,
                              air_area_table *out)
{
    char place[64], expected[96];
    const json_t *array = json_object_get(root, columns[c].name);
    snprintf(place, sizeof place, "\"%s\"", columns[c].name);
    if (!json_is_array(array) || json_array_size(array) != AIR_AREA_KNOTS) {
        snprintf(expected, sizeof expected, "an array of %d numbers", (int)AIR_AREA_KNOTS);
        return wrong(context, path, place, expected);
    }
    for (size_t k = 0; k < AIR_AREA_KNOTS; k++) {
        const json_t *item = json_array_get(array, k);
        const double value = json_number_value(item);
        const double g = 0.99 * (double)k / (AIR_AREA_KNOTS - 1);
        snprintf(place, sizeof place, "\"%s\"[%zu]", columns[c].name, k);
        if (!json_is_number(item) || !(value >= columns[c].least) ||
            !(value <= columns[c].largest)) {
            snprintf(expected, sizeof expected, "a number from %g to %g", columns[c].least,
                     columns[c].largest);
            return wrong(context, path, place, expected);
        }
        if (c == 0 && !(value - g < 1e-9 && g - value < 1e-9)) {
            snprintf(expected, sizeof expected, "the knot %.9f", g);
            return wrong(context, path, place, expected);
        }
        *field(&out->knots[k], c) = value;
    }
    return AIR_OK;
}

static air_status read(air_context *context, const char *path, const json_t *root,
                       air_area_table *out)
{
    const json_t *version = json_object_get(root, "airlight_table");
    if (!json_is_integer(version) || json_integer_value(version) != VERSION) {
        return wrong(context, path, "\"airlight_table\"", "the version number 1");
    }
    const size_t source = index_of(json_object_get(root, "kind"), source_names, 2);
    const size_t loss = index_of(json_object_get(root, "loss"), loss_names, AIR_AREA_LOSSES);
    if (source == 2) {
        return wrong(context, path, "\"kind\"", "\"ltsd\" or \"mix\"");
    }
    if (loss == AIR_AREA_LOSSES) {
        return wrong(context, path, "\"loss\"", "\"kl\", \"l2\", \"l3\" or \"cdf-l2\"");
    }
    out->source = (air_area_source)source;
    out->loss = (air_area_loss)loss;
    air_status status = AIR_OK;
    for (size_t c = 0; c < COLUMNS && status == AIR_OK; c++) {
        status = read_column(context, path, root, c, out);
    }
    return status;
}

air_status air_area_table_load(air_context *context, const char *path, air_area_table *out)
{
    void *data = NULL;
    size_t size = 0;
    json_error_t error;
    air_area_table table;
    air_status status = air_file_read(context, path, &data, &size);
    if (status != AIR_OK) {
        return status;
    }
    json_t *root = json_loadb(data, size, JSON_REJECT_DUPLICATES, &error);
    air_free(context, data);
    if (root == NULL) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s:%d:%d: not JSON: %s", path, error.line,
                        error.column, error.text);
    }
    status = read(context, path, root, &table);
    json_decref(root);
    if (status == AIR_OK) {
        *out = table;
    }
    return status;
}
