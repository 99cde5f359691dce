/* run.c: arguments of a run checked, and its steps given to who takes them. */
#include "ordinates/run.h"

#include <float.h>
#include <math.h>
#include <stdint.h>

#include "core/exponential.h"
#include "core/host.h"

void air_ordinates_params_default(air_ordinates_params *params)
{
    *params = (air_ordinates_params){.stencil = AIR_ORDINATES_CM,
                                     .decay = AIR_ORDINATES_DECAY_POISSON,
                                     .start = AIR_ORDINATES_FIRST_SCATTER,
                                     .steps = 32,
                                     .residual = 1e-3,
                                     .lobe = 1.0f};
}

/* ---- arguments ---- */

static const char *params_fault(const air_ordinates_params *params)
{
    if ((unsigned)params->stencil > AIR_ORDINATES_SIX ||
        (unsigned)params->decay > AIR_ORDINATES_DECAY_PAPER ||
        (unsigned)params->start > AIR_ORDINATES_ALL_CELLS) {
        return "a known stencil, decay and start";
    }
    if (params->steps < 1 || params->steps > AIR_ORDINATES_STEPS_MAX) {
        return "1 to 4096 steps";
    }
    if (!(params->residual >= 0.0)) {
        return "a residual >= 0";
    }
    if (!(params->lobe >= 0.0f && params->lobe <= 1.0f)) {
        return "a lobe in [0, 1]";
    }
    return NULL;
}

static const char *size_fault(const air_ordinates_cells *cells)
{
    for (int i = 0; i < 3; i++) {
        if (cells->size[i] < 1 || cells->size[i] > AIR_ORDINATES_SIZE_MAX) {
            return "1 to 512 cells along each axis";
        }
    }
    return NULL;
}

/* How a run is checked and done by an instruction set. */
typedef struct run_set {
    ordinates_greatest *greatest;
    ordinates_steps *steps;
} run_set;

static bool all_positive(const run_set *set, const float *x, size_t count)
{
    return x != NULL && set->greatest(x, count, true) <= air_float_bits(FLT_MAX);
}

static bool all_within(const run_set *set, const float *x, size_t count, float most)
{
    return x != NULL && set->greatest(x, count, false) <= air_float_bits(most);
}

static const char *cells_fault(const run_set *set, const air_ordinates_cells *cells)
{
    const size_t slice = cells->size[0] * cells->size[1], count = slice * cells->size[2];
    if (!(cells->cell_m > 0.0f && cells->cell_m <= FLT_MAX)) {
        return "cells of a positive edge";
    }
    if (!all_positive(set, cells->sigma_s, count)) {
        return "finite sigma_s >= 0";
    }
    if (!all_positive(set, cells->sigma_a, count)) {
        return "finite sigma_a >= 0";
    }
    if (!all_within(set, cells->g, count, 1.0f - 0x1p-24f)) {
        return "g in (-1, 1)";
    }
    if (cells->entry != NULL && !all_positive(set, cells->entry, slice)) {
        return "finite entry factors >= 0";
    }
    return NULL;
}

/* Cosines come from rounded vectors. */
static const char *results_fault(const run_set *set, const air_ordinates_results *results,
                                 size_t count)
{
    if (results->seen != NULL && !all_within(set, results->view_cosine, count, 1.000001f)) {
        return "cosines to the observer in [-1, 1]";
    }
    if (results->binned != NULL && results->bins < 1) {
        return "a bin at least";
    }
    return NULL;
}

/* ---- scratch ---- */

size_t air_ordinates_scratch(const air_ordinates_cells *cells, const air_ordinates_params *params)
{
    if (size_fault(cells) != NULL || params_fault(params) != NULL) {
        return 0;
    }
    const size_t plain = ordinates_scratch_plain(cells, params);
    const size_t lanes = ordinates_scratch_lanes(cells, params);
    return plain > lanes ? plain : lanes;
}

/* ---- runs ---- */

static run_set set_of(const air_context *context)
{
#if defined(__x86_64__)
    const air_cpu cpu = context != NULL ? air_context_cpu(context) : AIR_CPU_C;
    if (cpu == AIR_CPU_AVX512) {
        return (run_set){ordinates_greatest_avx512, ordinates_steps_avx512};
    }
    if (cpu == AIR_CPU_AVX2) {
        return (run_set){ordinates_greatest_avx2, ordinates_steps_avx2};
    }
    if (cpu == AIR_CPU_SSE42) {
        return (run_set){ordinates_greatest_sse42, ordinates_steps_sse42};
    }
#endif
    (void)context;
    return (run_set){ordinates_greatest_plain, ordinates_steps_plain};
}

air_status air_ordinates_run(air_context *context, const air_ordinates_cells *cells,
                             const air_ordinates_params *params, void *scratch,
                             const air_ordinates_results *results)
{
    const run_set set = set_of(context);
    const char *fault = params_fault(params);
    fault = fault != NULL ? fault : size_fault(cells);
    fault = fault != NULL ? fault : cells_fault(&set, cells);
    if (fault == NULL) {
        fault = results_fault(&set, results, cells->size[0] * cells->size[1] * cells->size[2]);
    }
    if (fault == NULL && (scratch == NULL || (uintptr_t)scratch % 64 != 0)) {
        fault = "scratch aligned to 64 bytes";
    }
    if (fault != NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "ordinates: expected %s", fault);
    }
    const ordinates_run run = {
        .cells = cells, .params = params, .results = results, .scratch = scratch};
    /* six lobes and bins have the plain version alone */
    const bool plain = params->stencil == AIR_ORDINATES_SIX || results->binned != NULL;
    (plain ? ordinates_steps_plain : set.steps)(&run);
    return AIR_OK;
}
