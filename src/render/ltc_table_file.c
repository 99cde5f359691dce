/* ltc_table_file.c: tables of transformed cosines as JSON (docs/table-format.md). */
#include <math.h>
#include <stdlib.h>

#include "airlight/area_ltc.h"
#include "core/host.h"
#include "render/table_json.h"

enum { SIDE = AIR_LTC_SIDE, KNOTS = SIDE * SIDE };

/* A column of the file: one number of every knot, alpha by alpha. */
typedef struct column {
    const char *name;
    size_t offset;
    double least, largest;
} column;

static const column columns[] = {
    {"xx", offsetof(air_area_ltc, xx), -1e4, 1e4},
    {"xz", offsetof(air_area_ltc, xz), -1e4, 1e4},
    {"zx", offsetof(air_area_ltc, zx), -1e4, 1e4},
    {"zz", offsetof(air_area_ltc, zz), -1e4, 1e4},
    {"albedo", offsetof(air_area_ltc, albedo), 0.0, 1.001}, /* by a quadrature */
};
enum { COLUMNS = sizeof columns / sizeof columns[0] };

static double *field(air_area_ltc *knot, size_t c)
{
    return (double *)((char *)knot + columns[c].offset);
}

static json_t *axis(double (*knot)(size_t))
{
    json_t *array = json_array();
    for (size_t k = 0; k < SIDE; k++) {
        json_array_append_new(array, json_real(knot(k)));
    }
    return array;
}

air_status air_area_ltc_table_save(air_context *context, const air_area_ltc_table *table,
                                   const char *path)
{
    json_t *root = air_table_json_new("ltc");
    json_object_set_new(root, "alpha", axis(air_area_ltc_knot_alpha));
    json_object_set_new(root, "cos_o", axis(air_area_ltc_knot_cosine));
    for (size_t c = 0; c < COLUMNS; c++) {
        json_t *array = json_array();
        for (size_t k = 0; k < KNOTS; k++) {
            air_area_ltc knot = table->knots[k / SIDE][k % SIDE];
            json_array_append_new(array, json_real(*field(&knot, c)));
        }
        json_object_set_new(root, columns[c].name, array);
    }
    return air_table_json_write(context, root, path);
}

static air_status check_axis(air_context *context, const char *path, const json_t *root,
                             const char *name, double (*knot)(size_t))
{
    double values[SIDE];
    air_status status = air_table_json_numbers(context, path, root, name, 0.0, 1.0, SIDE, values);
    for (size_t k = 0; k < SIDE && status == AIR_OK; k++) {
        if (!(fabs(values[k] - knot(k)) < 1e-9)) {
            char place[64], expected[64];
            snprintf(place, sizeof place, "\"%s\"[%zu]", name, k);
            snprintf(expected, sizeof expected, "the knot %.9f", knot(k));
            status = air_table_json_wrong(context, path, place, expected);
        }
    }
    return status;
}

static air_status read(air_context *context, const char *path, const json_t *root,
                       air_area_ltc_table *out)
{
    static const char *const kinds[] = {"ltc"};
    double values[KNOTS];
    if (air_table_json_index(json_object_get(root, "kind"), kinds, 1) == 1) {
        return air_table_json_wrong(context, path, "\"kind\"", "\"ltc\"");
    }
    air_status status = check_axis(context, path, root, "alpha", air_area_ltc_knot_alpha);
    if (status == AIR_OK) {
        status = check_axis(context, path, root, "cos_o", air_area_ltc_knot_cosine);
    }
    for (size_t c = 0; c < COLUMNS && status == AIR_OK; c++) {
        status = air_table_json_numbers(context, path, root, columns[c].name, columns[c].least,
                                        columns[c].largest, KNOTS, values);
        for (size_t k = 0; k < KNOTS && status == AIR_OK; k++) {
            *field(&out->knots[k / SIDE][k % SIDE], c) = values[k];
        }
    }
    return status;
}

air_status air_area_ltc_table_load(air_context *context, const char *path, air_area_ltc_table *out)
{
    json_t *root;
    air_status status = air_table_json_read(context, path, &root);
    if (status != AIR_OK) {
        return status;
    }
    air_area_ltc_table *table = air_allocate(context, 1, sizeof *table);
    status = table == NULL ? air_fail_memory(context, path) : read(context, path, root, table);
    json_decref(root);
    if (status == AIR_OK) {
        *out = *table;
    }
    air_free(context, table);
    return status;
}

air_status air_area_table_is_ltc(air_context *context, const char *path, bool *out_is_ltc)
{
    static const char *const kinds[] = {"ltsd", "mix", "ltc"};
    json_t *root;
    *out_is_ltc = false;
    const air_status status = air_table_json_read(context, path, &root);
    if (status != AIR_OK) {
        return status;
    }
    const size_t kind = air_table_json_index(json_object_get(root, "kind"), kinds, 3);
    json_decref(root);
    *out_is_ltc = kind == 2;
    return kind < 3
               ? AIR_OK
               : air_table_json_wrong(context, path, "\"kind\"", "\"ltsd\", \"mix\" or \"ltc\"");
}
