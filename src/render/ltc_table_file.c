/* ltc_table_file.c: tables of transformed cosines as JSON (docs/table-format.md). */
#include <stdlib.h>

#include "airlight/area_ltc.h"
#include "core/host.h"
#include "render/table_json.h"

enum { SIDE = AIR_LTC_SIDE, KNOTS = SIDE * SIDE };

/* One number of every knot, alpha by alpha. */
static const air_table_column columns[] = {
    {"xx", offsetof(air_area_ltc, xx), -1e4, 1e4},
    {"xz", offsetof(air_area_ltc, xz), -1e4, 1e4},
    {"zx", offsetof(air_area_ltc, zx), -1e4, 1e4},
    {"zz", offsetof(air_area_ltc, zz), -1e4, 1e4},
    {"albedo", offsetof(air_area_ltc, albedo), 0.0, 1.001}, /* by a quadrature */
};
enum { COLUMNS = sizeof columns / sizeof columns[0] };

/* An axis is a column of plain numbers. */
static air_table_column axis(const char *name) { return (air_table_column){name, 0, 0.0, 1.0}; }

static void add_axis(json_t *root, const char *name, double (*knot)(size_t))
{
    const air_table_column column = axis(name);
    double values[SIDE];
    for (size_t k = 0; k < SIDE; k++) {
        values[k] = knot(k);
    }
    air_table_json_add_column(root, &column, values, SIDE, sizeof values[0]);
}

air_status air_area_ltc_table_save(air_context *context, const air_area_ltc_table *table,
                                   const char *path)
{
    json_t *root = air_table_json_new("ltc");
    add_axis(root, "alpha", air_area_ltc_knot_alpha);
    add_axis(root, "cos_o", air_area_ltc_knot_cosine);
    for (size_t c = 0; c < COLUMNS; c++) {
        air_table_json_add_column(root, &columns[c], table->knots, KNOTS,
                                  sizeof table->knots[0][0]);
    }
    return air_table_json_write(context, root, path);
}

static air_status check_axis(air_context *context, const char *path, const json_t *root,
                             const char *name, double (*knot)(size_t))
{
    const air_table_column column = axis(name);
    double values[SIDE];
    air_status status =
        air_table_json_read_column(context, path, root, &column, values, SIDE, sizeof values[0]);
    for (size_t k = 0; k < SIDE && status == AIR_OK; k++) {
        status = air_table_json_check_knot(context, path, name, k, values[k], knot(k));
    }
    return status;
}

static air_status read(air_context *context, const char *path, const json_t *root,
                       air_area_ltc_table *out)
{
    static const char *const kinds[] = {"ltc"};
    if (air_table_json_index(json_object_get(root, "kind"), kinds, 1) == 1) {
        return air_table_json_wrong(context, path, "\"kind\"", "\"ltc\"");
    }
    air_status status = check_axis(context, path, root, "alpha", air_area_ltc_knot_alpha);
    if (status == AIR_OK) {
        status = check_axis(context, path, root, "cos_o", air_area_ltc_knot_cosine);
    }
    for (size_t c = 0; c < COLUMNS && status == AIR_OK; c++) {
        status = air_table_json_read_column(context, path, root, &columns[c], out->knots, KNOTS,
                                            sizeof out->knots[0][0]);
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
