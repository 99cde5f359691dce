/* impulse_table_file.c: tables of impulse responses: one line of JSON, then the numbers as they are
 * (docs/table-format.md). */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/host.h"
#include "impulse/tables.h"
#include "render/table_json.h"

static const char *const form_names[AIR_IMPULSE_FORMS] = {"sh5", "sh3", "zh11-energy",
                                                          "zh11-irradiance"};

/* Numbers beyond this are no response: the largest are some 100. */
static const float largest_entry = 1e6f;

enum { HEADER_MAX = 8192 };

/* ---- writing ---- */

static json_t *describe(const air_impulse_params *p)
{
    json_t *const root = air_table_json_new("impulse");
    json_t *const g = json_array();
    json_object_set_new(root, "form", json_string(form_names[p->form]));
    json_object_set_new(root, "bins", json_integer((json_int_t)p->bins));
    json_object_set_new(root, "angles", json_integer((json_int_t)p->angles));
    json_object_set_new(root, "bounces", json_integer(p->bounces));
    for (size_t i = 0; i < p->g_count; i++) {
        json_array_append_new(g, json_real(p->g[i]));
    }
    json_object_set_new(root, "g", g);
    return root;
}

static void put_float(float value, unsigned char *out)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++) {
        out[i] = (unsigned char)(bits >> (8 * i));
    }
}

static float get_float(const unsigned char *from)
{
    uint32_t bits = 0;
    float value;
    for (int i = 0; i < 4; i++) {
        bits |= (uint32_t)from[i] << (8 * i);
    }
    memcpy(&value, &bits, sizeof value);
    return value;
}

static size_t total_floats(const air_impulse_tables *tables)
{
    size_t sum = 0;
    for (size_t i = 0; i < TABLES_PARTS; i++) {
        size_t count;
        (void)impulse_tables_part(tables, i, &count);
        sum += count;
    }
    return sum;
}

air_status air_impulse_tables_save(air_context *context, const air_impulse_tables *tables,
                                   const char *path)
{
    json_t *const root = describe(&tables->params);
    char *const header = json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(root);
    const size_t length = header == NULL ? 0 : strlen(header) + 1;
    const size_t size = length + 4 * total_floats(tables);
    unsigned char *const data = header == NULL ? NULL : air_allocate(context, size, 1);
    air_status status = AIR_OK;
    if (data == NULL) {
        status = air_fail_memory(context, path);
    } else {
        unsigned char *at = data + length;
        memcpy(data, header, length - 1);
        data[length - 1] = '\n';
        for (size_t i = 0; i < TABLES_PARTS; i++) {
            size_t count;
            const float *const part = impulse_tables_part(tables, i, &count);
            for (size_t j = 0; j < count; j++, at += 4) {
                put_float(part[j], at);
            }
        }
        status = air_file_write(context, path, data, size);
    }
    air_free(context, data);
    free(header);
    return status;
}

/* ---- reading ---- */

static bool read_size(const json_t *root, const char *name, size_t *out)
{
    const json_t *const item = json_object_get(root, name);
    const json_int_t value = json_integer_value(item);
    *out = value >= 0 && value <= 100000 ? (size_t)value : 0;
    return json_is_integer(item) && value >= 0 && value <= 100000;
}

/* What the header says; ranges are checked when memory is asked for. */
static air_status read_header(air_context *context, const char *path, const json_t *root,
                              air_impulse_params *out)
{
    static const char *const kinds[] = {"impulse"};
    const json_t *const version = json_object_get(root, "airlight_table");
    const json_t *const g = json_object_get(root, "g");
    size_t bounces;
    if (!json_is_integer(version) || json_integer_value(version) != 1) {
        return air_table_json_wrong(context, path, "\"airlight_table\"", "the version number 1");
    }
    if (air_table_json_index(json_object_get(root, "kind"), kinds, 1) == 1) {
        return air_table_json_wrong(context, path, "\"kind\"", "\"impulse\"");
    }
    const size_t form =
        air_table_json_index(json_object_get(root, "form"), form_names, AIR_IMPULSE_FORMS);
    if (form == AIR_IMPULSE_FORMS) {
        return air_table_json_wrong(context, path, "\"form\"",
                                    "\"sh5\", \"sh3\", \"zh11-energy\" or \"zh11-irradiance\"");
    }
    out->form = (air_impulse_form)form;
    if (!read_size(root, "bins", &out->bins) || !read_size(root, "angles", &out->angles) ||
        !read_size(root, "bounces", &bounces)) {
        return air_table_json_wrong(context, path, "\"bins\", \"angles\", \"bounces\"",
                                    "whole numbers");
    }
    out->bounces = (int)bounces;
    out->g_count = json_array_size(g);
    if (!json_is_array(g) || out->g_count < 1 || out->g_count > AIR_IMPULSE_G_MAX) {
        return air_table_json_wrong(context, path, "\"g\"", "an array of 1 to 32 numbers");
    }
    for (size_t i = 0; i < out->g_count; i++) {
        const json_t *const item = json_array_get(g, i);
        if (!json_is_number(item)) {
            return air_table_json_wrong(context, path, "\"g\"", "numbers");
        }
        out->g[i] = json_number_value(item);
    }
    return AIR_OK;
}

/* Memory only for what the file holds. */
static air_status allocate(air_context *context, const char *path, const air_impulse_params *params,
                           size_t start, size_t size, air_impulse_tables **out)
{
    air_impulse_tables shape;
    const air_status status = impulse_tables_shape(context, params, &shape);
    if (status != AIR_OK) { /* it said which number */
        return AIR_ERROR_FORMAT;
    }
    if (size != 4 * total_floats(&shape)) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte %zu: expected %zu bytes of numbers, not %zu", path, start,
                        4 * total_floats(&shape), size);
    }
    return impulse_tables_allocate(context, params, out);
}

static air_status read_floats(air_context *context, const char *path, const unsigned char *at,
                              size_t start, air_impulse_tables *out)
{
    size_t place = 0;
    for (size_t i = 0; i < TABLES_PARTS; i++) {
        size_t count;
        float *const part = impulse_tables_part(out, i, &count);
        for (size_t j = 0; j < count; j++, place += 4) {
            part[j] = get_float(at + place);
            if (!(part[j] >= -largest_entry && part[j] <= largest_entry)) {
                return air_fail(context, AIR_ERROR_FORMAT,
                                "%s: byte %zu: expected a number of at most %g in size", path,
                                start + place, (double)largest_entry);
            }
        }
    }
    return AIR_OK;
}

/* The first line as JSON; NULL where it is none. */
static json_t *first_line(const unsigned char *data, size_t size, size_t *out_length,
                          json_error_t *error)
{
    const size_t seen = size < HEADER_MAX ? size : HEADER_MAX;
    const unsigned char *const end = seen == 0 ? NULL : memchr(data, '\n', seen);
    *out_length = end == NULL ? 0 : (size_t)(end - data);
    return end == NULL ? NULL
                       : json_loadb((const char *)data, *out_length, JSON_REJECT_DUPLICATES, error);
}

static air_status parse(air_context *context, const char *path, const unsigned char *data,
                        size_t size, air_impulse_tables **out)
{
    json_error_t error;
    size_t length;
    air_impulse_params params = {.bins = 0};
    air_impulse_tables *tables = NULL;
    json_t *const root = first_line(data, size, &length, &error);
    if (root == NULL && length == 0) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte 0: expected one line of JSON before the numbers", path);
    }
    if (root == NULL) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s:%d:%d: not JSON: %s", path, error.line,
                        error.column, error.text);
    }
    air_status status = read_header(context, path, root, &params);
    json_decref(root);
    if (status == AIR_OK) {
        status = allocate(context, path, &params, length + 1, size - length - 1, &tables);
    }
    if (status == AIR_OK) {
        status = read_floats(context, path, data + length + 1, length + 1, tables);
    }
    if (status != AIR_OK) {
        air_impulse_tables_destroy(tables);
        return status;
    }
    *out = tables;
    return AIR_OK;
}

air_status air_impulse_tables_load(air_context *context, const char *path, air_impulse_tables **out)
{
    void *data = NULL;
    size_t size = 0;
    *out = NULL;
    air_status status = air_file_read(context, path, &data, &size);
    if (status == AIR_OK) {
        status = parse(context, path, data, size, out);
    }
    air_free(context, data);
    return status;
}

air_status air_impulse_is_tables(air_context *context, const char *path, bool *out_is)
{
    static const char *const kinds[] = {"impulse"};
    void *data = NULL;
    size_t size = 0, length;
    json_error_t error;
    *out_is = false;
    const air_status status = air_file_read(context, path, &data, &size);
    if (status == AIR_OK) {
        json_t *const root = first_line(data, size, &length, &error);
        *out_is = air_table_json_index(json_object_get(root, "kind"), kinds, 1) == 0;
        json_decref(root);
    }
    air_free(context, data);
    return status;
}
