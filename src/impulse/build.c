/* build.c: tables, row by row. A row is a bin of the distance: all emitters, asymmetries, angles
 * and bounces there.
 *
 * The inner integrals of (A1) do not know theta_s, and its outer ones, of the azimuth's clamp, know
 * nothing else. So the outer integrand is taken at fixed angles gamma, as a polynomial between
 * them, and its integrals against the clamp for each theta_s are weights that all rows, asymmetries
 * and bands share. */
#include "impulse/build.h"

#include <string.h>

#include "core/host.h"
#include "core/vec.h"

enum { GAMMA_NODES = 8, GAMMA_TOWARDS_0 = 12, GAMMA_TOWARDS_PI = 5 };
enum {
    GAMMA_PANELS = GAMMA_TOWARDS_0 + GAMMA_TOWARDS_PI + 2,
    GAMMA_COUNT = GAMMA_PANELS * GAMMA_NODES
};

struct impulse_plan {
    air_sh_factors factors;
    double gamma[GAMMA_COUNT];
    double *weights; /* [angle][m][gamma] */
    double theta_s[TABLES_ANGLES_MAX];
    int order;
    impulse_curves curves;
    impulse_half_space half_space;
};

void impulse_plan_destroy(air_context *context, impulse_plan *plan)
{
    if (plan != NULL) {
        air_free(context, plan->weights);
        air_free(context, plan);
    }
}

/* ---- the outer integral of area patches ---- */

/* The panel's ends. */
static void gamma_panel(int panel, double *a, double *b)
{
    const double half = 0.5 * AIR_PI;
    if (panel <= GAMMA_TOWARDS_0) {
        *b = ldexp(half, panel - GAMMA_TOWARDS_0);
        *a = panel == 0 ? 0.0 : 0.5 * *b;
    } else {
        const int i = panel - GAMMA_TOWARDS_0 - 1; /* 0 .. GAMMA_TOWARDS_PI */
        *a = AIR_PI - ldexp(half, -i);
        *b = i == GAMMA_TOWARDS_PI ? AIR_PI : AIR_PI - ldexp(half, -i - 1);
    }
}

/* Adds the integrals over [a, b], a piece of the panel whose ends are from and to, of the moments
 * against each of the panel's polynomials. */
static void add_piece(const graded_rule *nodes, double theta_s, int order, double from, double to,
                      double a, double b, double *weights)
{
    const graded_rule rule = graded_rule_make(8);
    graded_list list = {.count = 0};
    double moments[AIR_IMPULSE_ORDER];
    graded_both(&list, &rule, a, b, 6, 6);
    for (int q = 0; q < list.count; q++) {
        const double angle = list.x[q], x = (angle - from) / (to - from);
        impulse_clamped_moments(cos(theta_s) * cos(angle), sin(theta_s) * sin(angle), order,
                                moments);
        for (int i = 0; i < GAMMA_NODES; i++) {
            double value = list.w[q];
            for (int j = 0; j < GAMMA_NODES; j++) {
                value *= i == j ? 1.0 : (x - nodes->x[j]) / (nodes->x[i] - nodes->x[j]);
            }
            for (int m = 0; m < order; m++) {
                weights[(size_t)m * GAMMA_COUNT + (size_t)i] += value * moments[m];
            }
        }
    }
}

static void angle_weights(impulse_plan *plan, size_t angle)
{
    const graded_rule nodes = graded_rule_make(GAMMA_NODES);
    const double theta_s = plan->theta_s[angle];
    double cuts[2];
    double *const weights = plan->weights + angle * (size_t)plan->order * GAMMA_COUNT;
    impulse_clamp_cuts(theta_s, cuts);
    for (int panel = 0; panel < GAMMA_PANELS; panel++) {
        double from, to;
        gamma_panel(panel, &from, &to);
        double ends[4] = {from, double_min(to, double_max(from, cuts[0])),
                          double_min(to, double_max(from, cuts[1])), to};
        for (int i = 0; i < 3; i++) {
            if (ends[i + 1] - ends[i] > 1e-14) {
                add_piece(&nodes, theta_s, plan->order, from, to, ends[i], ends[i + 1],
                          weights + panel * GAMMA_NODES);
            }
        }
    }
}

/* ---- plan ---- */

static void plan_angles(impulse_plan *plan, size_t angles)
{
    const graded_rule nodes = graded_rule_make(GAMMA_NODES);
    for (int panel = 0; panel < GAMMA_PANELS; panel++) {
        double from, to;
        gamma_panel(panel, &from, &to);
        for (int i = 0; i < GAMMA_NODES; i++) {
            plan->gamma[panel * GAMMA_NODES + i] = from + (to - from) * nodes.x[i];
        }
    }
    for (size_t i = 0; i < angles; i++) {
        plan->theta_s[i] = impulse_angle(angles, i);
        angle_weights(plan, i);
    }
}

/* One after the other where context is NULL. */
static void plan_ratio(void *user, size_t i, size_t worker)
{
    (void)worker;
    impulse_curves_ratios(user, (int)i);
}

static air_status plan_bounces(air_impulse_tables *self, bool threads)
{
    impulse_plan *const plan = self->plan;
    double *const matrix =
        air_allocate(self->context, (size_t)HALF_COUNT * HALF_COUNT, sizeof(double));
    if (matrix == NULL) {
        return air_fail_memory(self->context, "impulse tables");
    }
    impulse_half_space_solve(self->params.bounces - 1, &plan->half_space, matrix);
    air_free(self->context, matrix);
    impulse_curves_fluences(self->params.bounces - 1, &plan->curves);
    if (threads) {
        air_parallel_for(self->context, CURVE_POINTS, plan_ratio, &plan->curves);
    }
    for (size_t i = 0; i < CURVE_POINTS && !threads; i++) {
        plan_ratio(&plan->curves, i, 0);
    }
    return AIR_OK;
}

static air_status begin(air_context *context, const air_impulse_params *params, bool threads,
                        air_impulse_tables **out)
{
    air_impulse_params standard;
    air_impulse_params_default(&standard);
    air_status status = impulse_tables_allocate(context, params == NULL ? &standard : params, out);
    if (status != AIR_OK) {
        return status;
    }
    air_impulse_tables *const self = *out;
    const bool fitted = self->params.form >= AIR_IMPULSE_ZH11_ENERGY;
    const int order = fitted ? AIR_IMPULSE_ORDER : impulse_form_order(self->params.form);
    impulse_plan *const plan = self->plan = air_allocate(context, 1, sizeof *plan);
    if (plan != NULL) {
        plan->order = order;
        air_sh_factors_init(order, &plan->factors);
        plan->weights =
            air_allocate(context, self->angles * (size_t)order * GAMMA_COUNT, sizeof(double));
    }
    if (plan == NULL || plan->weights == NULL) {
        status = air_fail_memory(context, "impulse tables");
    } else {
        plan_angles(plan, self->angles);
        status = self->params.bounces > 1 ? plan_bounces(self, threads) : AIR_OK;
    }
    if (status != AIR_OK) {
        air_impulse_tables_destroy(self);
        *out = NULL;
    }
    return status;
}

air_status air_impulse_tables_begin(air_context *context, const air_impulse_params *params,
                                    air_impulse_tables **out)
{
    return begin(context, params, false, out);
}

/* ---- rows ---- */

size_t air_impulse_row_count(const air_impulse_tables *tables) { return tables->params.bins; }

static size_t mirrored_count(const air_impulse_tables *tables)
{
    const size_t order = (size_t)tables->plan->order;
    return order * (order + 1) / 2;
}

/* Sums for each angle and asymmetry, one node's values, and what multiple events give. */
size_t air_impulse_row_scratch(const air_impulse_tables *tables)
{
    const size_t single = (tables->angles + 1) * tables->params.g_count * mirrored_count(tables);
    const size_t multiple = (size_t)(tables->params.bounces + 1) *
                            (tables->angles * MULTIPLE_COUNT + AIR_IMPULSE_ORDER);
    return (single > multiple ? single : multiple) * sizeof(double);
}

static void store(float *out, const double *from, int count)
{
    for (int i = 0; i < count; i++) {
        out[i] = (float)from[i];
    }
}

static void zonal_single(air_impulse_tables *self, size_t bin, double tau)
{
    const impulse_quality quality = impulse_quality_table();
    const int count = (int)self->params.g_count;
    double zh[AIR_IMPULSE_G_MAX * AIR_IMPULSE_ORDER];
    for (int emitter = 0; emitter < 2; emitter++) {
        float *const table = emitter == 0 ? self->point : self->directional;
        if (emitter == 0) {
            impulse_point_scaled(&quality, tau, self->params.g, count, AIR_IMPULSE_ORDER, zh,
                                 AIR_IMPULSE_ORDER);
        } else {
            impulse_directional_scaled(&quality, tau, self->params.g, count, AIR_IMPULSE_ORDER, zh,
                                       AIR_IMPULSE_ORDER);
        }
        for (size_t i = 0; i < self->params.g_count; i++) {
            store(table + (i * self->params.bins + bin) * ZONAL_STRIDE, zh + i * AIR_IMPULSE_ORDER,
                  AIR_IMPULSE_ORDER);
        }
    }
}

/* An entry of the area table from the coefficients of the plan's order. */
static void store_area(const air_impulse_tables *self, const double *sh, float *out)
{
    double zh[AIR_IMPULSE_ORDER];
    if (self->params.form < AIR_IMPULSE_ZH11_ENERGY) {
        store(out, sh, impulse_form_count(self->params.form));
    } else {
        const double tilt = impulse_fit_axis(self->params.form, sh, zh);
        store(out, zh, AIR_IMPULSE_ORDER);
        out[AIR_IMPULSE_ORDER] = (float)sin(tilt);
    }
}

/* sums[angle][g][c] += the moments' weights times values[g][c]. */
static void add_gamma(const air_impulse_tables *self, int node, const double *values, double *sums)
{
    const impulse_plan *const plan = self->plan;
    const size_t count = mirrored_count(self), order = (size_t)plan->order;
    for (size_t angle = 0; angle < self->angles; angle++) {
        double weights[AIR_IMPULSE_SH_COUNT];
        for (size_t l = 0, c = 0; l < order; l++) {
            for (size_t m = 0; m <= l; m++, c++) {
                weights[c] = plan->weights[(angle * order + m) * GAMMA_COUNT + (size_t)node];
            }
        }
        for (size_t i = 0; i < self->params.g_count; i++) {
            double *const to = sums + (angle * self->params.g_count + i) * count;
            for (size_t c = 0; c < count; c++) {
                to[c] += weights[c] * values[i * count + c];
            }
        }
    }
}

static void area_single(air_impulse_tables *self, size_t bin, double tau, double *scratch)
{
    const impulse_quality quality = impulse_quality_table();
    const size_t count = mirrored_count(self), g_count = self->params.g_count;
    const size_t sum_count = self->angles * g_count * count;
    double *const values = scratch + sum_count;
    memset(scratch, 0, sum_count * sizeof *scratch);
    for (int node = 0; node < GAMMA_COUNT; node++) {
        impulse_area_inner(&quality, &self->plan->factors, tau, self->plan->gamma[node],
                           self->params.g, (int)g_count, values, (int)count);
        add_gamma(self, node, values, scratch);
    }
    for (size_t i = 0; i < g_count; i++) {
        for (size_t angle = 0; angle < self->angles; angle++) {
            store_area(self, scratch + (angle * g_count + i) * count,
                       self->area + ((i * self->params.bins + bin) * self->angles + angle) *
                                        self->area_stride);
        }
    }
}

static void multiple(air_impulse_tables *self, size_t bin, double tau, double *scratch)
{
    const impulse_quality quality = impulse_quality_multiple();
    const int k_max = self->params.bounces, angles = (int)self->angles;
    const size_t more = (size_t)(k_max - 1), order = AIR_IMPULSE_ORDER;
    float *const tables[2] = {self->point_multiple, self->directional_multiple};
    for (int emitter = 0; emitter < 2; emitter++) {
        if (emitter == 0) {
            impulse_point_multiple(&quality, &self->plan->curves, tau, 2, k_max, AIR_IMPULSE_ORDER,
                                   scratch, AIR_IMPULSE_ORDER);
        } else {
            impulse_directional_multiple(&self->plan->half_space, tau, 2, k_max, AIR_IMPULSE_ORDER,
                                         scratch, AIR_IMPULSE_ORDER);
        }
        for (size_t k = 0; k < more; k++) {
            store(tables[emitter] + (bin * more + k) * ZONAL_STRIDE, scratch + (k + 2) * order,
                  AIR_IMPULSE_ORDER);
        }
    }
    impulse_area_multiple(&quality, &self->plan->curves, tau, k_max, self->plan->theta_s, angles,
                          scratch, MULTIPLE_COUNT);
    for (size_t k = 0; k < more; k++) {
        for (size_t angle = 0; angle < self->angles; angle++) {
            store(self->area_multiple +
                      ((bin * self->angles + angle) * more + k) * AREA_MULTIPLE_STRIDE,
                  scratch + ((k + 2) * self->angles + angle) * MULTIPLE_COUNT, MULTIPLE_COUNT);
        }
    }
}

void air_impulse_build_row(air_impulse_tables *tables, size_t row, void *scratch)
{
    const double tau = impulse_bin_tau(tables->params.bins, row);
    zonal_single(tables, row, tau);
    area_single(tables, row, tau, scratch);
    if (tables->params.bounces > 1) {
        multiple(tables, row, tau, scratch);
    }
}

typedef struct building {
    air_impulse_tables *tables;
    char *scratch;
    size_t bytes;
} building;

static void build_row(void *user, size_t row, size_t worker)
{
    const building *const self = user;
    air_impulse_build_row(self->tables, row, self->scratch + worker * self->bytes);
}

air_status air_impulse_tables_create(air_context *context, const air_impulse_params *params,
                                     air_impulse_tables **out)
{
    air_status status = begin(context, params, true, out);
    if (status != AIR_OK) {
        return status;
    }
    building job = {.tables = *out, .bytes = air_impulse_row_scratch(*out)};
    job.scratch = air_allocate(context, air_context_thread_count(context), job.bytes);
    if (job.scratch == NULL) {
        air_impulse_tables_destroy(*out);
        *out = NULL;
        return air_fail_memory(context, "impulse tables");
    }
    air_parallel_for(context, (*out)->params.bins, build_row, &job);
    air_free(context, job.scratch);
    impulse_plan_destroy(context, (*out)->plan);
    (*out)->plan = NULL;
    return AIR_OK;
}
