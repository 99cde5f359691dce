/* ordinates_box.h: boxes of fog of random density, absorption, phase function and light, for tests
 * of discrete ordinates. */
#ifndef AIR_TESTS_ORDINATES_BOX_H
#define AIR_TESTS_ORDINATES_BOX_H

#include <math.h>
#include <stdlib.h>

#include "airlight/ordinates_dom.h"
#include "cmocka_test.h"
#include "core/harmonics.h"
#include "random_geometry.h"

typedef struct box {
    air_dom_params params;
    size_t cells, moments; /* moments per cell */
    float *sigma_s, *sigma_a, *g, *light;
    float inflow[AIR_DOM_BANDS_MAX * AIR_DOM_BANDS_MAX * AIR_DOM_STRIDE];
    uint32_t faces;
} box;

static inline air_context *box_context(air_cpu cpu, size_t threads)
{
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.cpu = cpu;
    params.thread_count = threads;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

static inline float *box_numbers(size_t count)
{
    float *const numbers = calloc(count, sizeof *numbers);
    assert_non_null(numbers);
    return numbers;
}

/* Moments of a beam along `dir`, stride 4; adds them. */
static inline void box_add_beam(int bands, const double dir[3], double radiance, float *moments)
{
    double y[AIR_SH_COUNT_MAX];
    air_sh_evaluate(bands, dir, y);
    for (int i = 0; i < bands * bands; i++) {
        for (int c = 0; c < 3; c++) {
            moments[i * AIR_DOM_STRIDE + c] += (float)(radiance * (1.0 + 0.3 * c) * y[i]);
        }
    }
}

/* Nothing in it: no fog, no light. */
static inline box box_empty(const air_dom_params *params)
{
    box self = {.params = *params};
    self.cells = params->size[0] * params->size[1] * params->size[2];
    self.moments = (size_t)(params->bands * params->bands);
    self.sigma_s = box_numbers(3 * self.cells);
    self.sigma_a = box_numbers(3 * self.cells);
    self.g = box_numbers(3 * self.cells);
    self.light = box_numbers(self.cells * self.moments * AIR_DOM_STRIDE);
    return self;
}

static inline void box_finish(box *self)
{
    free(self->sigma_s);
    free(self->sigma_a);
    free(self->g);
    free(self->light);
}

static inline void box_random_dir(air_rng *rng, double dir[3])
{
    for (int axis = 0; axis < 3; axis++) {
        dir[axis] = random_between(rng, -1.0, 1.0) + 1e-3;
    }
    normalise(dir);
}

/* 5 x 7 x 3 cells that are no cubes, a fifth of them void; every cell and channel has its own
 * phase function, from backward to forward; unscattered light along random directions, and inflow
 * through four faces. */
static inline box box_random(int bands, int polar, int azimuths, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, 17);
    air_dom_params params;
    double dir[3];
    air_dom_params_default(&params);
    params.size[0] = 5;
    params.size[1] = 7;
    params.size[2] = 3;
    params.cell_m[0] = 0.2f;
    params.cell_m[1] = 0.1f;
    params.cell_m[2] = 0.4f;
    params.bands = bands;
    params.polar = polar;
    params.azimuths = azimuths;
    box self = box_empty(&params);
    for (size_t i = 0; i < 3 * self.cells; i++) {
        const bool fog = random_unit(&rng) > 0.2;
        self.sigma_s[i] = fog ? (float)random_between(&rng, 0.0, 8.0) : 0.0f;
        self.sigma_a[i] = fog ? (float)random_between(&rng, 0.0, 2.0) : 0.0f;
        self.g[i] = (float)random_between(&rng, -0.9, 0.9);
    }
    for (size_t cell = 0; cell < self.cells; cell++) {
        box_random_dir(&rng, dir);
        box_add_beam(bands, dir, random_unit(&rng),
                     self.light + cell * self.moments * AIR_DOM_STRIDE);
    }
    box_random_dir(&rng, dir);
    box_add_beam(bands, dir, 0.3, self.inflow);
    self.faces = 1u << 0 | 1u << 2 | 1u << 3 | 1u << 5;
    return self;
}

/* A solver with all that is in the box. */
static inline air_dom *box_make(air_context *context, const box *self)
{
    const air_dom_phase phase = {.g = self->g};
    air_dom *dom;
    assert_int_equal(air_dom_create(context, &self->params, &dom), AIR_OK);
    assert_int_equal(air_dom_set_medium(dom, self->sigma_s, self->sigma_a, &phase), AIR_OK);
    assert_int_equal(air_dom_set_light(dom, self->light), AIR_OK);
    assert_int_equal(air_dom_set_inflow(dom, self->inflow, self->faces), AIR_OK);
    return dom;
}

static inline air_dom_solve_params box_solve_params(uint32_t sweeps, double change, int depth)
{
    air_dom_solve_params params;
    air_dom_solve_params_default(&params);
    params.sweeps = sweeps;
    params.change = change;
    params.depth = depth;
    return params;
}

static inline air_dom_report box_solve(air_dom *dom, uint32_t sweeps, double change, int depth)
{
    const air_dom_solve_params params = box_solve_params(sweeps, change, depth);
    air_dom_report report;
    assert_int_equal(air_dom_solve(dom, &params, &report), AIR_OK);
    return report;
}

/* The moments, to be freed. */
static inline float *box_moments(const air_dom *dom, const box *self)
{
    float *const out = box_numbers(self->cells * self->moments * AIR_DOM_STRIDE);
    air_dom_moments(dom, out);
    return out;
}

/* The largest difference of two fields' numbers, as a share of the first's largest. */
static inline double box_difference(const float *a, const float *b, size_t count)
{
    double most = 0.0, size = 0.0;
    for (size_t i = 0; i < count; i++) {
        most = fmax(most, fabs((double)a[i] - (double)b[i]));
        size = fmax(size, fabs((double)a[i]));
    }
    return size > 0.0 ? most / size : most;
}

/* What goes in less what is accounted for, as a share. */
static inline double box_imbalance(const air_dom_books *books)
{
    double rest = books->in - books->absorbed - books->residual;
    for (int side = 0; side < 6; side++) {
        rest -= books->out[side];
    }
    return books->in > 0.0 ? fabs(rest) / books->in : fabs(rest);
}

#endif
