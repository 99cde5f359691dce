#include "bake/cache.h"

#include "bake/cache_sight.h"
#include "bake/progress.h"
#include "core/harmonics.h"
#include "core/phase.h"

enum { COEFFICIENTS = AIR_CACHE_COEFFICIENTS, BANDS = AIR_CACHE_BANDS };

typedef struct medium_cache {
    float moments[BANDS]; /* of the medium's phase function: integrals of p P_l over the sphere */
    air_cache_grids grids;
} medium_cache;

struct air_light_cache {
    air_context *context;
    medium_cache *media;
    size_t count;
};

/* ---- filling ---- */

/* Places of a cell that its point sees. Of a place that it does not see the one across is taken, so
 * that the middle stays where it is, or else the point itself. */
static bool draw_point(const void *user, size_t site, const float u[2], air_path_receiver *out)
{
    const air_cache_grid *g = user;
    uint32_t cell[3];
    air_cache_cell(g, site, cell);
    /* a third number from the two: they are multiples of 2^-24, whose low bits are as good */
    const uint32_t bits = air_hash_combine((uint32_t)(u[0] * 0x1p24f), (uint32_t)(u[1] * 0x1p24f));
    const air_vec3 center = air_cache_place_at(g, (float)cell[0], (float)cell[1], (float)cell[2]);
    const air_vec3 offset =
        vec3_mul(vec3(u[0] - 0.5f, u[1] - 0.5f, air_uint_to_float(bits) - 0.5f), g->step);
    *out = (air_path_receiver){.position = vec3_add(center, offset), .sphere = true};
    if (!air_cache_sees_own(g, out->position)) {
        out->position = vec3_sub(center, offset);
    }
    if (!air_cache_sees_own(g, out->position)) {
        out->position = center;
    }
    return true;
}

static void take_record(const float *record, air_cache_point *out)
{
    enum { COUNT = 3 * COEFFICIENTS };
    const float *harmonics = record + AIR_SITE_HARMONICS;
    *out = (air_cache_point){.weight =
                                 record[AIR_SITE_VALIDITY] >= AIR_SITE_VALID_SHARE ? 1.0f : 0.0f};
    for (size_t i = 0; i < COUNT; i++) {
        out->lights[i] = harmonics[COUNT * AIR_LAYER_DIRECT + i];
        out->rest[i] =
            harmonics[COUNT * AIR_LAYER_INDIRECT + i] + harmonics[COUNT * AIR_LAYER_MEDIA + i];
    }
}

static air_status fill(const air_path *path, uint32_t seed, uint32_t samples,
                       air_bake_progress *progress, double begin, double end, air_cache_grid *g)
{
    air_context *context = path->snapshot->context;
    const size_t count = air_cache_point_count(g);
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
    air_status status = AIR_OK;
    for (size_t i = 0; i < snapshot->media.count && status == AIR_OK; i++) {
        const air_medium *medium = &snapshot->media.media[i];
        medium_cache *m = &self->media[self->count++];
        for (int l = 0; l < BANDS; l++) {
            m->moments[l] = (float)phase_legendre(medium->phase, l);
        }
        status = air_cache_grids_place(self->context, snapshot, medium, resolution, &m->grids);
        for (size_t k = 0; k < m->grids.count && status == AIR_OK; k++) {
            status = air_cache_sight_make(self->context, snapshot, &m->grids.grids[k]);
        }
    }
    return status;
}

static size_t all_points(const air_light_cache *self)
{
    size_t count = 0;
    for (size_t i = 0; i < self->count; i++) {
        for (size_t k = 0; k < self->media[i].grids.count; k++) {
            count += air_cache_point_count(&self->media[i].grids.grids[k]);
        }
    }
    return count;
}

static uint32_t samples_of(const air_light_cache_params *params, size_t points)
{
    const double each = params->budget / double_max((double)points, 1.0);
    if (params->samples > 0) {
        return params->samples;
    }
    return each < AIR_CACHE_SAMPLES_LEAST  ? AIR_CACHE_SAMPLES_LEAST
           : each > AIR_CACHE_SAMPLES_MOST ? AIR_CACHE_SAMPLES_MOST
                                           : (uint32_t)each / 16 * 16;
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
        for (size_t k = 0; k < self->media[i].grids.count && status == AIR_OK; k++) {
            air_cache_grid *g = &self->media[i].grids.grids[k];
            const double begin = share * (double)done;
            done += air_cache_point_count(g);
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
        air_cache_grids_finish(self->context, &self->media[i].grids);
    }
    air_free(self->context, self->media);
    air_free(self->context, self);
}

size_t air_light_cache_bytes(const air_light_cache *self)
{
    return all_points(self) * sizeof(air_cache_point);
}

/* ---- looking up ---- */

/* How deep a point lies inside of a grid: 0 at its border, 1 from one cell on. */
static float inside_share(const air_cache_grid *g, air_vec3 p)
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

static void add_floats(float weight, const float *from, float *sum)
{
    for (int i = 0; i < AIR_CACHE_FLOATS; i++) {
        sum[i] += weight * from[i];
    }
}

/* What the points around a place hold, of those that it sees and that are not inside of something;
 * returns their weight. */
static float look_up(const air_cache_grid *g, const air_cache_place *at, unsigned sees, bool lights,
                     float sum[AIR_CACHE_FLOATS])
{
    float total = 0.0f;
    for (unsigned corner = 0; corner < 8; corner++) {
        const unsigned d[3] = {corner & 1u, corner >> 1 & 1u, corner >> 2};
        uint32_t p[3];
        float weight = (float)(sees >> corner & 1u);
        for (int k = 0; k < 3; k++) {
            p[k] = d[k] ? at->upper[k] : at->lower[k];
            weight *= d[k] ? at->share[k] : 1.0f - at->share[k];
        }
        const air_cache_point *point = &g->points[air_cache_index(g, p[0], p[1], p[2])];
        if (weight * point->weight > 0.0f) {
            add_floats(weight, point->rest, sum);
            if (lights) {
                add_floats(weight, point->lights, sum);
            }
            total += weight;
        }
    }
    return total;
}

/* What one grid says. Places that see none of their points ask all of them. */
static air_vec3 look_up_grid(const air_cache_grid *g, air_vec3 position,
                             const float factors[COEFFICIENTS], bool lights)
{
    const air_cache_place at = air_cache_locate(g, position);
    float sum[AIR_CACHE_FLOATS] = {0.0f};
    air_vec3 value = vec3_set1(0.0f);
    float weight = look_up(g, &at, at.sees, lights, sum);
    if (weight <= 0.0f) {
        weight = look_up(g, &at, 0xff, lights, sum);
    }
    for (int i = 0; i < COEFFICIENTS; i++) {
        value = vec3_madd(value, factors[i], vec3_load(sum + 3 * (size_t)i));
    }
    const float scale = weight > 0.0f ? 1.0f / weight : 0.0f;
    return vec3(scale * float_max(value.x, 0.0f), scale * float_max(value.y, 0.0f),
                scale * float_max(value.z, 0.0f));
}

air_vec3 air_light_cache_scattered(const void *cache, air_vec3 position, uint32_t medium,
                                   air_vec3 wo, bool lights)
{
    const air_light_cache *self = cache;
    const medium_cache *m = &self->media[medium];
    const float from[3] = {-wo.x, -wo.y, -wo.z};
    float factors[COEFFICIENTS], rest = 1.0f;
    air_vec3 sum = vec3_set1(0.0f);
    air_sh_evaluate_3(from, factors);
    for (int i = 0; i < COEFFICIENTS; i++) {
        factors[i] *= m->moments[air_sh_band_3(i)];
    }
    for (size_t k = 0; k < m->grids.count && rest > 0.0f; k++) {
        const air_cache_grid *g = &m->grids.grids[k];
        const float share = k + 1 < m->grids.count ? inside_share(g, position) : 1.0f;
        if (share > 0.0f) {
            const float used = rest * float_min(share, 1.0f);
            sum = vec3_madd(sum, used, look_up_grid(g, position, factors, lights));
            rest -= used;
        }
    }
    return sum;
}
