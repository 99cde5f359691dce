/* lookup.c: coefficients and irradiance from tables, in the units of a medium. */
#include <string.h>

#include "core/vec.h"
#include "impulse/lookup.h"
#include "impulse/polynomial.h"

/* ---- which bounces, of which medium ---- */

impulse_sum impulse_sum_of(const air_impulse_params *params, const air_impulse_medium *medium,
                           int first, int last)
{
    const double g = medium->g, absorbed = medium->sigma_t - medium->sigma_s;
    const double reduced = (1.0 - g) * medium->sigma_s;
    int bounces = medium->bounces < params->bounces ? medium->bounces : params->bounces;
    impulse_sum sum = {.sigma_t = medium->sigma_t,
                       .albedo = medium->sigma_t > 0.0 ? medium->sigma_s / medium->sigma_t : 0.0,
                       .g = g,
                       .first = first,
                       .reduced_sigma_t = absorbed + reduced};
    sum.reduced_albedo = sum.reduced_sigma_t > 0.0 ? reduced / sum.reduced_sigma_t : 0.0;
    sum.residual = medium->rule == AIR_IMPULSE_RESIDUAL && g > 0.0 && bounces > 1;
    if (sum.residual) {
        const int fewer = (int)lround((1.0 - g) * bounces);
        sum.g = 0.0;
        sum.sigma_t = sum.reduced_sigma_t;
        sum.albedo = sum.reduced_albedo;
        bounces = fewer > 1 ? fewer : 1;
    }
    sum.last = last < bounces ? last : bounces;
    return sum;
}

air_impulse_medium impulse_sum_medium(const impulse_sum *sum, const air_impulse_medium *medium)
{
    return sum->residual ? (air_impulse_medium){.sigma_s = sum->albedo * sum->sigma_t,
                                                .sigma_t = sum->sigma_t,
                                                .bounces = sum->last}
                         : *medium;
}

double impulse_sum_excess(const impulse_sum *sum, const air_impulse_medium *medium,
                          air_impulse_emitter emitter, double distance, double cos_s)
{
    if (!sum->residual || sum->first > 1) {
        return 0.0;
    }
    const double more = exp(-sum->reduced_sigma_t * distance) - exp(-medium->sigma_t * distance);
    return emitter == AIR_IMPULSE_DIRECTIONAL
               ? more
               : more / (distance * distance) *
                     (emitter == AIR_IMPULSE_AREA ? double_max(0.0, cos_s) : 1.0);
}

/* What turns a table's entry at tau into the response of one event, or, times albedo^k, of k. */
static double unscale(double sigma_t, double tau, air_impulse_emitter emitter)
{
    return exp(-tau) * (emitter == AIR_IMPULSE_DIRECTIONAL ? 1.0 : sigma_t * sigma_t);
}

static double unscale_single(const impulse_sum *sum, double tau, air_impulse_emitter emitter)
{
    return sum->albedo * unscale(sum->sigma_t, tau, emitter) /
           (emitter == AIR_IMPULSE_DIRECTIONAL ? 1.0 : tau);
}

static double held(double tau) { return tau > 0.0 ? tau : 1e-30; }

/* ---- point and directional ---- */

static void add_zonal(const float *a, const float *b, double share, double scale, double *out)
{
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        out[l] += scale * (a[l] + share * (b[l] - a[l]));
    }
}

static void zonal_single(const air_impulse_tables *tables, air_impulse_emitter emitter, double g,
                         double tau, double scale, double *out)
{
    const size_t bins = tables->params.bins;
    const impulse_between bin = impulse_find_bin(bins, tau);
    const impulse_between knot = impulse_find_g(&tables->params, g);
    const float *const table = emitter == AIR_IMPULSE_POINT ? tables->point : tables->directional;
    for (size_t i = 0; i < 2; i++) {
        const double part = i == 0 ? 1.0 - knot.share : knot.share;
        if (part > 0.0) {
            const float *const at = table + ((knot.lower + i) * bins + bin.lower) * ZONAL_STRIDE;
            add_zonal(at, at + ZONAL_STRIDE, bin.share, scale * part, out);
        }
    }
}

void air_impulse_zonal(const air_impulse_tables *tables, air_impulse_emitter emitter,
                       const air_impulse_medium *medium, int first, int last, double distance,
                       double *out_zh)
{
    const impulse_sum sum = impulse_sum_of(&tables->params, medium, first, last);
    const size_t more = (size_t)(tables->params.bounces - 1);
    const double tau = held(sum.sigma_t * distance), reduced = held(sum.reduced_sigma_t * distance);
    const double excess = impulse_sum_excess(&sum, medium, emitter, distance, 0.0);
    air_zh_evaluate(AIR_IMPULSE_ORDER, 1.0, out_zh);
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        out_zh[l] *= excess;
    }
    if (sum.first == 1 && sum.last >= 1 && tau <= IMPULSE_TAU_GREATEST) {
        zonal_single(tables, emitter, sum.g, tau, unscale_single(&sum, tau, emitter), out_zh);
    }
    if (!(reduced <= IMPULSE_TAU_GREATEST) || sum.last < 2) {
        return;
    }
    const impulse_between bin = impulse_find_bin(tables->params.bins, reduced);
    const float *const table =
        emitter == AIR_IMPULSE_POINT ? tables->point_multiple : tables->directional_multiple;
    const int start = sum.first > 2 ? sum.first : 2;
    double scale = unscale(sum.reduced_sigma_t, reduced, emitter) * pow(sum.reduced_albedo, start);
    for (int k = start; k <= sum.last; k++, scale *= sum.reduced_albedo) {
        const float *const at = table + (bin.lower * more + (size_t)(k - 2)) * ZONAL_STRIDE;
        add_zonal(at, at + more * ZONAL_STRIDE, bin.share, scale, out_zh);
    }
}

/* ---- area ---- */

/* The mean of four corners: bins and angles, step apart. */
static void blend(const float *at, size_t bin_step, size_t angle_step, double bin, double angle,
                  int count, double *out)
{
    for (int c = 0; c < count; c++) {
        const double near = at[c] + angle * (at[angle_step + (size_t)c] - at[c]);
        const float *const next = at + bin_step;
        const double far = next[c] + angle * (next[angle_step + (size_t)c] - next[c]);
        out[c] = near + bin * (far - near);
    }
}

/* Zonal coefficients about an axis, sin(tilt) behind them, to mirrored ones. */
static void untilt(const air_sh_factors *factors, const double *entry, double scale, double *out)
{
    double y[AIR_SH_MIRRORED_MAX];
    const double s = double_max(-1.0, double_min(1.0, entry[AIR_IMPULSE_ORDER]));
    air_sh_meridian(factors, sqrt(1.0 - s * s), s, y);
    for (int l = 0, c = 0; l < AIR_IMPULSE_ORDER; l++) {
        const double value = scale * air_zh_scale(l) * entry[l];
        for (int m = 0; m <= l; m++, c++) {
            out[c] += value * y[c];
        }
    }
}

static void area_single(const air_impulse_tables *tables, double g, impulse_between bin,
                        impulse_between angle, double scale, double *out)
{
    const air_impulse_params *const p = &tables->params;
    const impulse_between knot = impulse_find_g(p, g);
    const size_t bin_step = tables->angles * tables->area_stride;
    const int count = impulse_form_count(p->form);
    double entry[AIR_IMPULSE_SH_COUNT];
    for (size_t i = 0; i < 2; i++) {
        const double part = i == 0 ? 1.0 - knot.share : knot.share;
        if (!(part > 0.0)) {
            continue;
        }
        blend(tables->area + ((knot.lower + i) * p->bins + bin.lower) * bin_step +
                  angle.lower * tables->area_stride,
              bin_step, tables->area_stride, bin.share, angle.share, count, entry);
        if (p->form < AIR_IMPULSE_ZH11_ENERGY) {
            for (int c = 0; c < count; c++) {
                out[c] += scale * part * entry[c];
            }
        } else {
            air_sh_factors factors;
            air_sh_factors_init(AIR_IMPULSE_ORDER, &factors);
            untilt(&factors, entry, scale * part, out);
        }
    }
}

int air_impulse_mirrored(const air_impulse_tables *tables, const air_impulse_medium *medium,
                         int first, int last, double distance, double cos_s, double *out_sh)
{
    const air_impulse_params *const p = &tables->params;
    const impulse_sum sum = impulse_sum_of(p, medium, first, last);
    const size_t more = (size_t)(p->bounces - 1), step = more * AREA_MULTIPLE_STRIDE;
    const double tau = held(sum.sigma_t * distance), reduced = held(sum.reduced_sigma_t * distance);
    const double excess = impulse_sum_excess(&sum, medium, AIR_IMPULSE_AREA, distance, cos_s);
    const impulse_between angle = impulse_find_angle(tables->angles, cos_s);
    const int order = impulse_form_order(p->form);
    memset(out_sh, 0, AIR_IMPULSE_SH_COUNT * sizeof *out_sh);
    for (int l = 0; l < order; l++) {
        out_sh[l * (l + 1) / 2] = excess * sqrt((2 * l + 1) / (4.0 * AIR_PI));
    }
    if (sum.first == 1 && sum.last >= 1 && tau <= IMPULSE_TAU_GREATEST) {
        area_single(tables, sum.g, impulse_find_bin(p->bins, tau), angle,
                    unscale_single(&sum, tau, AIR_IMPULSE_AREA), out_sh);
    }
    if (!(reduced <= IMPULSE_TAU_GREATEST)) {
        return order;
    }
    const impulse_between bin = impulse_find_bin(p->bins, reduced);
    const int start = sum.first > 2 ? sum.first : 2;
    double scale =
        unscale(sum.reduced_sigma_t, reduced, AIR_IMPULSE_AREA) * pow(sum.reduced_albedo, start);
    for (int k = start; k <= sum.last; k++, scale *= sum.reduced_albedo) {
        double entry[MULTIPLE_COUNT];
        blend(tables->area_multiple + (bin.lower * tables->angles + angle.lower) * step +
                  (size_t)(k - 2) * AREA_MULTIPLE_STRIDE,
              tables->angles * step, step, bin.share, angle.share, MULTIPLE_COUNT, entry);
        for (int c = 0; c < MULTIPLE_COUNT; c++) {
            out_sh[c] += scale * entry[c];
        }
    }
    return order;
}

/* ---- irradiance ---- */

/* The excess of the residual rule is a direction's and needs no bands. */
double air_impulse_irradiance(const air_impulse_tables *tables, air_impulse_emitter emitter,
                              const air_impulse_medium *medium, const air_impulse_place *place)
{
    /* A_l of max(0, cos): what air_zh_clamped_cosine gives */
    static const double lobe[AIR_IMPULSE_ORDER] = {0.88622692545275801,   1.0233267079464885,
                                                   0.49541591220075137,   0.0,
                                                   -0.11077836568159474,  0.0,
                                                   0.049927134709636271,  0.0,
                                                   -0.028546931421157107, 0.0,
                                                   0.018508081889040854};
    double coefficients[AIR_IMPULSE_SH_COUNT], powers[AREA_POWERS], e;
    const impulse_sum sum = impulse_sum_of(&tables->params, medium, 1, medium->bounces);
    const air_impulse_medium plain = impulse_sum_medium(&sum, medium);
    if (emitter == AIR_IMPULSE_AREA) {
        const int order = air_impulse_mirrored(tables, &plain, 1, plain.bounces, place->distance,
                                               place->cos_s, coefficients);
        if (order > 5) {
            e = air_impulse_mirrored_receive(order, coefficients, lobe, place->n_l, place->n_x);
        } else {
            impulse_area_polynomial(coefficients, powers);
            e = impulse_area_polynomial_at(powers, place->n_l, place->n_x);
        }
    } else {
        air_impulse_zonal(tables, emitter, &plain, 1, plain.bounces, place->distance, coefficients);
        e = air_impulse_zonal_receive(AIR_IMPULSE_ORDER, coefficients, lobe, place->n_l);
    }
    e += impulse_sum_excess(&sum, medium, emitter, place->distance, place->cos_s) *
         double_max(0.0, place->n_l);
    return double_max(0.0, e);
}
