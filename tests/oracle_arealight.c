/* Holds the arealight kernel against tables of reference values:
 *
 *     oracle_arealight [--skip-absent] FILE.csv...
 *
 * A table is known by its header. With wox: polygons, their solid angles, distances and S. With
 * Tbar: transmittances, and with S_ltsd_KL: S by lobes, both of the polygons of oracle_public.csv,
 * which is looked for beside the file. Prints rows, worst errors and where they are. Exit codes: 0
 * all within what is accepted, 1 not, 2 a file that is not such a table, 77 a file is absent and
 * --skip-absent was given. */
#include "arealight_tables.h"
#include "oracle.h"

enum { PATH = 1024 };

/* An error of many, the worst of them, and what is accepted. */
typedef struct judged {
    double worst, accepted, square, mean;
    size_t line, count;
} judged;

static void judge(judged *self, double found, double expected, double error, size_t line)
{
    self->square += (found - expected) * (found - expected);
    self->mean += expected;
    self->count++;
    if (!(error <= self->worst)) {
        self->worst = error;
        self->line = line;
    }
}

static void judge_relative(judged *self, double found, double expected, size_t line)
{
    judge(self, found, expected, found == expected ? 0.0 : fabs(found - expected) / fabs(expected),
          line);
}

/* Root of the mean square error by the mean. */
static double spread(const judged *self)
{
    return self->mean > 0.0 ? sqrt(self->square * (double)self->count) / self->mean : 0.0;
}

static bool report(const judged *self, const char *name)
{
    const bool good = self->worst <= self->accepted;
    printf("  %-22s %.1e (line %zu), RMSE/mean %.1e%s\n", name, self->worst, self->line,
           spread(self), good ? "" : " TOO LARGE");
    return good;
}

static const double (*vertices(const area_row *row))[3] { return (const double(*)[3])row->polygon; }

/* ---- polygons and S by edges ---- */

/* What is accepted of n nodes: up to |g| = 0.9, and beyond. 4 nodes are only reported. */
static const struct edge_bound {
    int nodes;
    double moderate, sharp;
} edge_bounds[] = {{4, INFINITY, INFINITY}, {8, 2e-4, 2e-3}, {16, 1e-6, 1e-6}, {32, 1e-9, 1e-9}};

static int check_polygons(const char *path, area_row *rows)
{
    const size_t count = area_read_rows(path, rows);
    if (count == 0) {
        return EXIT_MALFORMED;
    }
    judged solid_angle = {.accepted = 1e-10}, distance = {.accepted = 1e-10};
    for (size_t i = 0; i < count; i++) {
        const area_row *r = &rows[i];
        judge_relative(&solid_angle, air_area_solid_angle(vertices(r), r->count), r->solid_angle,
                       r->line);
        judge_relative(&distance, air_area_min_distance(vertices(r), r->count), r->min_distance,
                       r->line);
    }
    printf("%s: %zu rows; worst relative errors:\n", path, count);
    bool good = report(&solid_angle, "solid angle");
    good = report(&distance, "least distance") && good;
    for (size_t b = 0; b < sizeof edge_bounds / sizeof *edge_bounds; b++) {
        for (int k = 0; k < AREA_G; k++) {
            judged scatter = {.accepted = fabs(area_g[k]) <= 0.9 ? edge_bounds[b].moderate
                                                                 : edge_bounds[b].sharp};
            char name[TABLE_NAME];
            for (size_t i = 0; i < count; i++) {
                const area_row *r = &rows[i];
                judge_relative(&scatter,
                               air_area_scatter_edge(vertices(r), r->count, r->wo, area_g[k],
                                                     edge_bounds[b].nodes),
                               r->scatter[k], r->line);
            }
            snprintf(name, sizeof name, "S, g %g, %d nodes", area_g[k], edge_bounds[b].nodes);
            good = report(&scatter, name) && good;
        }
    }
    return good ? 0 : EXIT_WRONG;
}

/* ---- tables that refer to polygons ---- */

/* The polygons of oracle_public.csv in the folder of `path`. */
static size_t rows_beside(const char *path, area_row *rows)
{
    char beside[PATH];
    const char *slash = strrchr(path, '/');
    const int folder = slash == NULL ? 0 : (int)(slash - path + 1);
    snprintf(beside, sizeof beside, "%.*soracle_public.csv", folder, path);
    const size_t count = area_read_rows(beside, rows);
    if (count == 0) {
        fprintf(stderr, "%s: expected a table of polygons beside it, %s\n", path, beside);
    }
    return count;
}

static const area_row *find_row(const reference_table *table, const area_row *rows, size_t count)
{
    char id[TABLE_NAME];
    if (!table_text(table, "id", id)) {
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        if (strcmp(rows[i].id, id) == 0) {
            return &rows[i];
        }
    }
    (void)table_complain(table, "an id of the table of polygons, not ", id);
    return NULL;
}

static const struct haze_bound {
    int nodes;
    double accepted; /* relative, measured of the table: 4.7e-4 .. 4.4e-11 */
} haze_bounds[] = {{4, 1e-3}, {8, 1e-5}, {16, 1e-7}, {32, 1e-9}, {48, 1e-9}};

enum { HAZE_BOUNDS = sizeof haze_bounds / sizeof *haze_bounds };

static int check_haze(reference_table *table, const area_row *rows, size_t count)
{
    judged errors[HAZE_BOUNDS];
    size_t read = 0;
    bool ok = count > 0, good = true;
    for (int b = 0; b < HAZE_BOUNDS; b++) {
        errors[b] = (judged){.accepted = haze_bounds[b].accepted};
    }
    for (; table_next(table, &ok); read++) {
        double sigma_t = 0.0, expected = 0.0;
        const area_row *r = find_row(table, rows, count);
        ok = r != NULL && table_number(table, "mu_t", &sigma_t) &&
             table_number(table, "Tbar", &expected);
        for (int b = 0; b < HAZE_BOUNDS && ok; b++) {
            judge_relative(&errors[b],
                           air_area_transmitted_solid_angle(vertices(r), r->count, sigma_t,
                                                            haze_bounds[b].nodes),
                           expected, table->line);
        }
    }
    ok = ok && (read > 0 || table_complain(table, "rows after the header", ""));
    if (!ok) {
        return EXIT_MALFORMED;
    }
    printf("%s: %zu rows; worst relative errors:\n", table->path, read);
    for (int b = 0; b < HAZE_BOUNDS; b++) {
        char name[TABLE_NAME];
        snprintf(name, sizeof name, "Tbar, %d nodes", haze_bounds[b].nodes);
        good = report(&errors[b], name) && good;
    }
    return good ? 0 : EXIT_WRONG;
}

/* The models' RMSE/mean against the exact S, to the digits that are given, and half of one more:
 * lobes come from tables between whose entries they are interpolated. */
static const double known_spread[2][AREA_G] = {{0.083, 0.059, 0.052, 0.0, 0.055, 0.092, 0.072},
                                               {0.020, 0.0034, 8e-5, 0.0, 0.0025, 0.025, 0.010}};
static const double spread_tolerance[2][AREA_G] = {{1e-3, 1e-3, 1e-3, 1e-9, 1e-3, 1e-3, 1e-3},
                                                   {1e-3, 1e-4, 1e-5, 1e-9, 1e-4, 1e-3, 1e-3}};

/* Of S against the fitted lobes' own: interpolation changes s by 3e-4 of it at most, and S by a
 * quarter of that. */
static const double lobes_accepted = 1e-4;

typedef struct lobe_errors {
    judged fitted, exact;
} lobe_errors;

static bool judge_lobes(const reference_table *table, const area_row *rows, size_t count,
                        lobe_errors errors[2][AREA_G])
{
    static const char *const columns[2] = {"S_ltsd_KL", "S_mix"};
    double g = 0.0, exact = 0.0;
    int k = 0;
    const area_row *r = find_row(table, rows, count);
    if (r == NULL || !table_number(table, "g", &g) || !table_number(table, "S_exact", &exact)) {
        return false;
    }
    while (k < AREA_G && area_g[k] != g) {
        k++;
    }
    if (k == AREA_G) {
        return table_complain(table, "an asymmetry of the table of polygons in column g", "");
    }
    for (int model = 0; model < 2; model++) {
        double fitted = 0.0;
        const air_area_lobe lobe = model == 0 ? air_area_lobe_ltsd(g) : air_area_lobe_mix(g);
        const double found = air_area_scatter_lobes(vertices(r), r->count, r->wo, &lobe);
        if (!table_number(table, columns[model], &fitted)) {
            return false;
        }
        judge(&errors[model][k].fitted, found, fitted, fabs(found - fitted), table->line);
        judge(&errors[model][k].exact, found, exact, fabs(found - exact), table->line);
    }
    return true;
}

static int check_lobes(reference_table *table, const area_row *rows, size_t count)
{
    lobe_errors errors[2][AREA_G];
    size_t read = 0;
    bool ok = count > 0, good = true;
    memset(errors, 0, sizeof errors);
    for (; table_next(table, &ok); read++) {
        ok = judge_lobes(table, rows, count, errors);
    }
    ok = ok && (read > 0 || table_complain(table, "rows after the header", ""));
    if (!ok) {
        return EXIT_MALFORMED;
    }
    printf("%s: %zu rows; worst absolute differences from the fit, and from the exact S:\n",
           table->path, read);
    for (int model = 0; model < 2; model++) {
        for (int k = 0; k < AREA_G; k++) {
            lobe_errors *const e = &errors[model][k];
            const double root = spread(&e->exact);
            const bool near = fabs(root - known_spread[model][k]) <= spread_tolerance[model][k];
            const bool fine = e->fitted.worst <= lobes_accepted && (near || e->exact.count == 0);
            printf("  %s, g %-5g %.1e (line %zu), %.1e, RMSE/mean %.2e (known %.2g)%s\n",
                   model == 0 ? "LTSD" : "MIX ", area_g[k], e->fitted.worst, e->fitted.line,
                   e->exact.worst, root, known_spread[model][k], fine ? "" : " TOO LARGE");
            good = good && fine;
        }
    }
    return good ? 0 : EXIT_WRONG;
}

/* ---- files ---- */

static int check_file(const char *path, bool skip_absent)
{
    static reference_table table;    /* 5 KB */
    static area_row rows[AREA_ROWS]; /* 600 KB */
    const bool read = table_open(&table, path);
    int code = EXIT_MALFORMED;
    if (table.file == NULL) {
        return oracle_not_open(path, skip_absent);
    }
    if (read && table_find(&table, "wox") >= 0) {
        code = check_polygons(path, rows);
    } else if (read && table_find(&table, "Tbar") >= 0) {
        code = check_haze(&table, rows, rows_beside(path, rows));
    } else if (read && table_find(&table, "S_ltsd_KL") >= 0) {
        code = check_lobes(&table, rows, rows_beside(path, rows));
    } else if (read) {
        (void)table_complain(&table, "a column wox, Tbar or S_ltsd_KL", "");
    }
    table_close(&table);
    return code;
}

int main(int argc, char **argv) { return oracle_main("oracle_arealight", argc, argv, check_file); }
