/* eval.c: S at many points: what they share, and the choice of a version. */
#include <math.h>
#include <string.h>

#include "arealight/eval.h"

/* False if g is not a number. */
static bool plan_phase(double g, air_area_plan *out)
{
    out->peak = g > 0.0 ? -1.0 : 1.0;
    out->gamma = fmin(fabs(g), 0.99);
    return g == g;
}

static bool plan_edge(const air_area_lamp *lamp, double g, int nodes, air_area_plan *out)
{
    *out = (air_area_plan){.lamp = lamp};
    air_edge_rule_make(nodes, &out->rule);
    return plan_phase(g, out);
}

/* Where g = 0 edges are exact with any rule. */
static bool plan_lobes(const air_area_lamp *lamp, const air_area_lobe *lobe, air_area_plan *out)
{
    *out = (air_area_plan){.lamp = lamp, .lobes = lobe->g != 0.0};
    const bool planned = plan_phase(lobe->g, out);
    out->halves = air_lobe_halves_make(lobe, out->gamma);
    air_edge_rule_make(2, &out->rule);
    return planned;
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
