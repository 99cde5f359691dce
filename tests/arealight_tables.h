/* arealight_tables.h: reads tables of reference values for the arealight kernel: cells separated by
 * commas under a header that names the columns. */
#ifndef AIR_TESTS_AREALIGHT_TABLES_H
#define AIR_TESTS_AREALIGHT_TABLES_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/arealight.h"

enum { AREA_COLUMNS = 64, AREA_LINE = 2048, AREA_NAME = 32, AREA_G = 7, AREA_ROWS = 1024 };

/* The asymmetries of the tables and the names of their columns. */
static const double area_g[AREA_G] = {-0.95, -0.6, -0.1, 0.0, 0.4, 0.9, 0.99};
static const char *const area_g_names[AREA_G] = {"S_g-0.95", "S_g-0.6", "S_g-0.1", "S_g0",
                                                 "S_g0.4",   "S_g0.9",  "S_g0.99"};

typedef struct area_table {
    const char *path;
    FILE *file;
    size_t line, columns, count;
    char names[AREA_COLUMNS][AREA_NAME];
    char text[AREA_LINE];
    const char *cells[AREA_COLUMNS];
} area_table;

/* A polygon with its reference values. */
typedef struct area_row {
    char id[AREA_NAME], kind[AREA_NAME];
    size_t line, count;
    double polygon[AIR_AREA_MAX_VERTICES][3], wo[3];
    double solid_angle, min_distance, scatter[AREA_G];
} area_row;

static inline bool area_complain(const area_table *self, const char *expected, const char *what)
{
    fprintf(stderr, "%s:%zu: expected %s%s\n", self->path, self->line, expected, what);
    return false;
}

/* Splits the next line into cells. False at the end of the file. */
static inline bool area_split_line(area_table *self)
{
    if (fgets(self->text, AREA_LINE, self->file) == NULL) {
        return false;
    }
    self->line++;
    self->text[strcspn(self->text, "\r\n")] = '\0';
    self->count = 0;
    for (char *at = self->text; at != NULL && self->count < AREA_COLUMNS;) {
        self->cells[self->count++] = at;
        at = strchr(at, ',');
        if (at != NULL) {
            *at++ = '\0';
        }
    }
    return true;
}

static inline ptrdiff_t area_find(const area_table *self, const char *name)
{
    for (size_t i = 0; i < self->columns; i++) {
        if (strcmp(self->names[i], name) == 0) {
            return (ptrdiff_t)i;
        }
    }
    return -1;
}

/* Opens a table and reads its header; the file stays NULL where there is none. */
static inline bool area_open(area_table *self, const char *path)
{
    memset(self, 0, sizeof *self);
    self->path = path;
    self->file = fopen(path, "r");
    if (self->file == NULL) {
        return false;
    }
    if (!area_split_line(self)) {
        self->line = 1;
        return area_complain(self, "a header", "");
    }
    self->columns = self->count;
    for (size_t i = 0; i < self->columns; i++) {
        snprintf(self->names[i], AREA_NAME, "%s", self->cells[i]);
    }
    return true;
}

static inline void area_close(area_table *self)
{
    if (self->file != NULL) {
        (void)fclose(self->file);
        self->file = NULL;
    }
}

/* The next row. False at the end, and where a row is not as wide as the header (*ok too). */
static inline bool area_next(area_table *self, bool *ok)
{
    if (!*ok || !area_split_line(self)) {
        return false;
    }
    *ok =
        self->count == self->columns || area_complain(self, "as many cells as the header has", "");
    return *ok;
}

static inline bool area_number(const area_table *self, const char *name, double *out)
{
    const ptrdiff_t column = area_find(self, name);
    if (column < 0) {
        return area_complain(self, "a column ", name);
    }
    char *end;
    const char *text = self->cells[column];
    *out = strtod(text, &end);
    return (end != text && *end == '\0' && isfinite(*out)) ||
           area_complain(self, "a number in column ", name);
}

static inline bool area_text(const area_table *self, const char *name, char out[AREA_NAME])
{
    const ptrdiff_t column = area_find(self, name);
    if (column < 0) {
        return area_complain(self, "a column ", name);
    }
    snprintf(out, AREA_NAME, "%s", self->cells[column]);
    return true;
}

static inline bool area_read_polygon(const area_table *self, area_row *out)
{
    double count;
    if (!area_number(self, "nv", &count)) {
        return false;
    }
    if (!(count >= 3.0 && count <= AIR_AREA_MAX_VERTICES)) {
        return area_complain(self, "3 to 16 in column nv", "");
    }
    out->count = (size_t)count;
    for (size_t k = 0; k < 3 * (out->count + 1); k++) {
        char name[AREA_NAME];
        if (k < 3) {
            snprintf(name, sizeof name, "wo%c", "xyz"[k]);
        } else {
            snprintf(name, sizeof name, "%c%zu", "xyz"[k % 3], k / 3 - 1);
        }
        if (!area_number(self, name, k < 3 ? &out->wo[k] : &out->polygon[k / 3 - 1][k % 3])) {
            return false;
        }
    }
    /* 12 digits leave a length of 1 +- 1e-12, which a sharp peak would magnify to 4e-10. */
    const double length =
        sqrt(out->wo[0] * out->wo[0] + out->wo[1] * out->wo[1] + out->wo[2] * out->wo[2]);
    for (int i = 0; i < 3; i++) {
        out->wo[i] /= length;
    }
    return length > 0.0 || area_complain(self, "a direction in columns wox to woz", "");
}

/* Polygons with solid angles, distances and S. Returns how many, 0 with a message if the file is
 * not such a table, and 0 without one if it cannot be opened. */
static inline size_t area_read_rows(const char *path, area_row rows[AREA_ROWS])
{
    static area_table table; /* 5 KB */
    size_t count = 0;
    bool ok = area_open(&table, path);
    while (ok && count < AREA_ROWS && area_next(&table, &ok)) {
        area_row *const row = &rows[count++];
        ok = area_text(&table, "id", row->id) && area_text(&table, "class", row->kind) &&
             area_read_polygon(&table, row) &&
             area_number(&table, "solid_angle", &row->solid_angle) &&
             area_number(&table, "min_dist", &row->min_distance);
        for (int k = 0; k < AREA_G && ok; k++) {
            ok = area_number(&table, area_g_names[k], &row->scatter[k]);
        }
        row->line = table.line;
    }
    if (ok && count == 0) {
        (void)area_complain(&table, "rows after the header", "");
    }
    area_close(&table);
    return ok ? count : 0;
}

#endif
