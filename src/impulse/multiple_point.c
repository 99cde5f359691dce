/* multiple_point.c: two or more events, point light and, by reciprocity, area patch.
 *
 * With r the distance from the emitter and t that from x, dV = 2 pi (t r/d) dt dr for what depends
 * on both alone, so
 *
 *     c_l = integral over r of Phi(r) r/(2 d) W_l(r), W_l = integral of exp(-t)/t y_l(theta) dt
 *
 * over |d - r| < t < d + r: a kernel that serves all orders k at once. */
#include <math.h>

#include "core/vec.h"
#include "impulse/multiple.h"

/* ---- curves ---- */

void impulse_curves_fluences(int k_max, impulse_curves *out)
{
    double scaled[IMPULSE_K + 1];
    out->k_max = k_max;
    for (int i = 0; i < CURVE_POINTS; i++) {
        const double r = impulse_curve_distance(i);
        impulse_fluences_scaled(k_max, r, scaled);
        for (int k = 0; k <= k_max; k++) {
            out->fluence[k][i] = log(r * (k == 0 ? 1.0 / (r * r) : scaled[k]));
        }
    }
}

void impulse_curves_ratios(impulse_curves *self, int i)
{
    const impulse_quality quality = impulse_quality_table();
    double c[(IMPULSE_K + 1) * AIR_IMPULSE_ORDER];
    impulse_point_multiple(&quality, self, impulse_curve_distance(i), 1, self->k_max,
                           AIR_IMPULSE_ORDER, c, AIR_IMPULSE_ORDER);
    for (int k = 1; k <= self->k_max; k++) {
        const double *const row = c + k * AIR_IMPULSE_ORDER;
        for (int b = 0; b < CLAMPED_BANDS; b++) {
            self->ratio[k][b][i] = row[clamped_band(b)] / (sqrt(4.0 * AIR_PI) * row[0]);
        }
    }
}

static void fluences_at(const impulse_curves *self, const impulse_curve_place *place, int k_max,
                        double r, double *out)
{
    for (int k = 0; k <= k_max; k++) {
        out[k] = exp(impulse_curve_at(self->fluence[k], place)) / r;
    }
}

void impulse_curves_at(const impulse_curves *self, int k_max, double r, double *out)
{
    const impulse_curve_place place = impulse_curve_find(r);
    fluences_at(self, &place, k_max, r, out);
}

/* ---- the two distances ---- */

/* r: halved towards the emitter at 0 and towards d, where W has a logarithm. Beyond, both
 * exponentials fall. */
static void distances(const impulse_quality *q, double d, graded_list *out)
{
    const double end = d + q->cut;
    graded_both(out, &q->rule, 0.0, d, 6, q->levels);
    graded_towards(out, &q->rule, d, 2.0 * d, q->levels);
    for (double from = 2.0 * d; from < end;) {
        const double to = double_min(end, from + double_min(from, 4.0));
        graded_panel(out, &q->rule, from, to);
        from = to;
    }
}

/* t for one r, weights times exp(d - r - t)/t: panels double with t and stay short against the
 * exponential. */
static void chords(const impulse_quality *q, double d, double r, graded_list *out)
{
    const double first = fabs(d - r), last = d + r;
    double from = first;
    out->count = 0;
    while (from < last && from + r - d < q->cut) {
        const double to = double_min(last, from + double_min(from, 3.0));
        const int start = out->count;
        graded_panel(out, &q->rule, from, to);
        for (int i = start; i < out->count; i++) {
            out->w[i] *= exp(d - r - out->x[i]) / out->x[i];
        }
        from = to;
    }
}

static double clamped(double x) { return double_max(-1.0, double_min(1.0, x)); }

static double cosine_at_receiver(double d, double r, double t)
{
    return clamped(0.5 * (t + (d - r) * (d + r) / t) / d);
}

static double cosine_at_emitter(double d, double r, double t)
{
    return clamped(0.5 * (r + (d - t) * (d + t) / r) / d);
}

static void zonal_kernel(const impulse_quality *q, const air_sh_factors *factors, double d,
                         double r, double *out)
{
    graded_list t;
    chords(q, d, r, &t);
    for (int l = 0; l < factors->order; l++) {
        out[l] = 0.0;
    }
    for (int i = 0; i < t.count; i++) {
        const double cosine = cosine_at_receiver(d, r, t.x[i]);
        double before = 0.0, y = factors->zonal[0] * t.w[i];
        for (int l = 0; l < factors->order; l++) {
            const int next = (l + 1) * (l + 2) / 2;
            out[l] += y;
            if (l + 1 < factors->order) {
                const double after = factors->a[next] * cosine * y - factors->b[next] * before;
                before = y;
                y = after;
            }
        }
    }
}

void impulse_point_multiple(const impulse_quality *quality, const impulse_curves *curves, double d,
                            int k_min, int k_max, int order, double *out, int stride)
{
    air_sh_factors factors;
    graded_list r = {.count = 0};
    double kernel[AIR_IMPULSE_ORDER], fluence[IMPULSE_K + 1];
    air_sh_factors_init(order, &factors);
    distances(quality, d, &r);
    for (int k = k_min; k <= k_max; k++) {
        for (int l = 0; l < order; l++) {
            out[k * stride + l] = 0.0;
        }
    }
    for (int j = 0; j < r.count; j++) {
        zonal_kernel(quality, &factors, d, r.x[j], kernel);
        impulse_curves_at(curves, k_max - 1, r.x[j], fluence);
        for (int k = k_min; k <= k_max; k++) {
            const double weight = r.w[j] * r.x[j] / (2.0 * d) * fluence[k - 1];
            for (int l = 0; l < order; l++) {
                out[k * stride + l] += weight * kernel[l];
            }
        }
    }
}

/* ---- area patches: the fluence around one is the sum over bands n of A_n c_n(r) P_n(cos gamma),
 * gamma the angle to n_s; by the addition theorem a sum of products of y_nm. ---- */

typedef double area_kernel[MULTIPLE_COUNT][CLAMPED_BANDS];

static void area_kernel_at(const impulse_quality *q, const air_sh_factors *receiver,
                           const air_sh_factors *emitter, double d, double r, area_kernel out)
{
    graded_list t;
    double y[AIR_SH_MIRRORED_MAX], z[AIR_SH_MIRRORED_MAX];
    chords(q, d, r, &t);
    for (int c = 0; c < MULTIPLE_COUNT; c++) {
        for (int b = 0; b < CLAMPED_BANDS; b++) {
            out[c][b] = 0.0;
        }
    }
    for (int i = 0; i < t.count; i++) {
        const double cos_x = cosine_at_receiver(d, r, t.x[i]);
        const double cos_e = cosine_at_emitter(d, r, t.x[i]);
        air_sh_meridian(receiver, cos_x, sqrt(1.0 - cos_x * cos_x), y);
        air_sh_meridian(emitter, cos_e, sqrt(1.0 - cos_e * cos_e), z);
        for (int l = 0, c = 0; l < MULTIPLE_ORDER; l++) {
            for (int m = 0; m <= l; m++, c++) {
                for (int b = 0; b < CLAMPED_BANDS; b++) {
                    const int n = clamped_band(b);
                    out[c][b] += n >= m ? t.w[i] * y[c] * z[n * (n + 1) / 2 + m] : 0.0;
                }
            }
        }
    }
}

/* From sums over r to coefficients for one angle. */
static void area_turn(const air_sh_factors *emitter, const double *clamped_cosine, area_kernel sum,
                      double theta_s, double *out)
{
    double y[AIR_SH_MIRRORED_MAX];
    air_sh_meridian(emitter, cos(theta_s), sin(theta_s), y);
    for (int l = 0, c = 0; l < MULTIPLE_ORDER; l++) {
        for (int m = 0; m <= l; m++, c++) {
            out[c] = 0.0;
            for (int b = 0; b < CLAMPED_BANDS; b++) {
                const int n = clamped_band(b);
                if (n >= m) {
                    out[c] += clamped_cosine[n] * 4.0 * AIR_PI / (2 * n + 1) *
                              y[n * (n + 1) / 2 + m] * sum[c][b] * (m == 0 ? 1.0 : 0.5);
                }
            }
        }
    }
}

void impulse_area_multiple(const impulse_quality *quality, const impulse_curves *curves, double d,
                           int k_max, const double *theta_s, int count, double *out, int stride)
{
    air_sh_factors receiver, emitter;
    graded_list r = {.count = 0};
    double clamped_cosine[AIR_IMPULSE_ORDER], fluence[IMPULSE_K + 1];
    area_kernel kernel, sums[IMPULSE_K + 1] = {{{0.0}}};
    air_sh_factors_init(MULTIPLE_ORDER, &receiver);
    air_sh_factors_init(AIR_IMPULSE_ORDER, &emitter);
    emitter.azimuths = MULTIPLE_ORDER;
    air_zh_clamped_cosine(AIR_IMPULSE_ORDER, clamped_cosine);
    distances(quality, d, &r);
    for (int j = 0; j < r.count; j++) {
        const impulse_curve_place place = impulse_curve_find(r.x[j]);
        area_kernel_at(quality, &receiver, &emitter, d, r.x[j], kernel);
        fluences_at(curves, &place, k_max - 1, r.x[j], fluence);
        for (int k = 2; k <= k_max; k++) {
            const double weight = r.w[j] * r.x[j] / (2.0 * d) * fluence[k - 1];
            for (int b = 0; b < CLAMPED_BANDS; b++) {
                const double c_n = weight * impulse_curve_at(curves->ratio[k - 1][b], &place);
                for (int c = 0; c < MULTIPLE_COUNT; c++) {
                    sums[k][c][b] += c_n * kernel[c][b];
                }
            }
        }
    }
    for (int k = 2; k <= k_max; k++) {
        for (int i = 0; i < count; i++) {
            area_turn(&emitter, clamped_cosine, sums[k], theta_s[i],
                      out + (k * count + i) * stride);
        }
    }
}
