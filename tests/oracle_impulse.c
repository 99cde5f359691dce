/* Holds the impulse kernel against tables of reference values:
 *
 *     oracle_impulse [--skip-absent] FILE.csv...
 *
 * Coefficients of single events by quadrature and from tables whose knots are the rows' g, tilts of
 * fitted axes, and fluences of many events. Prints worst errors and where they are. Exit codes: 0
 * all within what is accepted, 1 not, 2 a file that is not such a table, 77 a file is absent and
 * --skip-absent was given. */
#include "impulse/tables.h"
#include "impulse_rows.h"
#include "oracle.h"

enum {
    QUADRATURE = 0,                            /* and emitter */
    TABLE = QUADRATURE + AIR_IMPULSE_EMITTERS, /* and emitter; area: 16 angles */
    TABLE_8 = TABLE + AIR_IMPULSE_EMITTERS,
    FIT_ENERGY,
    FIT_IRRADIANCE,
    FLUENCE, /* and emitter */
    CHANCE = FLUENCE + AIR_IMPULSE_EMITTERS,
    CLASSES
};

/* What is judged, and what is accepted. Tilts are printed to 1e-6 and lie where a maximum is flat.
 * Directional fluences are given to 1e-5. Random walks: 4.5 standard errors, which one of 1e5 rows
 * exceeds by chance, and 0.3 % that bands beyond 10 may have. */
static const struct judged {
    const char *name;
    double accepted;
} judged[CLASSES] = {
    {"point, quadrature", 1e-6},       {"directional, quadrature", 1e-6},
    {"area, quadrature", 1e-6},        {"point, table", 1e-3},
    {"directional, table", 1e-3},      {"area, table of 16 angles", 4e-3},
    {"area, table of 8 angles", 2e-2}, {"tilt by energy, rad", 2e-5},
    {"tilt by irradiance, rad", 2e-5}, {"point, fluence", 1e-6},
    {"directional, fluence", 2e-5},    {"area, fluence", 1e-6},
    {"fluence, standard errors", 4.5},
};

typedef struct verdict {
    double worst[CLASSES];
    size_t line[CLASSES], count[CLASSES], skipped;
} verdict;

static void judge(verdict *self, int class, double error, size_t line)
{
    self->count[class]++;
    if (self->count[class] == 1 || !(error <= self->worst[class])) {
        self->worst[class] = error;
        self->line[class] = line;
    }
}

/* ---- coefficients ---- */

/* Relative error of the vector: bands below `order`, and area's three of azimuth. */
static double vector_error(const impulse_row *row, const double *found, int order, double scale)
{
    static const int azimuths[3] = {2, 4, 5};
    const bool area = row->emitter == AIR_IMPULSE_AREA;
    double error = 0.0, square = 0.0;
    for (int l = 0; l < order; l++) {
        const double x = scale * found[area ? l * (l + 1) / 2 : l];
        error += (x - row->c[l]) * (x - row->c[l]);
        square += row->c[l] * row->c[l];
    }
    for (int i = 0; i < 3 && area; i++) {
        const double x = scale * found[azimuths[i]];
        error += (x - row->a[i]) * (x - row->a[i]);
        square += row->a[i] * row->a[i];
    }
    return sqrt(error / square);
}

static void judge_quadrature(verdict *self, const impulse_row *row)
{
    const double sigma_t = row->sigma_s + row->sigma_a, tau = sigma_t * row->d;
    const bool directional = row->emitter == AIR_IMPULSE_DIRECTIONAL;
    const double scale = row->sigma_s * (directional ? 1.0 / sigma_t : sigma_t);
    double c[AIR_IMPULSE_SH_COUNT], zh[AIR_IMPULSE_ORDER];
    if (row->emitter == AIR_IMPULSE_POINT) {
        air_impulse_point(tau, row->g, AIR_IMPULSE_ORDER, c);
    } else if (directional) {
        air_impulse_directional(tau, row->g, AIR_IMPULSE_ORDER, c);
    } else {
        air_impulse_area(tau, row->theta_s, row->g, AIR_IMPULSE_ORDER, c);
        for (int i = 0; i < 2; i++) {
            const air_impulse_form form =
                i == 0 ? AIR_IMPULSE_ZH11_ENERGY : AIR_IMPULSE_ZH11_IRRADIANCE;
            judge(self, FIT_ENERGY + i, fabs(impulse_fit_axis(form, c, zh) - row->fit[i]),
                  row->line);
        }
    }
    judge(self, QUADRATURE + (int)row->emitter, vector_error(row, c, AIR_IMPULSE_ORDER, scale),
          row->line);
}

static void judge_table(verdict *self, const air_impulse_tables *tables, bool eight,
                        const impulse_row *row)
{
    const air_impulse_medium medium = {
        .sigma_s = row->sigma_s, .sigma_t = row->sigma_s + row->sigma_a, .g = row->g, .bounces = 1};
    const double tau = medium.sigma_t * row->d;
    double c[AIR_IMPULSE_SH_COUNT];
    if (!(tau >= IMPULSE_TAU_LEAST && tau <= IMPULSE_TAU_GREATEST)) {
        self->skipped++;
    } else if (row->emitter == AIR_IMPULSE_AREA) {
        const int order = air_impulse_mirrored(tables, &medium, 1, 1, row->d, cos(row->theta_s), c);
        judge(self, eight ? TABLE_8 : TABLE + AIR_IMPULSE_AREA, vector_error(row, c, order, 1.0),
              row->line);
    } else if (!eight) {
        air_impulse_zonal(tables, row->emitter, &medium, 1, 1, row->d, c);
        judge(self, TABLE + (int)row->emitter, vector_error(row, c, AIR_IMPULSE_ORDER, 1.0),
              row->line);
    }
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Distinct asymmetries of rows that ask for tables, rising. */
static size_t find_knots(const impulse_row *rows, size_t count, double *knots)
{
    size_t all = 0, distinct = 0;
    for (size_t i = 0; i < count; i++) {
        if (!rows[i].fluence && fabs(rows[i].g) <= 0.97) {
            knots[all++] = rows[i].g;
        }
    }
    qsort(knots, all, sizeof *knots, compare_doubles);
    for (size_t i = 0; i < all; i++) {
        if (distinct == 0 || knots[i] > knots[distinct - 1] + 1e-6) {
            knots[distinct++] = knots[i];
        }
    }
    return distinct;
}

/* The rows of these knots, by tables of 8 or 16 angles. */
static bool judge_knots(verdict *self, air_context *context, const double *knots, size_t knot_count,
                        bool eight, const impulse_row *rows, size_t count)
{
    air_impulse_params params;
    air_impulse_tables *tables;
    air_impulse_params_default(&params);
    params.bounces = 1;
    params.angles = eight ? 8 : 16;
    params.g_count = knot_count;
    memcpy(params.g, knots, knot_count * sizeof *knots);
    if (air_impulse_tables_create(context, &params, &tables) != AIR_OK) {
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        if (!rows[i].fluence && rows[i].g >= knots[0] - 1e-6 &&
            rows[i].g <= knots[knot_count - 1] + 1e-6) {
            judge_table(self, tables, eight, &rows[i]);
        }
    }
    air_impulse_tables_destroy(tables);
    return true;
}

static bool judge_tables(verdict *self, const impulse_row *rows, size_t count)
{
    static double knots[ROWS_MAX];
    air_context *context;
    const size_t knot_count = find_knots(rows, count, knots);
    bool good = air_context_create(NULL, &context) == AIR_OK;
    for (size_t first = 0; first < knot_count && good; first += AIR_IMPULSE_G_MAX) {
        const size_t left = knot_count - first;
        const size_t n = left < AIR_IMPULSE_G_MAX ? left : AIR_IMPULSE_G_MAX;
        good = judge_knots(self, context, knots + first, n, false, rows, count) &&
               judge_knots(self, context, knots + first, n, true, rows, count);
    }
    air_context_destroy(context);
    return good;
}

/* ---- fluences ---- */

static bool judge_fluence(verdict *self, const impulse_row *row)
{
    const double sigma_t = row->sigma_s + row->sigma_a, r = sigma_t * row->d;
    double scale = pow(row->sigma_s / sigma_t, row->bounce) * sigma_t * sigma_t, found;
    double by_depth[AIR_IMPULSE_BOUNCES_MAX + 1];
    if (row->emitter == AIR_IMPULSE_POINT) {
        found = air_impulse_point_fluence(row->bounce, r);
    } else if (row->emitter == AIR_IMPULSE_AREA) {
        found = air_impulse_area_fluence(row->bounce, r, row->theta_s);
    } else {
        air_context *context;
        bool good = air_context_create(NULL, &context) == AIR_OK;
        good =
            good && air_impulse_directional_fluences(context, row->bounce, r, by_depth) == AIR_OK;
        air_context_destroy(context);
        if (!good) {
            return false;
        }
        found = by_depth[row->bounce];
        scale /= sigma_t * sigma_t;
    }
    found *= scale;
    if (!isnan(row->value)) {
        judge(self, FLUENCE + (int)row->emitter, fabs(found / row->value - 1.0), row->line);
    }
    if (!isnan(row->mc_value) && !isnan(row->mc_error)) {
        const double slack = row->emitter == AIR_IMPULSE_AREA ? 0.003 * row->mc_value : 0.0;
        judge(self, CHANCE, fabs(found - row->mc_value) / hypot(row->mc_error, slack), row->line);
    }
    return true;
}

/* ---- files ---- */

static int report(const verdict *self, const char *path, size_t count)
{
    bool good = true;
    printf("%s: %zu rows; worst errors:\n", path, count);
    for (int i = 0; i < CLASSES; i++) {
        if (self->count[i] > 0) {
            const bool fine = self->worst[i] <= judged[i].accepted;
            printf("  %-26s %.1e (line %zu of %zu rows), accepted %.0e%s\n", judged[i].name,
                   self->worst[i], self->line[i], self->count[i], judged[i].accepted,
                   fine ? "" : " TOO LARGE");
            good = good && fine;
        }
    }
    if (self->skipped > 0) {
        printf("  not asked of the tables: %zu, beyond their distances\n", self->skipped);
    }
    return good ? 0 : EXIT_WRONG;
}

static int check_file(const char *path, bool skip_absent)
{
    static reference_table table;      /* 7 KB */
    static impulse_row rows[ROWS_MAX]; /* 1 MB */
    verdict self = {.skipped = 0};
    const bool read = table_open(&table, path);
    if (table.file == NULL) {
        return oracle_not_open(path, skip_absent);
    }
    const size_t count = read ? rows_read(&table, rows) : 0;
    table_close(&table);
    bool good = count > 0;
    for (size_t i = 0; i < count && good; i++) {
        if (rows[i].fluence) {
            good = judge_fluence(&self, &rows[i]);
        } else {
            judge_quadrature(&self, &rows[i]);
        }
    }
    if (count == 0) {
        return EXIT_MALFORMED;
    }
    good = good && judge_tables(&self, rows, count);
    const int code = report(&self, path, count);
    return good ? code : EXIT_WRONG;
}

int main(int argc, char **argv) { return oracle_main("oracle_impulse", argc, argv, check_file); }
