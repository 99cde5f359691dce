/* impulse_rows.h: reads tables of reference values for the impulse kernel: lines that begin with #
 * are comments, a header names the columns, cells may be empty where a row has no use for them. */
#ifndef AIR_TESTS_IMPULSE_ROWS_H
#define AIR_TESTS_IMPULSE_ROWS_H

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/impulse.h"

enum { ROWS_MAX = 4096, COLUMNS_MAX = 64, LINE_MAX_BYTES = 4096, NAME_MAX_BYTES = 32 };

typedef struct impulse_row {
    size_t line;
    air_impulse_emitter emitter;
    bool fluence; /* else coefficients of a single event */
    double d, theta_s, g, sigma_s, sigma_a;
    int bounce;
    double c[AIR_IMPULSE_ORDER], a[3]; /* a_1_1, a_2_1, a_2_2: area */
    double fit[2];                     /* energy, irradiance: area */
    double value, mc_value, mc_error;  /* fluence; NAN where empty */
} impulse_row;

typedef struct impulse_file {
    const char *path;
    FILE *file;
    size_t line, columns, count;
    char header[LINE_MAX_BYTES], text[LINE_MAX_BYTES];
    char *names[COLUMNS_MAX], *cells[COLUMNS_MAX];
} impulse_file;

static inline bool rows_complain(const impulse_file *self, const char *expected, const char *what)
{
    fprintf(stderr, "%s:%zu: expected %s%s\n", self->path, self->line, expected, what);
    return false;
}

/* The next line that is no comment, cut into cells. */
static inline bool rows_split(impulse_file *self, char *text, char **cells, size_t *count)
{
    do {
        if (fgets(text, LINE_MAX_BYTES, self->file) == NULL) {
            return false;
        }
        self->line++;
    } while (text[0] == '#');
    text[strcspn(text, "\r\n")] = '\0';
    *count = 0;
    for (char *at = text; at != NULL && *count < COLUMNS_MAX;) {
        cells[(*count)++] = at;
        at = strchr(at, ',');
        if (at != NULL) {
            *at++ = '\0';
        }
    }
    return true;
}

/* The cell of a column, NULL (said) where there is no such column. */
static inline const char *rows_cell(const impulse_file *self, const char *name)
{
    for (size_t i = 0; i < self->columns; i++) {
        if (strcmp(self->names[i], name) == 0) {
            return self->cells[i];
        }
    }
    (void)rows_complain(self, "a column ", name);
    return NULL;
}

/* A number in [least, largest]; NAN of an empty cell where that may be. */
static inline bool rows_number(const impulse_file *self, const char *name, double least,
                               double largest, bool optional, double *out)
{
    char *end;
    const char *const text = rows_cell(self, name);
    *out = NAN;
    if (text == NULL || (optional && *text == '\0')) {
        return text != NULL;
    }
    *out = strtod(text, &end);
    return (end != text && *end == '\0' && *out >= least && *out <= largest) ||
           rows_complain(self, "a number in range in column ", name);
}

static inline bool rows_coefficients(const impulse_file *self, impulse_row *row)
{
    static const char *const others[5] = {"a_1_1", "a_2_1", "a_2_2", "theta_fit_energy_rad",
                                          "theta_fit_irr_rad"};
    bool good = true;
    for (int l = 0; l < AIR_IMPULSE_ORDER && good; l++) {
        char name[NAME_MAX_BYTES];
        snprintf(name, sizeof name, "c%d", l);
        good = rows_number(self, name, -1e30, 1e30, false, &row->c[l]);
    }
    for (int i = 0; i < 5 && good && row->emitter == AIR_IMPULSE_AREA; i++) {
        good =
            rows_number(self, others[i], -1e30, 1e30, false, i < 3 ? &row->a[i] : &row->fit[i - 3]);
    }
    return good;
}

static inline bool rows_read_one(const impulse_file *self, impulse_row *row)
{
    static const char *const emitters[3] = {"point", "directional", "area"};
    const char *const emitter = rows_cell(self, "emitter");
    const char *const quantity = rows_cell(self, "quantity");
    double bounce;
    int found = 0;
    if (emitter == NULL || quantity == NULL) {
        return false;
    }
    while (found < 3 && strcmp(emitter, emitters[found]) != 0) {
        found++;
    }
    if (found == 3) {
        return rows_complain(self, "point, directional or area in column emitter", "");
    }
    row->line = self->line;
    row->emitter = (air_impulse_emitter)found;
    row->fluence = strcmp(quantity, "fluence") == 0;
    if (!row->fluence && strcmp(quantity, "single_zh") != 0) {
        return rows_complain(self, "single_zh or fluence in column quantity", "");
    }
    if (!rows_number(self, "d", 1e-9, 1e9, false, &row->d) ||
        !rows_number(self, "theta_s_rad", 0.0, 3.14159266, row->emitter != AIR_IMPULSE_AREA,
                     &row->theta_s) ||
        !rows_number(self, "g", -0.999, 0.999, false, &row->g) ||
        !rows_number(self, "sigma_s", 1e-12, 1e9, false, &row->sigma_s) ||
        !rows_number(self, "sigma_a", 0.0, 1e9, false, &row->sigma_a) ||
        !rows_number(self, "bounce", 1.0, row->fluence ? AIR_IMPULSE_BOUNCES_MAX : 1.0, false,
                     &bounce)) {
        return false;
    }
    row->bounce = (int)bounce;
    if (row->fluence && row->g != 0.0) {
        return rows_complain(self, "0 in column g where there is a fluence", "");
    }
    return row->fluence ? rows_number(self, "value", 0.0, 1e30, true, &row->value) &&
                              rows_number(self, "mc_value", 0.0, 1e30, true, &row->mc_value) &&
                              rows_number(self, "mc_stderr", 0.0, 1e30, true, &row->mc_error)
                        : rows_coefficients(self, row);
}

/* How many rows there are; 0 after a complaint. */
static inline size_t rows_read(impulse_file *self, impulse_row *rows)
{
    size_t count = 0;
    if (!rows_split(self, self->header, self->names, &self->columns)) {
        self->line = 1;
        (void)rows_complain(self, "a header", "");
        return 0;
    }
    while (count < ROWS_MAX && rows_split(self, self->text, self->cells, &self->count)) {
        if (self->count != self->columns) {
            (void)rows_complain(self, "as many cells as the header has", "");
            return 0;
        }
        if (!rows_read_one(self, &rows[count])) {
            return 0;
        }
        count++;
    }
    if (count == 0) {
        (void)rows_complain(self, "rows after the header", "");
    }
    return count;
}

#endif
