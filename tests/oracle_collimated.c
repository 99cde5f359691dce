/* Holds the collimated kernel against tables of reference values:
 *
 *     oracle_collimated [--skip-absent] FILE.csv...
 *
 * A table's header names its columns: B00 .. B23 (world to box) for boxes, or cx, cy, cz, inradius
 * for regular dodecahedra; ox .. oz, vx .. vz, lx .. lz, sigma_t, t_max; T_box or T, log_T,
 * t_begin, t_end, d_begin, the last three empty where T is 0. Prints rows, worst relative error and
 * where it is. Exit codes: 0 all within 1e-9, 1 not, 2 a file that is not such a table, 77 a file
 * is absent and --skip-absent was given. */
#include "airlight/collimated.h"
#include "oracle.h"
#include "reference_table.h"

/* Required of every row; the kernel itself reaches 1e-13. */
static const double accepted = 1e-9;

typedef struct row {
    air_collimated_medium medium;
    double origin[3], dir[3], to_light[3], sigma_t, t_max;
    double integral, log_integral, begin, end, d_begin;
    bool empty;
} row;

typedef enum quantity { INTEGRAL, LOG_INTEGRAL, BEGIN, END, D_BEGIN, BATCHED, QUANTITIES } quantity;

static const char *const quantity_names[QUANTITIES] = {"T",     "log T",   "t_begin",
                                                       "t_end", "d_begin", "T, batched"};

#ifdef AIR_COLLIMATED_EVAL
static const int tested = QUANTITIES;
#else
static const int tested = BATCHED; /* built without air_collimated_eval */
#endif

typedef struct worst_error {
    double error;
    size_t line;
} worst_error;

static bool vector(const reference_table *self, const char *prefix, double out[3])
{
    bool ok = true;
    for (int i = 0; i < 3 && ok; i++) {
        char name[TABLE_NAME];
        snprintf(name, sizeof name, "%s%c", prefix, "xyz"[i]);
        ok = table_number(self, name, &out[i]);
    }
    return ok;
}

static bool read_box(const reference_table *self, air_collimated_medium *out)
{
    double matrix[12];
    for (int i = 0; i < 12; i++) {
        char name[TABLE_NAME];
        snprintf(name, sizeof name, "B%d%d", i / 4, i % 4);
        if (!table_number(self, name, &matrix[i])) {
            return false;
        }
    }
    return air_collimated_medium_from_box(NULL, matrix, out) == AIR_OK ||
           table_complain(self, "a box that is not degenerate", "");
}

/* Twelve unit normals (0, +-1, +-g)/sqrt(1 + g^2) and their cyclic shifts, g the golden ratio. */
static bool read_dodecahedron(const reference_table *self, air_collimated_medium *out)
{
    double centre[3], inradius, planes[12][4];
    if (!vector(self, "c", centre) || !table_number(self, "inradius", &inradius)) {
        return false;
    }
    const double golden = 0.5 * (1.0 + sqrt(5.0)), length = sqrt(1.0 + golden * golden);
    for (int k = 0; k < 12; k++) {
        const int shift = k / 4;
        double *n = planes[k];
        n[shift] = 0.0;
        n[(shift + 1) % 3] = (k & 1 ? -1.0 : 1.0) / length;
        n[(shift + 2) % 3] = (k & 2 ? -golden : golden) / length;
        n[3] = inradius + (n[0] * centre[0] + n[1] * centre[1] + n[2] * centre[2]);
    }
    return air_collimated_medium_from_planes(NULL, (const double(*)[4])planes, 12, out) == AIR_OK ||
           table_complain(self, "a dodecahedron of finite numbers", "");
}

static bool read_row(const reference_table *self, row *out)
{
    const bool box = table_find(self, "B00") >= 0;
    bool ok = box ? read_box(self, &out->medium) : read_dodecahedron(self, &out->medium);
    ok = ok && vector(self, "o", out->origin) && vector(self, "v", out->dir) &&
         vector(self, "l", out->to_light) && table_number(self, "sigma_t", &out->sigma_t) &&
         table_number(self, "t_max", &out->t_max) &&
         table_number(self, box ? "T_box" : "T", &out->integral) &&
         table_number(self, "log_T", &out->log_integral);
    out->empty = ok && out->log_integral == -INFINITY;
    if (!ok || out->empty) {
        return ok;
    }
    return table_number(self, "t_begin", &out->begin) && table_number(self, "t_end", &out->end) &&
           table_number(self, "d_begin", &out->d_begin);
}

static double relative(double value, double reference)
{
    return value == reference ? 0.0 : fabs(value - reference) / fabs(reference);
}

/* Relative errors of everything about one row. Where T or log T is near or at a point where
 * relative error means little (T underflows; log T is 0), the other form of the same number
 * counts: |expm1(log T - log T')|. Distances may be 0: relative to the stretch's length too. */
static void row_errors(const row *r, double out[QUANTITIES])
{
    air_collimated_piece pieces[AIR_COLLIMATED_MAX_PIECES];
    air_collimated_profile profile = {.pieces = pieces, .capacity = AIR_COLLIMATED_MAX_PIECES};
    air_interval stretch = {0.0, 0.0};
    air_collimated_profile_make(&r->medium, r->to_light, r->sigma_t, r->origin, r->dir, r->t_max,
                                &profile);
    const bool inside = air_collimated_interval(&r->medium, r->origin, r->dir, r->t_max, &stretch);
    const double integral = air_collimated_integral(&profile);
    memset(out, 0, QUANTITIES * sizeof *out);
    if (r->empty) {
        out[INTEGRAL] = integral == 0.0 ? 0.0 : INFINITY;
        out[LOG_INTEGRAL] =
            air_collimated_log_integral(&profile) == -INFINITY && !inside ? 0.0 : INFINITY;
        return;
    }
    if (!inside || profile.count == 0) {
        out[INTEGRAL] = INFINITY;
        return;
    }
    const double length = r->end - r->begin;
    const double d_begin = (pieces[0].depth0 - pieces[0].camera0) / r->sigma_t;
    out[INTEGRAL] = r->integral >= 0x1p-1022 ? relative(integral, r->integral)
                                             : fabs(integral - r->integral) / 0x1p-1022;
    out[LOG_INTEGRAL] = fabs(expm1(air_collimated_log_integral(&profile) - r->log_integral));
    out[BEGIN] = fabs(stretch.begin - r->begin) / fmax(r->begin, length);
    out[END] = relative(stretch.end, r->end);
    out[D_BEGIN] = fabs(d_begin - r->d_begin) / fmax(r->d_begin, length);
}

/* The batched evaluation of the same row at every level of the machine: error of log T. */
static double batched_error(const row *r)
{
    double worst = 0.0;
#ifdef AIR_COLLIMATED_EVAL
    const air_collimated_rays rays = {.origin = {&r->origin[0], &r->origin[1], &r->origin[2]},
                                      .dir = {&r->dir[0], &r->dir[1], &r->dir[2]},
                                      .t_max = &r->t_max};
    for (air_cpu cpu = AIR_CPU_C; cpu <= AIR_CPU_AVX512; cpu++) {
        air_context_params params;
        air_context *context;
        double t, log_t;
        air_context_params_default(&params);
        params.cpu = cpu;
        if (air_context_create(&params, &context) != AIR_OK) {
            continue; /* above the machine's */
        }
        air_collimated_eval(context, &r->medium, r->to_light, r->sigma_t, &rays, 1, &t, &log_t);
        air_context_destroy(context);
        const double error = r->empty ? (t == 0.0 && log_t == -INFINITY ? 0.0 : INFINITY)
                                      : fmax(fabs(expm1(log_t - r->log_integral)),
                                             relative(t, exp(r->log_integral)));
        worst = !(error <= worst) ? error : worst;
    }
#else
    (void)r;
#endif
    return worst;
}

static int check_file(const char *path, bool skip_absent)
{
    static reference_table self; /* 7 KB */
    bool ok = table_open(&self, path);
    if (self.file == NULL) {
        return oracle_not_open(path, skip_absent);
    }
    worst_error worst[QUANTITIES] = {{0.0, 0}};
    size_t rows = 0;
    ok = ok && (table_find(&self, "B00") >= 0 || table_find(&self, "inradius") >= 0 ||
                table_complain(&self, "a column B00 or inradius", ""));
    while (table_next(&self, &ok)) {
        row r;
        double errors[QUANTITIES];
        ok = read_row(&self, &r);
        if (!ok) {
            break;
        }
        row_errors(&r, errors);
        errors[BATCHED] = batched_error(&r);
        for (int q = 0; q < QUANTITIES; q++) {
            if (!(errors[q] <= worst[q].error)) {
                worst[q] = (worst_error){errors[q], self.line};
            }
        }
        rows++;
    }
    table_close(&self);
    if (ok && rows == 0) {
        ok = table_complain(&self, "rows after the header", "");
    }
    if (!ok) {
        return EXIT_MALFORMED;
    }
    bool good = true;
    printf("%s: %zu rows; worst relative errors:\n", path, rows);
    for (int q = 0; q < tested; q++) {
        const bool fine = worst[q].error <= accepted;
        printf("  %-10s %.2e (line %zu)%s\n", quantity_names[q], worst[q].error, worst[q].line,
               fine ? "" : " TOO LARGE");
        good = good && fine;
    }
    return good ? 0 : EXIT_WRONG;
}

int main(int argc, char **argv) { return oracle_main("oracle_collimated", argc, argv, check_file); }
