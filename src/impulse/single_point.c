/* single_point.c: one event, point light: (P2) and, along a ray, (P1). */
#include <math.h>

#include "core/vec.h"
#include "impulse/single.h"

impulse_quality impulse_quality_fine(void)
{
    return (impulse_quality){.rule = graded_rule_make(12), .levels = 20, .cut = 40.0};
}

impulse_quality impulse_quality_table(void)
{
    return (impulse_quality){.rule = graded_rule_make(8), .levels = 14, .cut = 25.0};
}

double impulse_phase(double g, double cosine)
{
    const double d = 1.0 + g * g - 2.0 * g * cosine;
    return (1.0 - g * g) / (4.0 * AIR_PI * d * sqrt(d));
}

int impulse_peak_levels(double g, int least)
{
    const int levels = (int)ceil(log2(AIR_PI / (1.0 - fabs(g)))) + 1;
    return levels > least ? levels : least;
}

/* The integral over theta in (P2), times exp(tau). With s = tau tan(v/2) the exponent grows from 0
 * to tau (1/cos(v/2) - 1) in the middle, about which the triangle of the two ends is symmetric. */
static void point_inner(const impulse_quality *q, const air_sh_factors *factors, double tau,
                        double v, double *out)
{
    const int order = factors->order;
    const double end = 0.5 * v, slope = tau * tan(0.5 * v);
    double from = 0.0, width = double_min(0.7, 3.0 / slope);
    for (int l = 0; l < order; l++) {
        out[l] = 0.0;
    }
    while (from < end && tau * (cos(from) - 1.0) + slope * sin(from) < q->cut) {
        const double to = double_min(end, from + width);
        for (int i = 0; i < q->rule.nodes; i++) {
            const double theta = from + (to - from) * q->rule.x[i];
            const double c = cos(theta), s = sin(theta), turned = cos(v - theta);
            const double weight = (to - from) * q->rule.w[i] * exp(tau * (1.0 - c) - slope * s);
            double a = factors->zonal[0], b = a, a_before = 0.0, b_before = 0.0;
            for (int l = 0; l < order; l++) {
                out[l] += weight * (a + b);
                if (l + 1 < order) {
                    const int next = (l + 1) * (l + 2) / 2;
                    const double a_next = factors->a[next] * c * a - factors->b[next] * a_before;
                    const double b_next =
                        factors->a[next] * turned * b - factors->b[next] * b_before;
                    a_before = a;
                    b_before = b;
                    a = a_next;
                    b = b_next;
                }
            }
        }
        from = to;
        width = double_min(2.0 * width, 0.7);
    }
}

static int most_levels(const double *g, int g_count, double sign, int least)
{
    int levels = least;
    for (int i = 0; i < g_count; i++) {
        levels = sign * g[i] > 0.0 ? impulse_peak_levels(g[i], levels) : levels;
    }
    return levels;
}

void impulse_point_scaled(const impulse_quality *quality, double tau, const double *g, int g_count,
                          int order, double *out, int stride)
{
    graded_list v = {.count = 0};
    air_sh_factors factors;
    double inner[AIR_IMPULSE_ORDER];
    air_sh_factors_init(order, &factors);
    graded_both(&v, &quality->rule, 0.0, AIR_PI, most_levels(g, g_count, 1.0, 4),
                most_levels(g, g_count, -1.0, quality->levels));
    for (int i = 0; i < g_count; i++) {
        for (int l = 0; l < order; l++) {
            out[i * stride + l] = 0.0;
        }
    }
    for (int j = 0; j < v.count; j++) {
        point_inner(quality, &factors, tau, v.x[j], inner);
        const double cosine = cos(v.x[j]);
        for (int i = 0; i < g_count; i++) {
            const double weight = 2.0 * AIR_PI * v.w[j] * impulse_phase(g[i], cosine);
            for (int l = 0; l < order; l++) {
                out[i * stride + l] += weight * inner[l];
            }
        }
    }
}

void air_impulse_point(double tau, double g, int order, double *out_zh)
{
    const impulse_quality quality = impulse_quality_fine();
    impulse_point_scaled(&quality, tau, &g, 1, order, out_zh, order);
    for (int l = 0; l < order; l++) {
        out_zh[l] *= exp(-tau) / tau;
    }
}

/* ---- along a ray ---- */

/* The scattering angle at distance t of the ray is theta plus this. */
static double angle_at_light(double d, double cosine, double sine, double t)
{
    return isinf(t) ? atan2(sine, -cosine) : atan2(t * sine, d - t * cosine);
}

double air_impulse_point_ray(double sigma_s, double sigma_t, double g, double d, double cosine,
                             double t0, double t1)
{
    const double least = 1e-9; /* rays nearer to the line through the light are moved off it */
    double sine = sqrt(double_max(0.0, 1.0 - cosine * cosine));
    if (sine < least) {
        if (cosine > 0.0 && t0 <= d && t1 >= d) {
            return INFINITY;
        }
        sine = least;
    }
    const graded_rule rule = graded_rule_make(10);
    graded_list angles = {.count = 0};
    const double theta = atan2(sine, cosine), tau = sigma_t * d, last = AIR_PI - theta;
    const double from = angle_at_light(d, cosine, sine, t0);
    const double to = double_min(last, angle_at_light(d, cosine, sine, t1));
    const int levels = isinf(t1) ? 20 : 8;
    double sum = 0.0;
    graded_both(&angles, &rule, from, to, impulse_peak_levels(g, 6),
                impulse_peak_levels(g, levels));
    for (int i = 0; i < angles.count; i++) {
        /* (t + r)/d = (sin a + sin theta)/sin(a + theta) */
        const double v = theta + angles.x[i];
        const double path = cosine + sine * tan(0.5 * v);
        sum += angles.w[i] * impulse_phase(g, cos(v)) * exp(-tau * path);
    }
    return sigma_s * sum / (d * sine);
}
