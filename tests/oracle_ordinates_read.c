/* oracle_ordinates_read.c: reads parameters and what photons gave. */
#include <errno.h>
#include <stdint.h>

#include "oracle_ordinates.h"
#include "reference_table.h"

/* ---- parameters ---- */

static bool in_range(const reference_table *table, const char *name, double least, double most,
                     double *out)
{
    char expected[96];
    if (!table_number(table, name, out)) {
        return false;
    }
    snprintf(expected, sizeof expected, "a number of %g to %g in column ", least, most);
    return (*out >= least && *out <= most) || table_complain(table, expected, name);
}

static bool even_count(const reference_table *table, const char *name, double least, double most,
                       size_t *out)
{
    double value;
    if (!in_range(table, name, least, most, &value)) {
        return false;
    }
    *out = (size_t)value;
    return ((double)*out == value && *out % 2 == 0) ||
           table_complain(table, "an even number in column ", name);
}

static bool read_row(const reference_table *table, simulated *out)
{
    const bool cube = strncmp(out->stem, "cube_", 5) == 0;
    return even_count(table, "cells", 4.0, cube ? 64.0 : 128.0, &out->cells) &&
           (cube || even_count(table, "shells", 2.0, 256.0, &out->shells)) &&
           in_range(table, "size_m", 1e-3, 1e3, &out->size_m) &&
           in_range(table, "sigma_s", 1e-6, 1e6, &out->sigma_s) &&
           in_range(table, "sigma_a", 0.0, 1e6, &out->sigma_a) &&
           in_range(table, "g", -0.99, 0.99, &out->g) &&
           in_range(table, "light", 1e-6, 1e6, &out->light);
}

/* *out_found is left alone where the table, or a row of this stem, is absent. */
static bool find_in(const char *path, const char *stem, simulated *out, bool *out_found)
{
    static reference_table table; /* 7 KB */
    bool good = table_open(&table, path);
    if (table.file == NULL) {
        return errno == ENOENT || table_complain(&table, "a table that can be read", "");
    }
    while (good && !*out_found && table_next(&table, &good)) {
        const char *const here = table_cell(&table, "stem");
        good = here != NULL;
        if (good && strcmp(here, stem) == 0) {
            memset(out, 0, sizeof *out);
            snprintf(out->stem, STEM, "%s", stem);
            good = read_row(&table, out);
            *out_found = true;
        }
    }
    table_close(&table);
    return good;
}

bool simulated_find(const char *folder, const char *file, const char *stem, simulated *out)
{
    char path[PATH];
    bool found = false;
    snprintf(path, sizeof path, "%s/parameters.csv", folder);
    if (!find_in(path, stem, out, &found) ||
        (!found && !find_in(AIR_ORDINATES_PARAMETERS, stem, out, &found))) {
        return false;
    }
    if (!found) {
        fprintf(stderr,
                "%s/%s: expected a row %s in %s, whose header is "
                "stem,cells,shells,size_m,sigma_s,sigma_a,g,light\n",
                folder, file, stem, path);
    }
    return found;
}

/* ---- cubes ---- */

/* To be freed; NULL, and said, where the file is not as long or not all of it is finite. */
static float *read_floats(const char *path, size_t count)
{
    FILE *const file = fopen(path, "rb");
    float *const out = file == NULL ? NULL : malloc((count + 1) * sizeof *out);
    bool good = out != NULL;
    if (!good) {
        fprintf(stderr, "%s: %s\n", path, strerror(errno));
    } else {
        const size_t read = fread(out, 1, (count + 1) * sizeof *out, file);
        good = read == count * sizeof *out;
        if (!good) {
            fprintf(stderr, "%s: expected %zu floats, %zu bytes, not %s%zu\n", path, count,
                    count * sizeof *out, read > count * sizeof *out ? "at least " : "", read);
        }
    }
    for (size_t i = 0; good && i < count; i++) {
        good = isfinite(out[i]);
        if (!good) {
            fprintf(stderr, "%s: expected numbers, not %g at float %zu\n", path, (double)out[i], i);
        }
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    if (!good) {
        free(out);
    }
    return good ? out : NULL;
}

static bool read_exits(const char *path, cube_truth *out)
{
    static const char *const names[LEAVES] = {"exit_x0",      "exit_x1",       "exit_y0", "exit_y1",
                                              "exit_z0_back", "exit_z1_front", "absorbed"};
    static reference_table table; /* 7 KB */
    double *const to[LEAVES + 2] = {&out->leaves[0], &out->leaves[1], &out->leaves[2],
                                    &out->leaves[3], &out->leaves[4], &out->leaves[5],
                                    &out->leaves[6], &out->events,    &out->mean};
    bool good = table_open(&table, path);
    for (int i = 0; i < LEAVES + 2; i++) {
        *to[i] = NAN;
    }
    while (good && table_next(&table, &good)) {
        const char *const name = table_cell(&table, "quantity");
        good = name != NULL && table_find(&table, "mean") >= 0;
        if (!good && name != NULL) {
            (void)table_cell(&table, "mean"); /* says so */
        }
        for (int i = 0; good && i < LEAVES + 2; i++) {
            const char *const known =
                i < LEAVES ? names[i] : (i == LEAVES ? "mean_scatter_events" : "mean_fluence");
            if (strcmp(name, known) == 0) {
                good = table_number(&table, "mean", to[i]);
            }
        }
    }
    for (int i = 0; good && i < LEAVES; i++) {
        good = !isnan(out->leaves[i]) || table_complain(&table, "a row ", names[i]);
    }
    table_close(&table);
    return good;
}

bool cube_truth_read(const char *folder, const simulated *what, cube_truth *out)
{
    static const char *const ends[CUBE_FILES] = {"fluence.f32", "angular.f32", "exit.csv"};
    const size_t n = what->cells;
    bool good = true;
    for (int i = 0; i < CUBE_FILES; i++) {
        snprintf(out->path[i], PATH, "%s/%s_%s", folder, what->stem, ends[i]);
        FILE *const file = fopen(out->path[i], "rb");
        out->has[i] = file != NULL;
        if (file != NULL) {
            (void)fclose(file);
        }
    }
    out->fluence = out->angular = NULL;
    if (out->has[CUBE_FLUENCE]) {
        out->fluence = read_floats(out->path[CUBE_FLUENCE], 6 * n * n * n);
        good = out->fluence != NULL;
    }
    if (good && out->has[CUBE_ANGULAR]) {
        out->angular = read_floats(out->path[CUBE_ANGULAR], 2 * n * n * BINS);
        good = out->angular != NULL;
    }
    good = good && (!out->has[CUBE_EXIT] || read_exits(out->path[CUBE_EXIT], out));
    if (!good) {
        cube_truth_finish(out);
    }
    return good;
}

void cube_truth_finish(cube_truth *self)
{
    free(self->fluence);
    free(self->angular);
    self->fluence = self->angular = NULL;
}

/* ---- shells ---- */

static bool read_shell(const reference_table *table, double out[SHELL_COLUMNS])
{
    static const char *const names[SHELL_BINS] = {"r_inner", "r_outer", "phi_ballistic",
                                                  "phi_scattered"};
    bool good = true;
    for (int i = 0; i < SHELL_COLUMNS && good; i++) {
        char bin[TABLE_NAME];
        snprintf(bin, sizeof bin, "mu%02d", i - SHELL_BINS);
        good = in_range(table, i < SHELL_BINS ? names[i] : bin, 0.0, 1e12, &out[i]);
    }
    return good;
}

shell_truth *shell_truth_read(const char *path, const simulated *what)
{
    static reference_table table; /* 7 KB */
    shell_truth *const out = malloc((what->shells + 1) * sizeof *out);
    size_t count = 0;
    bool good = out != NULL && table_open(&table, path);
    while (good && table_next(&table, &good)) {
        good = count < what->shells || table_complain(&table, "no more shells than ", what->stem);
        good = good && read_shell(&table, out[count++]);
    }
    if (good && count != what->shells) {
        fprintf(stderr, "%s: expected %zu shells, not %zu\n", path, what->shells, count);
        good = false;
    }
    if (out != NULL && table.file == NULL) {
        fprintf(stderr, "%s: %s\n", path, strerror(errno));
    }
    table_close(&table);
    if (!good) {
        free(out);
    }
    return good ? out : NULL;
}
