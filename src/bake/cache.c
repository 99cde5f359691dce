#include "bake/cache.h"

#include <string.h>

#include "bake/progress.h"
#include "core/harmonics.h"
#include "core/phase.h"
#include "core/quadrature.h"

enum { COEFFICIENTS = AIR_PROBE_COEFFICIENTS, BANDS = 3 };

/* What a point holds: straight from lights, and all else. */
typedef struct point {
    float lights[COEFFICIENTS][3], rest[COEFFICIENTS][3];
    float weight; /* 0: inside of something */
} point;

typedef struct grid {
    air_vec3 low, step; /* of the first point; to the next ones */
    uint32_t size[3];
    float moments[BANDS]; /* of the medium's phase function: integrals of p P_l over the sphere */
    point *points;
} grid;

struct air_light_cache {
    air_context *context;
    grid *grids; /* one per medium */
    size_t count;
};

/* ---- where ---- */

/* Light and fog beyond the surfaces and lamps of a scene matters to surfaces within some mean free
 * paths; media without end get a margin of a quarter of the scene, at most two mean free paths. */
static void bounds_of(const air_snapshot *snapshot, const air_medium *medium, air_vec3 *low,
                      air_vec3 *high)
{
    air_vec3 scene_low = vec3_load(snapshot->bounds_min);
    air_vec3 scene_high = vec3_load(snapshot->bounds_max);
    if (!(scene_low.x <= scene_high.x)) {
        scene_low = vec3_set1(-1.0f);
        scene_high = vec3_set1(1.0f);
    }
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        const air_light *light = &snapshot->lights.entries[i];
        if (light->kind == AIR_LIGHT_POINT || light->kind == AIR_LIGHT_SPOT) {
            const air_vec3 p = light->position;
            scene_low =
                vec3(fminf(scene_low.x, p.x), fminf(scene_low.y, p.y), fminf(scene_low.z, p.z));
            scene_high =
                vec3(fmaxf(scene_high.x, p.x), fmaxf(scene_high.y, p.y), fmaxf(scene_high.z, p.z));
        }
    }
    const float diagonal = vec3_length(vec3_sub(scene_high, scene_low));
    const float extinction = vec3_max(medium->sigma_t);
    const float margin = extinction > 0.0f ? float_min(0.25f * diagonal, 2.0f / extinction) : 0.0f;
    *low = vec3_sub(scene_low, vec3_set1(margin));
    *high = vec3_add(scene_high, vec3_set1(margin));
    const float *a = medium->bounds_min, *b = medium->bounds_max;
    *low = vec3(fmaxf(low->x, a[0]), fmaxf(low->y, a[1]), fmaxf(low->z, a[2]));
    *high = vec3(fminf(high->x, b[0]), fminf(high->y, b[1]), fminf(high->z, b[2]));
}

/* Points lie at the centres of cells that fill the bounds. */
static void lay_out(const air_snapshot *snapshot, const air_medium *medium, uint32_t resolution,
                    grid *out)
{
    air_vec3 low, high;
    bounds_of(snapshot, medium, &low, &high);
    const float extent[3] = {high.x - low.x, high.y - low.y, high.z - low.z};
    const float cell = float_max(extent[0], float_max(extent[1], extent[2])) / (float)resolution;
    float step[3];
    for (int k = 0; k < 3; k++) {
        const float cells = cell > 0.0f ? ceilf(extent[k] / cell - 1e-3f) : 1.0f;
        out->size[k] = cells >= 1.0f ? (uint32_t)cells : 1;
        step[k] = float_max(extent[k], 0.0f) / (float)out->size[k];
    }
    out->step = vec3(step[0], step[1], step[2]);
    out->low = vec3_madd(low, 0.5f, out->step);
}

static size_t point_count(const grid *g) { return (size_t)g->size[0] * g->size[1] * g->size[2]; }

/* Integrals of p P_l over the sphere: what scattering leaves of band l. Sharp lobes want nodes near
 * the peak: cos = 1 - 2 s^4 puts them there, and 64 of them integrate g = 0.97 to 1e-6. */
static void phase_moments(const air_phase *phase, float out[BANDS])
{
    enum { NODES = 64 };
    double nodes[NODES], weights[NODES], sums[BANDS] = {0.0};
    air_gauss_legendre(NODES, nodes, weights);
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < NODES; i++) {
            const double s = 0.5 * (nodes[i] + 1.0), from_peak = s * s * s * s;
            const double mu = side == 0 ? 1.0 - from_peak : from_peak - 1.0;
            const double weight = 0.5 * weights[i] * 4.0 * s * s * s;
            const double p = 2.0 * AIR_PI * (double)phase_eval(*phase, (float)mu);
            double legendre[BANDS];
            air_legendre(BANDS, mu, legendre);
            for (int l = 0; l < BANDS; l++) {
                sums[l] += weight * p * legendre[l];
            }
        }
    }
    for (int l = 0; l < BANDS; l++) {
        out[l] = (float)(sums[l] / sums[0]);
    }
}

/* ---- filling ---- */

static bool draw_point(const void *user, size_t site, const float u[2], air_path_receiver *out)
{
    const grid *g = user;
    const size_t x = site % g->size[0], y = site / g->size[0] % g->size[1];
    const size_t z = site / ((size_t)g->size[0] * g->size[1]);
    /* a third number from the two: they are multiples of 2^-24, whose low bits are as good */
    const uint32_t bits = air_hash_combine((uint32_t)(u[0] * 0x1p24f), (uint32_t)(u[1] * 0x1p24f));
    const float w = air_uint_to_float(bits);
    out->sphere = true;
    out->uniform = 0.0f;
    out->offset = 0.0f;
    out->normal = out->geometric = vec3_set1(0.0f);
    out->position = vec3(g->low.x + ((float)x + u[0] - 0.5f) * g->step.x,
                         g->low.y + ((float)y + u[1] - 0.5f) * g->step.y,
                         g->low.z + ((float)z + w - 0.5f) * g->step.z);
    return true;
}

/* At least half of the cell must be open. */
#define OPEN_SHARE 0.5f

static void take_record(const float *record, point *out)
{
    const float *harmonics = record + AIR_SITE_HARMONICS;
    out->weight = record[AIR_SITE_VALIDITY] >= OPEN_SHARE ? 1.0f : 0.0f;
    for (size_t i = 0; i < COEFFICIENTS; i++) {
        for (size_t c = 0; c < 3; c++) {
            const float *at = harmonics + 3 * i + c;
            out->lights[i][c] = at[(size_t)3 * COEFFICIENTS * AIR_LAYER_DIRECT];
            out->rest[i][c] = at[(size_t)3 * COEFFICIENTS * AIR_LAYER_INDIRECT] +
                              at[(size_t)3 * COEFFICIENTS * AIR_LAYER_MEDIA];
        }
    }
}

static air_status fill(const air_path *path, const air_light_cache_params *params, size_t medium,
                       air_bake_progress *progress, double begin, double end, grid *g)
{
    air_context *context = path->snapshot->context;
    const size_t count = point_count(g);
    air_site_list list = {.what = "light in media",
                          .count = count,
                          .draw = draw_point,
                          .user = g,
                          .seed = air_hash_combine(params->seed, 0xcac4e000u + (uint32_t)medium),
                          .samples = params->samples,
                          .coefficients = COEFFICIENTS,
                          .apart = true};
    g->points = air_allocate(context, count, sizeof *g->points);
    air_status status = g->points == NULL ? air_fail_memory(context, "light in media")
                                          : air_sites_run(path, &list, progress, begin, end);
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        take_record(list.records + i * air_site_stride(&list), &g->points[i]);
    }
    air_free(context, list.records);
    return status;
}

air_status air_light_cache_create(air_context *context, const air_snapshot *snapshot,
                                  const air_sobol *sobol, const air_light_cache_params *params,
                                  air_bake_progress *progress, double fraction_end,
                                  air_light_cache **out_cache)
{
    const air_media *media = &snapshot->media;
    const air_path_settings settings = {.max_depth = params->max_depth, .terms = AIR_TERMS_ALL};
    air_light_cache *self = air_allocate(context, 1, sizeof *self);
    air_path path;
    *out_cache = NULL;
    if (self == NULL) {
        return air_fail_memory(context, "light in media");
    }
    self->context = context;
    self->grids = air_allocate(context, media->count, sizeof *self->grids);
    air_status status = self->grids == NULL ? air_fail_memory(context, "light in media") : AIR_OK;
    if (status == AIR_OK) {
        status = air_path_init(&path, snapshot, sobol, &settings);
    }
    for (size_t i = 0; i < media->count && status == AIR_OK; i++) {
        const double share = fraction_end / (double)media->count;
        self->count++;
        lay_out(snapshot, &media->media[i], params->resolution, &self->grids[i]);
        phase_moments(&media->media[i].phase, self->grids[i].moments);
        status = fill(&path, params, i, progress, share * (double)i, share * (double)(i + 1),
                      &self->grids[i]);
    }
    if (status != AIR_OK) {
        air_light_cache_destroy(self);
        return status;
    }
    air_path_finish(&path);
    *out_cache = self;
    return AIR_OK;
}

void air_light_cache_destroy(air_light_cache *self)
{
    if (self == NULL) {
        return;
    }
    for (size_t i = 0; i < self->count; i++) {
        air_free(self->context, self->grids[i].points);
    }
    air_free(self->context, self->grids);
    air_free(self->context, self);
}

size_t air_light_cache_bytes(const air_light_cache *self)
{
    size_t bytes = 0;
    for (size_t i = 0; i < self->count; i++) {
        bytes += point_count(&self->grids[i]) * sizeof(point);
    }
    return bytes;
}

/* ---- looking up ---- */

/* The lower neighbour along one axis and the share of the upper one. */
static uint32_t neighbour(float at, float low, float step, uint32_t size, float *out_share)
{
    const float x = step > 0.0f ? (at - low) / step : 0.0f;
    const float last = (float)(size - 1);
    const float inside = float_min(float_max(x, 0.0f), last);
    const uint32_t cell = (uint32_t)inside;
    *out_share = cell + 1 < size ? inside - (float)cell : 0.0f;
    return cell;
}

/* Adds weight times what the point scatters along factors. */
static void add_point(const point *p, float weight, const float factors[COEFFICIENTS], bool lights,
                      float sum[3])
{
    for (int c = 0; c < 3; c++) {
        float value = 0.0f;
        for (size_t i = 0; i < COEFFICIENTS; i++) {
            value += factors[i] * (p->rest[i][c] + (lights ? p->lights[i][c] : 0.0f));
        }
        sum[c] += weight * value;
    }
}

air_vec3 air_light_cache_scattered(const void *cache, air_vec3 position, uint32_t medium,
                                   air_vec3 wo, bool lights)
{
    const air_light_cache *self = cache;
    const grid *g = &self->grids[medium];
    const float from[3] = {-wo.x, -wo.y, -wo.z};
    float factors[COEFFICIENTS], share[3], sum[3] = {0.0f, 0.0f, 0.0f}, total = 0.0f;
    const uint32_t x = neighbour(position.x, g->low.x, g->step.x, g->size[0], &share[0]);
    const uint32_t y = neighbour(position.y, g->low.y, g->step.y, g->size[1], &share[1]);
    const uint32_t z = neighbour(position.z, g->low.z, g->step.z, g->size[2], &share[2]);
    air_sh_evaluate_3(from, factors);
    for (int i = 0; i < COEFFICIENTS; i++) {
        factors[i] *= g->moments[i == 0 ? 0 : i < 4 ? 1 : 2];
    }
    for (uint32_t corner = 0; corner < 8; corner++) {
        const uint32_t dx = corner & 1u, dy = corner >> 1 & 1u, dz = corner >> 2;
        const float weight = (dx ? share[0] : 1.0f - share[0]) * (dy ? share[1] : 1.0f - share[1]) *
                             (dz ? share[2] : 1.0f - share[2]);
        if (weight > 0.0f) {
            const size_t at = ((size_t)(z + dz) * g->size[1] + y + dy) * g->size[0] + x + dx;
            const point *p = &g->points[at];
            add_point(p, weight * p->weight, factors, lights, sum);
            total += weight * p->weight;
        }
    }
    if (!(total > 0.0f)) {
        return vec3_set1(0.0f);
    }
    const float scale = 1.0f / total;
    return vec3(float_max(sum[0] * scale, 0.0f), float_max(sum[1] * scale, 0.0f),
                float_max(sum[2] * scale, 0.0f));
}
