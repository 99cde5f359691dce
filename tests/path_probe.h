/* path_probe.h: asking the path tracer directly: radiance along a ray and fluence at a point, with
 * standard errors. */
#ifndef AIR_TESTS_PATH_PROBE_H
#define AIR_TESTS_PATH_PROBE_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "path/path.h"

/* Means over replicates with the standard error of the mean of each channel. */
typedef struct probe_result {
    double mean[3], error[3];
    double terms[AIR_TERM_COUNT]; /* green */
} probe_result;

typedef struct probe {
    air_vec3 origin;
    const air_vec3 *dir; /* NULL: integrated over the sphere, that is, fluence */
    uint32_t max_depth, terms;
    uint32_t replicates, samples; /* samples per replicate, a multiple of 16 */
    air_vec3 source;              /* fluence: where the light is */
} probe;

/* Directions of fluence have all angles to the source alike: the light that fog scatters around a
 * point source rises as 1 / sin(angle), so that a uniform density of directions would have infinite
 * variance. Returns one over the density, and the direction. */
static inline float probe_direction(const probe *p, air_f32x4 u, air_vec3 *dir)
{
    if (p->dir != NULL) {
        *dir = *p->dir;
        return 1.0f;
    }
    const air_frame frame = frame_from_normal(vec3_normalize(vec3_sub(p->source, p->origin)));
    const float theta = AIR_PI_F * u[0], phi = 2.0f * AIR_PI_F * u[1], r = sinf(theta);
    *dir = frame_to_world(&frame, vec3(r * cosf(phi), r * sinf(phi), cosf(theta)));
    return 2.0f * AIR_PI_F * AIR_PI_F * r;
}

static inline void probe_replicate(const air_path *path, const air_sobol *sobol, const probe *p,
                                   air_path_scratch *scratch, uint32_t replicate,
                                   double sum[AIR_TERM_COUNT][3])
{
    for (uint32_t s = 0; s < p->samples; s += AIR_PATH_LANES) {
        air_path_lane lanes[AIR_PATH_LANES];
        double weights[AIR_PATH_LANES];
        for (uint32_t i = 0; i < AIR_PATH_LANES; i++) {
            lanes[i].sampler = air_sampler_make(sobol, air_hash32(replicate + 1), s + i);
            const air_f32x4 u = air_sampler_get(&lanes[i].sampler, 0);
            lanes[i].origin = p->origin;
            weights[i] = (double)probe_direction(p, u, &lanes[i].dir) / p->samples;
            lanes[i].u_distance = u[2];
            lanes[i].u_pick = u[3];
            lanes[i].x = lanes[i].y = 0;
            lanes[i].sample = s + i;
        }
        air_path_trace(path, scratch, lanes, AIR_PATH_LANES);
        for (uint32_t i = 0; i < AIR_PATH_LANES; i++) {
            for (int t = 0; t < AIR_TERM_COUNT; t++) {
                sum[t][0] += weights[i] * (double)lanes[i].terms[t].x;
                sum[t][1] += weights[i] * (double)lanes[i].terms[t].y;
                sum[t][2] += weights[i] * (double)lanes[i].terms[t].z;
            }
        }
    }
}

static inline probe_result probe_run(const air_snapshot *snapshot, const probe *p)
{
    probe_result out;
    double squares[3] = {0.0, 0.0, 0.0};
    air_sobol *sobol = malloc(sizeof *sobol);
    air_path_scratch *scratch = malloc(air_path_scratch_size());
    air_path path;
    const air_path_settings settings = {.max_depth = p->max_depth, .terms = p->terms};
    memset(&out, 0, sizeof out);
    assert_non_null(sobol);
    assert_non_null(scratch);
    air_sobol_init(sobol);
    assert_int_equal(air_path_init(&path, snapshot, sobol, &settings), AIR_OK);
    for (uint32_t r = 0; r < p->replicates; r++) {
        double sum[AIR_TERM_COUNT][3] = {{0.0}}, beauty[3] = {0.0, 0.0, 0.0};
        probe_replicate(&path, sobol, p, scratch, r, sum);
        for (int t = 0; t < AIR_TERM_COUNT; t++) {
            out.terms[t] += sum[t][1] / p->replicates;
            for (int c = 0; c < 3; c++) {
                beauty[c] += sum[t][c];
            }
        }
        for (int c = 0; c < 3; c++) {
            out.mean[c] += beauty[c] / p->replicates;
            squares[c] += beauty[c] * beauty[c] / p->replicates;
        }
    }
    for (int c = 0; c < 3; c++) {
        const double variance = fmax(squares[c] - out.mean[c] * out.mean[c], 0.0);
        out.error[c] = sqrt(variance / (p->replicates - 1));
    }
    air_path_finish(&path);
    free(sobol);
    free(scratch);
    return out;
}

#endif
