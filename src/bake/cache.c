#include "bake/cache.h"

#include <stdlib.h>

#include "bake/progress.h"
#include "core/harmonics.h"
#include "core/phase.h"
#include "core/quadrature.h"

enum { COEFFICIENTS = AIR_PROBE_COEFFICIENTS, BANDS = 3, FLAT_RESOLUTION = 8 };

/* What a point holds: straight from lights, and all else. */
typedef struct point {
    float lights[COEFFICIENTS][3], rest[COEFFICIENTS][3];
    float weight; /* 0: inside of something */
} point;

/* A box of points at the centres of its cells. */
typedef struct grid {
    air_vec3 low, step; /* of the first point; to the next ones */
    uint32_t size[3];
    point *points;
} grid;

/* The grids of one medium, finest first; the last holds all that matters. */
typedef struct medium_cache {
    float moments[BANDS]; /* of the medium's phase function: integrals of p P_l over the sphere */
    grid *grids;
    size_t count;
} medium_cache;

struct air_light_cache {
    air_context *context;
    medium_cache *media;
    size_t count;
};

/* ---- where ---- */

typedef struct box {
    air_vec3 low, high;
} box;

static bool box_is_empty(box b)
{
    return !(b.low.x <= b.high.x && b.low.y <= b.high.y && b.low.z <= b.high.z);
}

static box box_add(box b, air_vec3 p)
{
    return (box){vec3(fminf(b.low.x, p.x), fminf(b.low.y, p.y), fminf(b.low.z, p.z)),
                 vec3(fmaxf(b.high.x, p.x), fmaxf(b.high.y, p.y), fmaxf(b.high.z, p.z))};
}

static box box_grow(box b, float margin)
{
    return (box){vec3_sub(b.low, vec3_set1(margin)), vec3_add(b.high, vec3_set1(margin))};
}

static box box_cut(box a, box b)
{
    return (box){
        vec3(fmaxf(a.low.x, b.low.x), fmaxf(a.low.y, b.low.y), fmaxf(a.low.z, b.low.z)),
        vec3(fminf(a.high.x, b.high.x), fminf(a.high.y, b.high.y), fminf(a.high.z, b.high.z))};
}

static float box_side(box b)
{
    return float_max(b.high.x - b.low.x, float_max(b.high.y - b.low.y, b.high.z - b.low.z));
}

/* Surfaces and lamps. */
static box scene_box(const air_snapshot *snapshot)
{
    box b = {vec3_load(snapshot->bounds_min), vec3_load(snapshot->bounds_max)};
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        const air_light *light = &snapshot->lights.entries[i];
        if (light->kind == AIR_LIGHT_POINT || light->kind == AIR_LIGHT_SPOT) {
            b = box_is_empty(b) ? (box){light->position, light->position}
                                : box_add(b, light->position);
        }
    }
    return b;
}

/* `resolution` cells along the longest side; cubes, but layers get at least FLAT_RESOLUTION across,
 * for that is where their light varies. */
static void lay_out(box b, uint32_t resolution, grid *out)
{
    const float extent[3] = {b.high.x - b.low.x, b.high.y - b.low.y, b.high.z - b.low.z};
    const float cell = box_side(b) / (float)resolution;
    const uint32_t least = resolution < FLAT_RESOLUTION ? resolution : FLAT_RESOLUTION;
    float step[3];
    for (int k = 0; k < 3; k++) {
        const float cells = cell > 0.0f ? ceilf(extent[k] / cell - 1e-3f) : 1.0f;
        out->size[k] = cells > (float)least ? (uint32_t)cells : extent[k] > 0.0f ? least : 1;
        step[k] = float_max(extent[k], 0.0f) / (float)out->size[k];
    }
    out->step = vec3(step[0], step[1], step[2]);
    out->low = vec3_madd(b.low, 0.5f, out->step);
}

static size_t point_count(const grid *g) { return (size_t)g->size[0] * g->size[1] * g->size[2]; }

static float cell_of(const grid *g)
{
    return float_max(g->step.x, float_max(g->step.y, g->step.z));
}

/* A lamp's centre and reach. False for what has none. */
static bool lamp_of(const air_light *light, air_vec3 *out_center, float *out_radius)
{
    *out_center = light->position;
    *out_radius = 0.0f;
    if (light->kind == AIR_LIGHT_POINT || light->kind == AIR_LIGHT_SPOT) {
        return true;
    }
    if (light->kind != AIR_LIGHT_POLYGON || light->vertex_count == 0) {
        return false;
    }
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < light->vertex_count; i++) {
        sum = vec3_add(sum, light->vertices[i]);
    }
    *out_center = vec3_scale(sum, 1.0f / (float)light->vertex_count);
    *out_radius = sqrtf(light->area);
    return true;
}

enum { MOST_GRIDS = 10, LAMP_RESOLUTION = 16, FAR_RESOLUTION = 8 };

/* Is the point well inside of a grid whose cells are no larger? */
static bool has_finer(const medium_cache *m, air_vec3 p, float cell)
{
    for (size_t i = 0; i < m->count; i++) {
        const grid *g = &m->grids[i];
        const air_vec3 d = vec3_sub(p, g->low);
        const float reach[3] = {g->step.x * (float)g->size[0], g->step.y * (float)g->size[1],
                                g->step.z * (float)g->size[2]};
        const float at[3] = {d.x, d.y, d.z};
        bool inside = cell_of(g) <= cell * 1.01f;
        for (int k = 0; k < 3; k++) {
            inside = inside && at[k] > 0.25f * reach[k] && at[k] < 0.75f * reach[k];
        }
        if (inside) {
            return true;
        }
    }
    return false;
}

/* About a lamp light varies over distances in proportion to the distance from it: boxes, each half
 * as large as the one before, until cells are a third of the mean free path or of the way to the
 * nearest wall, or of the lamp's own size. */
static void add_lamp(const air_medium *medium, box bounds, air_vec3 center, float radius,
                     float wall, medium_cache *m)
{
    const float extinction = vec3_max(medium->sigma_t);
    const float path = extinction > 0.0f ? 1.0f / extinction : INFINITY;
    const float finest = float_max(float_min(path, wall), radius) * (1.0f / 3.0f);
    for (float half = 0.25f * box_side(bounds);
         m->count < MOST_GRIDS - 2 && 2.0f * half / LAMP_RESOLUTION > 0.5f * finest; half *= 0.5f) {
        const box b = box_cut(box_grow((box){center, center}, half), bounds);
        grid *g = &m->grids[m->count];
        if (box_is_empty(b) || !(box_side(b) > 0.0f)) {
            return;
        }
        if (!has_finer(m, center, box_side(b) / LAMP_RESOLUTION)) {
            lay_out(b, LAMP_RESOLUTION, g);
            m->count++;
        }
    }
}

/* The distance from a lamp to the nearest surface, by some rays. */
static float wall_distance(const air_snapshot *snapshot, air_vec3 from)
{
    const air_ray_backend *rays = air_context_ray_backend(snapshot->context);
    float nearest = INFINITY;
    for (int i = 0; i < 26 && snapshot->accelerator != NULL; i++) {
        const int k = i < 13 ? i : i + 1;
        const air_vec3 dir =
            vec3_normalize(vec3((float)(k % 3 - 1), (float)(k / 3 % 3 - 1), (float)(k / 9 - 1)));
        const air_ray ray = {
            {from.x, from.y, from.z}, 1e-3f, {dir.x, dir.y, dir.z}, 3e38f, AIR_MASK_SCATTER};
        air_hit hit;
        rays->intersect(snapshot->accelerator, &ray, 1, &hit);
        if (hit.mesh != (uint32_t)AIR_NO_HIT && hit.t > 1e-2f) {
            nearest = float_min(nearest, hit.t);
        }
    }
    return nearest;
}

static int by_cell(const void *a, const void *b)
{
    const float x = cell_of(a), y = cell_of(b);
    return x < y ? -1 : x > y;
}

/* Grids of one medium: the scene; boxes about lamps; and, for media that reach beyond the scene by
 * more than it is large, what lies within four mean free paths of it. */
static void place_grids(const air_snapshot *snapshot, const air_medium *medium, uint32_t resolution,
                        medium_cache *m)
{
    const float extinction = vec3_max(medium->sigma_t);
    const float path = extinction > 0.0f ? 1.0f / extinction : 0.0f;
    box scene = scene_box(snapshot);
    if (box_is_empty(scene)) {
        scene = (box){vec3_set1(-path), vec3_set1(path)};
    }
    const float side = float_max(box_side(scene), 1e-3f * path);
    const box medium_box = {vec3_load(medium->bounds_min), vec3_load(medium->bounds_max)};
    const float margin = float_min(0.25f * side, 2.0f * path) + 1e-3f * path;
    const box near = box_cut(box_grow(scene, margin), medium_box);
    const box far = box_cut(box_grow(scene, 4.0f * path), medium_box);
    if (box_is_empty(near)) {
        return; /* nothing of it is near anything */
    }
    lay_out(near, resolution, &m->grids[m->count++]);
    for (size_t i = 0; i < snapshot->lights.count; i++) {
        air_vec3 center;
        float radius;
        if (lamp_of(&snapshot->lights.entries[i], &center, &radius)) {
            add_lamp(medium, far, center, radius, wall_distance(snapshot, center), m);
        }
    }
    if (box_side(far) > 1.5f * box_side(near)) {
        lay_out(far, FAR_RESOLUTION, &m->grids[m->count++]);
    }
    qsort(m->grids, m->count, sizeof *m->grids, by_cell);
}

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

static air_status fill(const air_path *path, uint32_t seed, uint32_t samples,
                       air_bake_progress *progress, double begin, double end, grid *g)
{
    air_context *context = path->snapshot->context;
    const size_t count = point_count(g);
    air_site_list list = {.what = "light in media",
                          .count = count,
                          .draw = draw_point,
                          .user = g,
                          .seed = seed,
                          .samples = samples,
                          .through = samples,
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

static air_status place_all(air_light_cache *self, const air_snapshot *snapshot,
                            uint32_t resolution)
{
    for (size_t i = 0; i < snapshot->media.count; i++) {
        medium_cache *m = &self->media[self->count++];
        m->grids = air_allocate(self->context, MOST_GRIDS, sizeof *m->grids);
        if (m->grids == NULL) {
            return air_fail_memory(self->context, "light in media");
        }
        place_grids(snapshot, &snapshot->media.media[i], resolution, m);
        phase_moments(&snapshot->media.media[i].phase, m->moments);
    }
    return AIR_OK;
}

static size_t all_points(const air_light_cache *self)
{
    size_t count = 0;
    for (size_t i = 0; i < self->count; i++) {
        for (size_t k = 0; k < self->media[i].count; k++) {
            count += point_count(&self->media[i].grids[k]);
        }
    }
    return count;
}

static uint32_t samples_of(const air_light_cache_params *params, size_t points)
{
    enum { LEAST = 64, MOST = 1024 };
    const double each = params->budget / double_max((double)points, 1.0);
    if (params->samples > 0) {
        return params->samples;
    }
    return each < LEAST ? LEAST : each > MOST ? MOST : (uint32_t)each / 16 * 16;
}

static air_status fill_all(air_light_cache *self, const air_path *path,
                           const air_light_cache_params *params, air_bake_progress *progress,
                           double fraction_end)
{
    const double share = fraction_end / (double)all_points(self);
    const uint32_t samples = samples_of(params, all_points(self));
    size_t done = 0;
    uint32_t number = 0;
    air_status status = AIR_OK;
    for (size_t i = 0; i < self->count; i++) {
        for (size_t k = 0; k < self->media[i].count && status == AIR_OK; k++) {
            grid *g = &self->media[i].grids[k];
            const double begin = share * (double)done;
            done += point_count(g);
            status = fill(path, air_hash_combine(params->seed, 0xcac4e000u + number++), samples,
                          progress, begin, share * (double)done, g);
        }
    }
    return status;
}

air_status air_light_cache_create(air_context *context, const air_snapshot *snapshot,
                                  const air_sobol *sobol, const air_light_cache_params *params,
                                  air_bake_progress *progress, double fraction_end,
                                  air_light_cache **out_cache)
{
    const air_path_settings settings = {
        .max_depth = params->max_depth, .terms = AIR_TERMS_ALL, .source = {.through = true}};
    air_light_cache *self = air_allocate(context, 1, sizeof *self);
    air_path path;
    *out_cache = NULL;
    if (self == NULL) {
        return air_fail_memory(context, "light in media");
    }
    self->context = context;
    self->media = air_allocate(context, snapshot->media.count, sizeof *self->media);
    air_status status = self->media == NULL ? air_fail_memory(context, "light in media")
                                            : place_all(self, snapshot, params->resolution);
    if (status == AIR_OK) {
        status = air_path_init(&path, snapshot, sobol, &settings);
    }
    if (status == AIR_OK) {
        status = fill_all(self, &path, params, progress, fraction_end);
        air_path_finish(&path);
    }
    if (status != AIR_OK) {
        air_light_cache_destroy(self);
        return status;
    }
    *out_cache = self;
    return AIR_OK;
}

void air_light_cache_destroy(air_light_cache *self)
{
    if (self == NULL) {
        return;
    }
    for (size_t i = 0; i < self->count; i++) {
        for (size_t k = 0; k < self->media[i].count; k++) {
            air_free(self->context, self->media[i].grids[k].points);
        }
        air_free(self->context, self->media[i].grids);
    }
    air_free(self->context, self->media);
    air_free(self->context, self);
}

size_t air_light_cache_bytes(const air_light_cache *self)
{
    return all_points(self) * sizeof(point);
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

/* How deep a point lies inside of a grid: 0 at its border, 1 from one cell on. */
static float inside_share(const grid *g, air_vec3 p)
{
    const float at[3] = {p.x - g->low.x, p.y - g->low.y, p.z - g->low.z};
    const float step[3] = {g->step.x, g->step.y, g->step.z};
    float share = 1.0f;
    for (int k = 0; k < 3; k++) {
        const float cell = step[k] > 0.0f ? at[k] / step[k] + 0.5f : 0.0f;
        const float depth = float_min(cell, (float)g->size[k] - cell);
        share = float_min(share, step[k] > 0.0f ? depth : 1.0f);
    }
    return float_max(share, 0.0f);
}

/* What one grid says, with the weights of points that are inside of something left out; returns the
 * weight of the others. */
static float look_up(const grid *g, air_vec3 position, const float factors[COEFFICIENTS],
                     bool lights, float sum[3])
{
    float share[3], total = 0.0f;
    const uint32_t x = neighbour(position.x, g->low.x, g->step.x, g->size[0], &share[0]);
    const uint32_t y = neighbour(position.y, g->low.y, g->step.y, g->size[1], &share[1]);
    const uint32_t z = neighbour(position.z, g->low.z, g->step.z, g->size[2], &share[2]);
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
    return total;
}

air_vec3 air_light_cache_scattered(const void *cache, air_vec3 position, uint32_t medium,
                                   air_vec3 wo, bool lights)
{
    const air_light_cache *self = cache;
    const medium_cache *m = &self->media[medium];
    const float from[3] = {-wo.x, -wo.y, -wo.z};
    float factors[COEFFICIENTS], sum[3] = {0.0f, 0.0f, 0.0f}, rest = 1.0f;
    air_sh_evaluate_3(from, factors);
    for (int i = 0; i < COEFFICIENTS; i++) {
        factors[i] *= m->moments[i == 0 ? 0 : i < 4 ? 1 : 2];
    }
    for (size_t k = 0; k < m->count && rest > 0.0f; k++) {
        const float share = k + 1 < m->count ? inside_share(&m->grids[k], position) : 1.0f;
        float value[3] = {0.0f, 0.0f, 0.0f};
        if (share > 0.0f) {
            const float weight = look_up(&m->grids[k], position, factors, lights, value);
            const float scale = weight > 0.0f ? rest * share / weight : 0.0f;
            for (int c = 0; c < 3; c++) {
                sum[c] += scale * float_max(value[c], 0.0f);
            }
            rest *= 1.0f - share;
        }
    }
    return vec3(sum[0], sum[1], sum[2]);
}
