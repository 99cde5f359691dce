/* single_area.c: one event, light of a small patch: (A1). */
#include <math.h>

#include "airlight/impulse.h"
#include "core/vec.h"
#include "impulse/single.h"

void impulse_clamped_moments(double a, double b, int order, double *out)
{
    for (int m = 0; m < order; m++) {
        out[m] = 0.0;
    }
    if (a >= b) {
        out[0] = 2.0 * AIR_PI * a;
        if (order > 1) {
            out[1] = AIR_PI * b;
        }
        return;
    }
    if (a <= -b) {
        return;
    }
    const double cosine = -a / b, phi = acos(cosine);
    double before = 0.0, sine = sqrt(double_max(0.0, 1.0 - cosine * cosine)); /* sin(m phi) */
    out[0] = 2.0 * (a * phi + b * sine);
    for (int m = 1; m < order; m++) {
        const double after = 2.0 * cosine * sine - before;
        const double lower = m == 1 ? phi : before / (m - 1);
        out[m] = 2.0 * (a * sine / m + 0.5 * b * (after / (m + 1) + lower));
        before = sine;
        sine = after;
    }
}

void impulse_clamp_cuts(double theta_s, double out[2])
{
    out[0] = fabs(0.5 * AIR_PI - theta_s);
    out[1] = theta_s <= 0.5 * AIR_PI ? 0.5 * AIR_PI + theta_s : 1.5 * AIR_PI - theta_s;
}

typedef struct area_inner {
    const air_sh_factors *factors;
    const double *g;
    int g_count, coefficients, stride;
    /* of the phase functions */
    double minus[AIR_IMPULSE_G_MAX], square[AIR_IMPULSE_G_MAX], twice[AIR_IMPULSE_G_MAX];
    double *out;
} area_inner;

/* One node: y_lm(theta) p(theta + gamma) times a weight. */
static void add_node(area_inner *self, double theta, double cos_v, double weight)
{
    double y[AIR_SH_MIRRORED_MAX];
    air_sh_meridian(self->factors, cos(theta), sin(theta), y);
    for (int i = 0; i < self->g_count; i++) {
        const double d = self->square[i] - self->twice[i] * cos_v;
        const double w = weight * self->minus[i] / (d * sqrt(d));
        double *const out = self->out + i * self->stride;
        for (int c = 0; c < self->coefficients; c++) {
            out[c] += w * y[c];
        }
    }
}

void impulse_area_inner(const impulse_quality *quality, const air_sh_factors *factors, double tau,
                        double gamma, const double *g, int g_count, double *out, int stride)
{
    const int coefficients = factors->order * (factors->order + 1) / 2;
    area_inner self = {.factors = factors,
                       .g = g,
                       .g_count = g_count,
                       .coefficients = coefficients,
                       .stride = stride,
                       .out = out};
    double sharpest = 0.0;
    for (int i = 0; i < g_count; i++) {
        self.minus[i] = (1.0 - g[i] * g[i]) / (4.0 * AIR_PI);
        self.square[i] = 1.0 + g[i] * g[i];
        self.twice[i] = 2.0 * g[i];
        sharpest = double_max(sharpest, fabs(g[i]));
        for (int c = 0; c < coefficients; c++) {
            out[i * stride + c] = 0.0;
        }
    }
    /* The exponent is tau 2 sin(gamma/2) sin(theta/2)/cos((gamma+theta)/2): of slope `slope` at 0,
     * growing without bound towards the end. */
    const double end = AIR_PI - gamma, rise = 2.0 * tau * sin(0.5 * gamma);
    const double peak = double_max(gamma, 1.0 - sharpest);
    const double last = ldexp(end, -quality->levels);
    double from = 0.0, width = double_min(double_min(0.7, peak), 3.0 / (tau * tan(0.5 * gamma)));
    while (end - from > last && rise * sin(0.5 * from) < quality->cut * sin(0.5 * (end - from))) {
        const double to = from + double_min(width, 0.5 * (end - from));
        for (int i = 0; i < quality->rule.nodes; i++) {
            const double theta = from + (to - from) * quality->rule.x[i];
            const double exponent = rise * sin(0.5 * theta) / sin(0.5 * (end - theta));
            add_node(&self, theta, cos(theta + gamma),
                     (to - from) * quality->rule.w[i] * exp(-exponent));
        }
        from = to;
        width = double_min(2.0 * width, 0.7);
    }
}

/* Between the angles at which the azimuth's clamp begins and ends, halved towards all of them. */
static void outer_nodes(const impulse_quality *quality, double theta_s, int peak, int back,
                        graded_list *out)
{
    double cuts[2];
    impulse_clamp_cuts(theta_s, cuts);
    const double ends[4] = {0.0, cuts[0], cuts[1], AIR_PI};
    for (int i = 0; i < 3; i++) {
        if (ends[i + 1] - ends[i] > 1e-12) {
            graded_both(out, &quality->rule, ends[i], ends[i + 1], i == 0 ? peak : 10,
                        i == 2 ? back : 10);
        }
    }
}

void air_impulse_area(double tau, double theta_s, double g, int order, double *out_sh)
{
    const impulse_quality quality = impulse_quality_fine();
    const int coefficients = order * (order + 1) / 2;
    air_sh_factors factors;
    graded_list gamma = {.count = 0};
    double inner[AIR_IMPULSE_SH_COUNT], moments[AIR_IMPULSE_ORDER];
    air_sh_factors_init(order, &factors);
    outer_nodes(&quality, theta_s, impulse_peak_levels(g, quality.levels), 10, &gamma);
    for (int c = 0; c < coefficients; c++) {
        out_sh[c] = 0.0;
    }
    for (int j = 0; j < gamma.count; j++) {
        const double angle = gamma.x[j];
        impulse_area_inner(&quality, &factors, tau, angle, &g, 1, inner, coefficients);
        impulse_clamped_moments(cos(theta_s) * cos(angle), sin(theta_s) * sin(angle), order,
                                moments);
        for (int l = 0; l < order; l++) {
            for (int m = 0; m <= l; m++) {
                const int c = l * (l + 1) / 2 + m;
                out_sh[c] += gamma.w[j] * moments[m] * inner[c] * exp(-tau) / tau;
            }
        }
    }
}
