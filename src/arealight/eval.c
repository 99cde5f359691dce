/* eval.c: S at many points: what they share, and the choice of a version. */
#include <math.h>
#include <string.h>

#include "arealight/eval.h"
#include "core/quadrature.h"

/* What the peak's half has of the whole of the phase function [KT2025, a_u]. */
static double near_share(double gamma)
{
    const double root = sqrt(1.0 + gamma * gamma);
    return (1.0 + gamma) / (root * (root + 1.0 - gamma));
}

/* False if g is not a number. */
static bool plan_phase(double g, air_area_plan *out)
{
    out->peak = g > 0.0 ? -1.0 : 1.0;
    out->gamma = fmin(fabs(g), 0.99);
    return g == g;
}

static void plan_rule(int nodes, air_area_plan *out)
{
    const int n = nodes < 2 ? 2 : nodes > 2 * AIR_AREA_EVAL_PAIRS ? 2 * AIR_AREA_EVAL_PAIRS : nodes;
    double x[2 * AIR_AREA_EVAL_PAIRS], w[2 * AIR_AREA_EVAL_PAIRS];
    air_gauss_legendre((size_t)n, x, w);
    out->pairs = (n + 1) / 2;
    for (int i = 0; i < out->pairs; i++) {
        const bool middle = 2 * i + 1 == n; /* a pair of itself */
        out->node[i] = middle ? 0.0 : -x[i];
        out->weight[i] = middle ? 0.5 * w[i] : w[i];
    }
}

static bool plan_edge(const air_area_lamp *lamp, double g, int nodes, air_area_plan *out)
{
    *out = (air_area_plan){.lamp = lamp};
    plan_rule(nodes, out);
    return plan_phase(g, out);
}

/* Where g = 0 edges are exact with any rule. */
static bool plan_lobes(const air_area_lamp *lamp, const air_area_lobe *lobe, air_area_plan *out)
{
    const double near = near_share(fmin(fabs(lobe->g), 0.99));
    *out = (air_area_plan){.lamp = lamp,
                           .lobes = lobe->g != 0.0,
                           .share = {near, 1.0 - near},
                           .s = {lobe->s_near, lobe->s_far},
                           .w = {lobe->w_near, lobe->w_far}};
    plan_rule(2, out);
    return plan_phase(lobe->g, out);
}

static air_area_version *version_of(air_cpu cpu)
{
#if defined(__x86_64__)
    switch (cpu) {
    case AIR_CPU_AVX512:
        return air_area_eval_avx512;
    case AIR_CPU_AVX2:
        return air_area_eval_avx2;
    case AIR_CPU_SSE42:
        return air_area_eval_sse42;
    default:
        return air_area_eval_c;
    }
#else
    (void)cpu;
    return air_area_eval_c;
#endif
}

static air_area_version_float *version_float_of(air_cpu cpu)
{
#if defined(__x86_64__)
    switch (cpu) {
    case AIR_CPU_AVX512:
        return air_area_eval_float_avx512;
    case AIR_CPU_AVX2:
        return air_area_eval_float_avx2;
    case AIR_CPU_SSE42:
        return air_area_eval_float_sse42;
    default:
        return air_area_eval_float_c;
    }
#else
    (void)cpu;
    return air_area_eval_float_c;
#endif
}

static void run(const air_context *context, bool planned, const air_area_plan *plan,
                const air_area_shading_points *points, size_t count, double *out_s)
{
    if (planned) {
        version_of(air_context_cpu(context))(plan, points, count, out_s);
    } else {
        memset(out_s, 0, count * sizeof *out_s);
    }
}

static void run_float(const air_context *context, bool planned, const air_area_plan *plan,
                      const air_area_shading_points_float *points, size_t count, float *out_s)
{
    if (planned) {
        version_float_of(air_context_cpu(context))(plan, points, count, out_s);
    } else {
        memset(out_s, 0, count * sizeof *out_s);
    }
}

void air_area_eval_edge(const air_context *context, const air_area_lamp *lamp, double g, int nodes,
                        const air_area_shading_points *points, size_t count, double *out_s)
{
    air_area_plan plan;
    const bool planned = plan_edge(lamp, g, nodes, &plan);
    run(context, planned, &plan, points, count, out_s);
}

void air_area_eval_edge_float(const air_context *context, const air_area_lamp *lamp, double g,
                              int nodes, const air_area_shading_points_float *points, size_t count,
                              float *out_s)
{
    air_area_plan plan;
    const bool planned = plan_edge(lamp, g, nodes, &plan);
    run_float(context, planned, &plan, points, count, out_s);
}

void air_area_eval_lobes(const air_context *context, const air_area_lamp *lamp,
                         const air_area_lobe *lobe, const air_area_shading_points *points,
                         size_t count, double *out_s)
{
    air_area_plan plan;
    const bool planned = plan_lobes(lamp, lobe, &plan);
    run(context, planned, &plan, points, count, out_s);
}

void air_area_eval_lobes_float(const air_context *context, const air_area_lamp *lamp,
                               const air_area_lobe *lobe,
                               const air_area_shading_points_float *points, size_t count,
                               float *out_s)
{
    air_area_plan plan;
    const bool planned = plan_lobes(lamp, lobe, &plan);
    run_float(context, planned, &plan, points, count, out_s);
}
