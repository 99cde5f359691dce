/* impulse_rows.h: rows of tables of reference values for the impulse kernel. Cells may be empty
 * where a row has no use for them. */
#ifndef AIR_TESTS_IMPULSE_ROWS_H
#define AIR_TESTS_IMPULSE_ROWS_H

#include "airlight/impulse.h"
#include "reference_table.h"

enum { ROWS_MAX = 4096 };

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

/* A number in [least, largest]; NAN of an empty cell where that may be. */
static inline bool rows_number(const reference_table *self, const char *name, double least,
                               double largest, bool optional, double *out)
{
    const char *const text = table_cell(self, name);
    *out = NAN;
    if (text == NULL || (optional && *text == '\0')) {
        return text != NULL;
    }
    return table_number(self, name, out) &&
           ((*out >= least && *out <= largest) ||
            table_complain(self, "a number in range in column ", name));
}

static inline bool rows_coefficients(const reference_table *self, impulse_row *row)
{
    static const char *const others[5] = {"a_1_1", "a_2_1", "a_2_2", "theta_fit_energy_rad",
                                          "theta_fit_irr_rad"};
    bool good = true;
    for (int l = 0; l < AIR_IMPULSE_ORDER && good; l++) {
        char name[TABLE_NAME];
        snprintf(name, sizeof name, "c%d", l);
        good = rows_number(self, name, -1e30, 1e30, false, &row->c[l]);
    }
    for (int i = 0; i < 5 && good && row->emitter == AIR_IMPULSE_AREA; i++) {
        good =
            rows_number(self, others[i], -1e30, 1e30, false, i < 3 ? &row->a[i] : &row->fit[i - 3]);
    }
    return good;
}

static inline bool rows_read_one(const reference_table *self, impulse_row *row)
{
    static const char *const emitters[3] = {"point", "directional", "area"};
    const char *const emitter = table_cell(self, "emitter");
    const char *const quantity = table_cell(self, "quantity");
    double bounce;
    int found = 0;
    if (emitter == NULL || quantity == NULL) {
        return false;
    }
    while (found < 3 && strcmp(emitter, emitters[found]) != 0) {
        found++;
    }
    if (found == 3) {
        return table_complain(self, "point, directional or area in column emitter", "");
    }
    row->line = self->line;
    row->emitter = (air_impulse_emitter)found;
    row->fluence = strcmp(quantity, "fluence") == 0;
    if (!row->fluence && strcmp(quantity, "single_zh") != 0) {
        return table_complain(self, "single_zh or fluence in column quantity", "");
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
        return table_complain(self, "0 in column g where there is a fluence", "");
    }
    return row->fluence ? rows_number(self, "value", 0.0, 1e30, true, &row->value) &&
                              rows_number(self, "mc_value", 0.0, 1e30, true, &row->mc_value) &&
                              rows_number(self, "mc_stderr", 0.0, 1e30, true, &row->mc_error)
                        : rows_coefficients(self, row);
}

/* How many rows there are; 0 after a complaint. */
static inline size_t rows_read(reference_table *self, impulse_row *rows)
{
    size_t count = 0;
    bool ok = true;
    while (count < ROWS_MAX && table_next(self, &ok)) {
        ok = rows_read_one(self, &rows[count++]);
    }
    if (ok && count == 0) {
        (void)table_complain(self, "rows after the header", "");
    }
    return ok ? count : 0;
}

#endif
