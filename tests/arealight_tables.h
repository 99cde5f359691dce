/* arealight_tables.h: polygons in tables of reference values for the arealight kernel. */
#ifndef AIR_TESTS_AREALIGHT_TABLES_H
#define AIR_TESTS_AREALIGHT_TABLES_H

#include "airlight/arealight.h"
#include "reference_table.h"

enum { AREA_G = 7, AREA_ROWS = 1024 };

/* The asymmetries of the tables and the names of their columns. */
static const double area_g[AREA_G] = {-0.95, -0.6, -0.1, 0.0, 0.4, 0.9, 0.99};
static const char *const area_g_names[AREA_G] = {"S_g-0.95", "S_g-0.6", "S_g-0.1", "S_g0",
                                                 "S_g0.4",   "S_g0.9",  "S_g0.99"};

/* A polygon with its reference values. */
typedef struct area_row {
    char id[TABLE_NAME], kind[TABLE_NAME];
    size_t line, count;
    double polygon[AIR_AREA_MAX_VERTICES][3], wo[3];
    double solid_angle, min_distance, scatter[AREA_G];
} area_row;

static inline bool area_read_polygon(const reference_table *self, area_row *out)
{
    double count;
    if (!table_number(self, "nv", &count)) {
        return false;
    }
    if (!(count >= 3.0 && count <= AIR_AREA_MAX_VERTICES)) {
        return table_complain(self, "3 to 16 in column nv", "");
    }
    out->count = (size_t)count;
    for (size_t k = 0; k < 3 * (out->count + 1); k++) {
        char name[TABLE_NAME];
        if (k < 3) {
            snprintf(name, sizeof name, "wo%c", "xyz"[k]);
        } else {
            snprintf(name, sizeof name, "%c%zu", "xyz"[k % 3], k / 3 - 1);
        }
        if (!table_number(self, name, k < 3 ? &out->wo[k] : &out->polygon[k / 3 - 1][k % 3])) {
            return false;
        }
    }
    /* 12 digits leave a length of 1 +- 1e-12, which a sharp peak would magnify to 4e-10. */
    const double length =
        sqrt(out->wo[0] * out->wo[0] + out->wo[1] * out->wo[1] + out->wo[2] * out->wo[2]);
    for (int i = 0; i < 3; i++) {
        out->wo[i] /= length;
    }
    return length > 0.0 || table_complain(self, "a direction in columns wox to woz", "");
}

/* Polygons with solid angles, distances and S. Returns how many, 0 with a message if the file is
 * not such a table, and 0 without one if it cannot be opened. */
static inline size_t area_read_rows(const char *path, area_row rows[AREA_ROWS])
{
    static reference_table table; /* 5 KB */
    size_t count = 0;
    bool ok = table_open(&table, path);
    while (ok && count < AREA_ROWS && table_next(&table, &ok)) {
        area_row *const row = &rows[count++];
        ok = table_text(&table, "id", row->id) && table_text(&table, "class", row->kind) &&
             area_read_polygon(&table, row) &&
             table_number(&table, "solid_angle", &row->solid_angle) &&
             table_number(&table, "min_dist", &row->min_distance);
        for (int k = 0; k < AREA_G && ok; k++) {
            ok = table_number(&table, area_g_names[k], &row->scatter[k]);
        }
        row->line = table.line;
    }
    if (ok && count == 0) {
        (void)table_complain(&table, "rows after the header", "");
    }
    table_close(&table);
    return ok ? count : 0;
}

#endif
