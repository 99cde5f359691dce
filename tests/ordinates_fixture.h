/* ordinates_fixture.h: media to carry light through, runs of any instruction set, and the public
 * reference data. */
#ifndef AIR_TESTS_ORDINATES_FIXTURE_H
#define AIR_TESTS_ORDINATES_FIXTURE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates.h"
#include "cmocka_test.h"
#include "random_geometry.h"

enum { ORDINATES_LEVELS = 4 };

static const char *const ordinates_level_names[ORDINATES_LEVELS] = {"C", "SSE4.2", "AVX2",
                                                                    "AVX-512"};

/* Of the instruction set AIR_CPU_C + level; NULL where the machine lacks it. */
static inline air_context *ordinates_context(int level)
{
    air_context_params params;
    air_context *context = NULL;
    air_context_params_default(&params);
    params.cpu = (air_cpu)(AIR_CPU_C + level);
    params.thread_count = 1;
    (void)air_context_create(&params, &context);
    return context;
}

typedef struct ordinates_medium {
    air_ordinates_cells cells;
    size_t count;
    float *sigma_s, *sigma_a, *g, *entry, *view_cosine;
} ordinates_medium;

static inline float *ordinates_floats(size_t count, float value)
{
    float *const out = malloc(count * sizeof *out);
    assert_non_null(out);
    for (size_t i = 0; i < count; i++) {
        out[i] = value;
    }
    return out;
}

/* Of constant coefficients, 1 m along k. */
static inline ordinates_medium ordinates_even(size_t x, size_t y, size_t z, float sigma_s,
                                              float sigma_a, float g)
{
    ordinates_medium out = {.count = x * y * z};
    out.sigma_s = ordinates_floats(out.count, sigma_s);
    out.sigma_a = ordinates_floats(out.count, sigma_a);
    out.g = ordinates_floats(out.count, g);
    out.entry = ordinates_floats(x * y, 1.0f);
    out.view_cosine = ordinates_floats(out.count, 0.0f);
    out.cells = (air_ordinates_cells){.size = {x, y, z},
                                      .cell_m = 1.0f / (float)z,
                                      .sigma_s = out.sigma_s,
                                      .sigma_a = out.sigma_a,
                                      .g = out.g,
                                      .entry = out.entry};
    return out;
}

/* Random in all of it; a quarter of the cells is clear, a quarter of the entry dark. */
static inline ordinates_medium ordinates_random(size_t x, size_t y, size_t z, uint32_t seed)
{
    ordinates_medium out = ordinates_even(x, y, z, 0.0f, 0.0f, 0.0f);
    air_rng rng = air_rng_from_keys(seed, 77);
    out.cells.cell_m = 0.25f;
    for (size_t i = 0; i < out.count; i++) {
        const bool clear = air_rng_float(&rng) < 0.25f;
        out.sigma_s[i] = clear ? 0.0f : 4.0f * air_rng_float(&rng);
        out.sigma_a[i] = clear ? 0.0f : 0.5f * air_rng_float(&rng);
        out.g[i] = 1.7f * air_rng_float(&rng) - 0.8f;
        out.view_cosine[i] = 2.0f * air_rng_float(&rng) - 1.0f;
    }
    for (size_t i = 0; i < x * y; i++) {
        out.entry[i] = air_rng_float(&rng) < 0.25f ? 0.0f : 2.0f * air_rng_float(&rng);
    }
    return out;
}

static inline void ordinates_medium_free(ordinates_medium *self)
{
    free(self->sigma_s);
    free(self->sigma_a);
    free(self->g);
    free(self->entry);
    free(self->view_cosine);
}

/* All results of a run. */
typedef struct ordinates_outcome {
    float *fluence, *beam, *seen, *binned, *energy, *asymmetry;
    air_ordinates_books books;
} ordinates_outcome;

/* bins 0: none. */
static inline ordinates_outcome ordinates_run_all(air_context *context,
                                                  const ordinates_medium *medium,
                                                  const air_ordinates_params *params, size_t bins)
{
    const size_t bytes = air_ordinates_scratch(&medium->cells, params);
    void *const scratch = aligned_alloc(64, (bytes + 63) / 64 * 64);
    ordinates_outcome out = {.fluence = ordinates_floats(medium->count, NAN),
                             .beam = ordinates_floats(medium->count, NAN),
                             .seen = ordinates_floats(medium->count, NAN),
                             .binned = ordinates_floats(medium->count * bins + 1, NAN),
                             .energy = ordinates_floats(medium->count, NAN),
                             .asymmetry = ordinates_floats(medium->count, NAN)};
    const air_ordinates_results results = {.fluence = out.fluence,
                                           .beam = out.beam,
                                           .view_cosine = medium->view_cosine,
                                           .seen = out.seen,
                                           .bins = bins,
                                           .binned = bins > 0 ? out.binned : NULL,
                                           .energy = out.energy,
                                           .asymmetry = out.asymmetry,
                                           .books = &out.books};
    assert_true(bytes > 0 && scratch != NULL);
    memset(scratch, 0xff, bytes); /* NaN, if it is read before it is written */
    assert_int_equal(air_ordinates_run(context, &medium->cells, params, scratch, &results), AIR_OK);
    free(scratch);
    return out;
}

static inline void ordinates_outcome_free(ordinates_outcome *self)
{
    free(self->fluence);
    free(self->beam);
    free(self->seen);
    free(self->binned);
    free(self->energy);
    free(self->asymmetry);
}

/* What the books lack, as a share of what came in. */
static inline double ordinates_imbalance(const air_ordinates_books *books)
{
    double sum = books->absorbed + books->residual;
    for (int i = 0; i < 6; i++) {
        sum += books->out[i];
    }
    return fabs(sum - books->in) / books->in;
}

static inline air_ordinates_params ordinates_params(air_ordinates_stencil stencil,
                                                    air_ordinates_decay decay,
                                                    air_ordinates_start start, uint32_t steps)
{
    air_ordinates_params out;
    air_ordinates_params_default(&out);
    out.stencil = stencil;
    out.decay = decay;
    out.start = start;
    out.steps = steps;
    out.residual = 0.0;
    return out;
}

enum { CUBE_SIDE = 16, CUBE_CELLS = CUBE_SIDE * CUBE_SIDE * CUBE_SIDE, CUBE_BINS = 20 };

/* The public cube: unit edge, sigma_s = 4, no absorption, g = 0.7. */
static inline ordinates_medium ordinates_cube(size_t side)
{
    return ordinates_even(side, side, side, 4.0f, 0.0f, 0.7f);
}

/* The first count numbers of a file of the public data; false, with a reason printed, where it is
 * absent. */
static inline bool ordinates_reference(const char *name, size_t count, float *out)
{
    char path[512];
    (void)snprintf(path, sizeof path, "%s/spec/data/ordinates/%s", AIR_SHARED_DIR, name);
    FILE *const file = fopen(path, "rb");
    if (file == NULL) {
        print_message("skipped: no %s\n", path);
        return false;
    }
    const size_t got = fread(out, sizeof *out, count, file);
    (void)fclose(file);
    assert_int_equal(got, count);
    return true;
}

#endif
