/* area_table_file.c: tables of fitted lobes as JSON (docs/table-format.md). */
#include "airlight/area_table.h"
#include "core/host.h"
#include "render/table_json.h"

static const char *const source_names[] = {"ltsd", "mix"};
static const char *const loss_names[AIR_AREA_LOSSES] = {"kl", "l2", "l3", "cdf-l2"};

static const air_table_column columns[] = {
    {"g", offsetof(air_area_lobe, g), 0.0, 0.99},
    {"s_near", offsetof(air_area_lobe, s_near), 1e-3, 1e4},
    {"w_near", offsetof(air_area_lobe, w_near), -1.0, 1.0},
    {"s_far", offsetof(air_area_lobe, s_far), 1e-3, 1e4},
    {"w_far", offsetof(air_area_lobe, w_far), -1.0, 1.0},
};
enum { COLUMNS = sizeof columns / sizeof columns[0] };

/* ---- writing ---- */

static json_t *describe(const air_area_table *table)
{
    json_t *root = air_table_json_new(source_names[table->source]);
    json_object_set_new(root, "loss", json_string(loss_names[table->loss]));
    for (size_t c = 0; c < COLUMNS; c++) {
        air_table_json_add_column(root, &columns[c], table->knots, AIR_AREA_KNOTS,
                                  sizeof table->knots[0]);
    }
    return root;
}

air_status air_area_table_save(air_context *context, const air_area_table *table, const char *path)
{
    if ((unsigned)table->source > AIR_AREA_SOURCE_MIX || (unsigned)table->loss >= AIR_AREA_LOSSES) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%s: only ltsd and mix make tables", path);
    }
    return air_table_json_write(context, describe(table), path);
}

/* ---- reading ---- */

static air_status read(air_context *context, const char *path, const json_t *root,
                       air_area_table *out)
{
    const size_t source = air_table_json_index(json_object_get(root, "kind"), source_names, 2);
    const size_t loss =
        air_table_json_index(json_object_get(root, "loss"), loss_names, AIR_AREA_LOSSES);
    if (source == 2) {
        return air_table_json_wrong(context, path, "\"kind\"", "\"ltsd\" or \"mix\"");
    }
    if (loss == AIR_AREA_LOSSES) {
        return air_table_json_wrong(context, path, "\"loss\"",
                                    "\"kl\", \"l2\", \"l3\" or \"cdf-l2\"");
    }
    out->source = (air_area_source)source;
    out->loss = (air_area_loss)loss;
    air_status status = AIR_OK;
    for (size_t c = 0; c < COLUMNS && status == AIR_OK; c++) {
        status = air_table_json_read_column(context, path, root, &columns[c], out->knots,
                                            AIR_AREA_KNOTS, sizeof out->knots[0]);
    }
    for (size_t k = 0; k < AIR_AREA_KNOTS && status == AIR_OK; k++) {
        status = air_table_json_check_knot(context, path, "g", k, out->knots[k].g,
                                           0.99 * (double)k / (AIR_AREA_KNOTS - 1));
    }
    return status;
}

air_status air_area_table_load(air_context *context, const char *path, air_area_table *out)
{
    json_t *root;
    air_area_table table;
    air_status status = air_table_json_read(context, path, &root);
    if (status == AIR_OK) {
        status = read(context, path, root, &table);
        json_decref(root);
    }
    if (status == AIR_OK) {
        *out = table;
    }
    return status;
}
