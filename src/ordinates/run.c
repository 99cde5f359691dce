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

/* By their bits, which are ordered as positive floats are, NaN last, in a loop that takes lanes: a
 * tenth of the time of a step otherwise. Adding 0 makes 0 of -0. */
static bool all_finite_positive(const float *x, size_t count)
{
    uint32_t greatest = 0;
    for (size_t i = 0; i < count; i++) {
        const uint32_t bits = air_float_bits(x[i] + 0.0f);
        greatest = bits > greatest ? bits : greatest;
    }
    return greatest <= air_float_bits(FLT_MAX);
}

static bool all_within(const float *x, size_t count, float most)
{
    uint32_t greatest = 0;
    for (size_t i = 0; i < count; i++) {
        const uint32_t bits = air_float_bits(x[i]) & 0x7fffffffu;
        greatest = bits > greatest ? bits : greatest;
    }
    return greatest <= air_float_bits(most);
}

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

static const char *cells_fault(const air_ordinates_cells *cells)
{
    const size_t slice = cells->size[0] * cells->size[1], count = slice * cells->size[2];
    if (!(cells->cell_m > 0.0f && cells->cell_m <= FLT_MAX)) {
        return "cells of a positive edge";
    }
    if (cells->sigma_s == NULL || !all_finite_positive(cells->sigma_s, count)) {
        return "finite sigma_s >= 0";
    }
    if (cells->sigma_a == NULL || !all_finite_positive(cells->sigma_a, count)) {
        return "finite sigma_a >= 0";
    }
    if (cells->g == NULL || !all_within(cells->g, count, 1.0f - 0x1p-24f)) {
        return "g in (-1, 1)";
    }
    if (cells->entry != NULL && !all_finite_positive(cells->entry, slice)) {
        return "finite entry factors >= 0";
    }
    return NULL;
}

/* Cosines come from rounded vectors. */
static const char *results_fault(const air_ordinates_results *results, size_t count)
{
    if (results->seen != NULL &&
        (results->view_cosine == NULL || !all_within(results->view_cosine, count, 1.000001f))) {
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

/* Six lobes and bins have the plain version alone. */
static bool takes_lanes(const ordinates_run *run)
{
    return run->params->stencil != AIR_ORDINATES_SIX && run->results->binned == NULL;
}

static ordinates_steps *steps_of(const air_context *context, const ordinates_run *run)
{
#if defined(__x86_64__)
    const air_cpu cpu = context != NULL ? air_context_cpu(context) : AIR_CPU_C;
    if (takes_lanes(run) && cpu == AIR_CPU_AVX512) {
        return ordinates_steps_avx512;
    }
    if (takes_lanes(run) && cpu == AIR_CPU_AVX2) {
        return ordinates_steps_avx2;
    }
    if (takes_lanes(run) && cpu == AIR_CPU_SSE42) {
        return ordinates_steps_sse42;
    }
#endif
    (void)context;
    (void)run;
    return ordinates_steps_plain;
}

air_status air_ordinates_run(air_context *context, const air_ordinates_cells *cells,
                             const air_ordinates_params *params, void *scratch,
                             const air_ordinates_results *results)
{
    const char *fault = params_fault(params);
    fault = fault != NULL ? fault : size_fault(cells);
    fault = fault != NULL ? fault : cells_fault(cells);
    if (fault == NULL) {
        fault = results_fault(results, cells->size[0] * cells->size[1] * cells->size[2]);
    }
    if (fault == NULL && (scratch == NULL || (uintptr_t)scratch % 64 != 0)) {
        fault = "scratch aligned to 64 bytes";
    }
    if (fault != NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "ordinates: expected %s", fault);
    }
    const ordinates_run run = {
        .cells = cells, .params = params, .results = results, .scratch = scratch};
    steps_of(context, &run)(&run);
    return AIR_OK;
}
