/* ordinates_cube.h: a unit cube of fog under a beam, solved by discrete ordinates and held against
 * photons that were counted (4e7 of them).
 *
 * 16^3 cells, sigma_s 4 per metre, no absorption, Henyey and Greenstein's g 0.7, irradiance 1 on
 * the face z = 0 along +z. */
#ifndef AIR_TESTS_ORDINATES_CUBE_H
#define AIR_TESTS_ORDINATES_CUBE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_dom.h"
#include "cmocka_test.h"
#include "core/harmonics.h"
#include "core/quadrature.h"
#include "core/vec.h"

enum { CUBE_N = 16, CUBE_CELLS = CUBE_N * CUBE_N * CUBE_N, CUBE_BINS = 20 };

static const double cube_sigma_s = 4.0, cube_g = 0.7;

typedef struct cube_truth {
    /* planes: fluence, its standard error, unscattered fluence, flux along x, y, z */
    float fluence[6][CUBE_CELLS];
    /* mean and standard error of scattered fluence by [k][i][cosine to z], mean of j = 7 and 8 */
    float angular[2][CUBE_N][CUBE_N][CUBE_BINS];
    double exits[6]; /* -x .. +z, with what is not scattered */
} cube_truth;

static inline bool cube_read_floats(const char *name, void *out, size_t count)
{
    char path[512];
    (void)snprintf(path, sizeof path, "%s/spec/data/ordinates/cube_g07_%s.f32", AIR_SHARED_DIR,
                   name);
    FILE *const file = fopen(path, "rb");
    if (file == NULL) {
        return false;
    }
    const size_t read = fread(out, sizeof(float), count, file);
    (void)fclose(file);
    assert_int_equal(read, count);
    return true;
}

/* False, and says so, where the data are absent. */
static inline bool cube_read(cube_truth *out)
{
    char line[128];
    const bool there =
        cube_read_floats("fluence", out->fluence, sizeof out->fluence / sizeof(float)) &&
        cube_read_floats("angular", out->angular, sizeof out->angular / sizeof(float));
    FILE *const file =
        there ? fopen(AIR_SHARED_DIR "/spec/data/ordinates/cube_g07_exit.csv", "r") : NULL;
    if (file == NULL) {
        print_message("skipped: no data of the public cube in %s\n", AIR_SHARED_DIR);
        return false;
    }
    assert_non_null(fgets(line, sizeof line, file)); /* the head */
    for (int side = 0; side < 6; side++) {
        assert_non_null(fgets(line, sizeof line, file));
        const char *const comma = strchr(line, ',');
        assert_non_null(comma);
        out->exits[side] = strtod(comma + 1, NULL);
    }
    (void)fclose(file);
    return true;
}

/* A cube of edge 1 of n^3 cells. */
static inline air_dom_params cube_params(size_t n, int bands, int polar, int azimuths)
{
    air_dom_params params;
    air_dom_params_default(&params);
    for (int axis = 0; axis < 3; axis++) {
        params.size[axis] = n;
        params.cell_m[axis] = 1.0f / (float)n;
    }
    params.bands = bands;
    params.polar = polar;
    params.azimuths = azimuths;
    return params;
}

static inline size_t cube_cells(const air_dom_params *params)
{
    return params->size[0] * params->size[1] * params->size[2];
}

/* What attenuates the unscattered light. */
static inline double cube_extinction(const air_dom_params *params, double sigma_s)
{
    return sigma_s * (1.0 - air_dom_peak(params, pow(cube_g, params->bands)));
}

/* Mean fluence of the unscattered light in slab k. */
static inline double cube_beam(const air_dom_params *params, double sigma_s, size_t k)
{
    const double depth = cube_extinction(params, sigma_s) * (double)params->cell_m[2];
    return exp(-depth * (double)k) * -expm1(-depth) / depth;
}

/* To be freed. */
static inline float *cube_light(const air_dom_params *params, double sigma_s)
{
    const size_t moments = (size_t)(params->bands * params->bands), cells = cube_cells(params);
    const double along_z[3] = {0.0, 0.0, 1.0};
    float *const light = calloc(cells * moments * AIR_DOM_STRIDE, sizeof *light);
    double y[AIR_SH_COUNT_MAX];
    assert_non_null(light);
    air_sh_evaluate(params->bands, along_z, y);
    for (size_t i = 0; i < cells * moments * AIR_DOM_STRIDE; i++) {
        const size_t cell = i / AIR_DOM_STRIDE / moments;
        const double beam = cube_beam(params, sigma_s, cell / (params->size[0] * params->size[1]));
        light[i] = i % AIR_DOM_STRIDE < 3 ? (float)(beam * y[i / AIR_DOM_STRIDE % moments]) : 0.0f;
    }
    return light;
}

static inline void cube_set_medium(air_dom *dom, const air_dom_params *params, double sigma_s)
{
    const size_t count = 3 * cube_cells(params);
    float *const numbers = calloc(3 * count, sizeof *numbers);
    assert_non_null(numbers);
    for (size_t i = 0; i < count; i++) {
        numbers[i] = (float)sigma_s;
        numbers[2 * count + i] = (float)cube_g;
    }
    const air_dom_phase phase = {.g = numbers + 2 * count};
    assert_int_equal(air_dom_set_medium(dom, numbers, numbers + count, &phase), AIR_OK);
    free(numbers);
}

/* The cube and its light, not solved yet. */
static inline air_dom *cube_make(air_context *context, const air_dom_params *params)
{
    air_dom *dom;
    float *const light = cube_light(params, cube_sigma_s);
    assert_int_equal(air_dom_create(context, params, &dom), AIR_OK);
    cube_set_medium(dom, params, cube_sigma_s);
    assert_int_equal(air_dom_set_light(dom, light), AIR_OK);
    free(light);
    return dom;
}

/* To be freed. */
static inline float *cube_moments(const air_dom *dom, const air_dom_params *params)
{
    const size_t moments = (size_t)(params->bands * params->bands);
    float *const out = calloc(cube_cells(params) * moments * AIR_DOM_STRIDE, sizeof *out);
    assert_non_null(out);
    air_dom_moments(dom, out);
    return out;
}

typedef struct cube_score {
    double fluence;  /* root of the mean square of its error, over the mean */
    double flux;     /* of that along z, likewise and over the mean fluence */
    double angles;   /* total variation of the shares of 20 bins, mean over a slice's cells */
    double radiance; /* as fluence, of the bins */
    double exits;    /* largest error of a face, as a share of what leaves through it */
} cube_score;

/* Integrals of y_l0 times 2 pi over the bins. */
static inline void cube_bins(int bands, double out[CUBE_BINS][AIR_SH_ORDER_MAX])
{
    double nodes[6], weights[6], y[AIR_SH_ORDER_MAX];
    air_gauss_legendre(6, nodes, weights);
    for (int bin = 0; bin < CUBE_BINS; bin++) {
        memset(out[bin], 0, sizeof out[bin]);
        for (int i = 0; i < 6; i++) {
            air_zh_evaluate(bands, -1.0 + (2.0 * bin + 1.0 + nodes[i]) / CUBE_BINS, y);
            for (int l = 0; l < bands; l++) {
                out[bin][l] += 2.0 * AIR_PI * weights[i] / CUBE_BINS * y[l];
            }
        }
    }
}

/* 16^3 cells. moments: of scattered light. */
static inline void cube_score_angles(const cube_truth *truth, const air_dom_params *params,
                                     const float *moments, double beam_share, cube_score *out)
{
    const size_t stride = (size_t)(params->bands * params->bands) * AIR_DOM_STRIDE;
    double bins[CUBE_BINS][AIR_SH_ORDER_MAX], squares = 0.0, mean = 0.0, variation = 0.0;
    cube_bins(params->bands, bins);
    for (size_t place = 0; place < (size_t)CUBE_N * CUBE_N; place++) {
        const size_t k = place / CUBE_N, i = place % CUBE_N;
        const float *const at = moments + ((k * CUBE_N + 7) * CUBE_N + i) * stride;
        double found[CUBE_BINS], expected[CUBE_BINS], sums[2] = {0.0};
        for (int bin = 0; bin < CUBE_BINS; bin++) {
            const bool last = bin == CUBE_BINS - 1;
            found[bin] = last ? beam_share * cube_beam(params, cube_sigma_s, k) : 0.0;
            expected[bin] = (double)truth->angular[0][k][i][bin];
            expected[bin] += last ? (double)truth->fluence[2][(k * CUBE_N + 7) * CUBE_N + i] : 0.0;
            for (int l = 0; l < params->bands; l++) {
                const size_t m = (size_t)(l * l + l) * AIR_DOM_STRIDE;
                found[bin] +=
                    0.5 * bins[bin][l] * ((double)at[m] + (double)at[CUBE_N * stride + m]);
            }
            sums[0] += found[bin];
            sums[1] += expected[bin];
            squares += (found[bin] - expected[bin]) * (found[bin] - expected[bin]);
            mean += expected[bin];
        }
        for (int bin = 0; bin < CUBE_BINS; bin++) {
            variation += 0.5 * fabs(found[bin] / sums[0] - expected[bin] / sums[1]);
        }
    }
    const double count = (double)CUBE_N * CUBE_N;
    out->angles = variation / count;
    out->radiance = sqrt(squares / (count * CUBE_BINS)) / (mean / (count * CUBE_BINS));
}

/* 16^3 cells. beam_share: 1 where the beam is unscattered light, 0 where it comes in as inflow. */
static inline cube_score cube_score_of(const cube_truth *truth, const air_dom_params *params,
                                       const air_dom *dom, const air_dom_report *report,
                                       double beam_share)
{
    cube_score score = {0};
    double mean = 0.0;
    float *const moments = cube_moments(dom, params);
    const size_t stride = (size_t)(params->bands * params->bands) * AIR_DOM_STRIDE;
    for (size_t cell = 0; cell < CUBE_CELLS; cell++) {
        const double beam = beam_share * cube_beam(params, cube_sigma_s, cell / (CUBE_N * CUBE_N));
        const double fluence = sqrt(4.0 * AIR_PI) * (double)moments[cell * stride] + beam;
        const double error = fluence - (double)truth->fluence[0][cell];
        const double flux =
            params->bands > 1
                ? sqrt(4.0 * AIR_PI / 3.0) * (double)moments[cell * stride + 2 * AIR_DOM_STRIDE]
                : 0.0;
        const double flux_error = flux + beam - (double)truth->fluence[5][cell];
        score.fluence += error * error / CUBE_CELLS;
        score.flux += flux_error * flux_error / CUBE_CELLS;
        mean += (double)truth->fluence[0][cell] / CUBE_CELLS;
    }
    score.fluence = sqrt(score.fluence) / mean;
    score.flux = sqrt(score.flux) / mean;
    cube_score_angles(truth, params, moments, beam_share, &score);
    for (int side = 0; side < 6; side++) {
        const double beam =
            side == 5 ? beam_share * exp(-cube_extinction(params, cube_sigma_s)) : 0.0;
        const double share = (report->books[0].out[side] + beam) / truth->exits[side];
        score.exits = fmax(score.exits, fabs(share - 1.0));
    }
    free(moments);
    return score;
}

#endif
