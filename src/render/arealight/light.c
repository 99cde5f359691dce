/* light.c: what the rays of a block of samples receive from the lamps that the method
 * owns: the analytic light, and samples that tell which share of it is visible. */
#include <string.h>

#include "render/arealight/sample.h"

/* Numbers for one of a sample's draws, with the sampler's sets from here on. */
enum { AREA_SETS = 0x40000 };

/* ---- questions of visibility ---- */

/* Adds what arrives of a sample. */
static void add_arrived(const area_query *query, float through, air_path_lane *lanes,
                        air_lane_ratios *ratios)
{
    air_lane_ratios *ratio = &ratios[query->lane];
    air_vec3 *term = &lanes[query->lane].terms[query->surface ? AIR_TERM_S0 : AIR_TERM_M1];
    air_vec3 *sum = !query->ratio    ? term
                    : query->surface ? &ratio->surface.occluded
                                     : &ratio->volume.occluded;
    *sum = vec3_madd(*sum, through, query->value);
    *term = vec3_madd(*term, through, query->highlight);
}

/* Sends the rays that wait and adds what arrives. */
static void send(const air_with_arealight *with, air_area_scratch *scratch, air_path_lane *lanes,
                 air_lane_ratios *ratios)
{
    const size_t count = scratch->query_count;
    scratch->query_count = 0;
    float shares[AREA_QUERIES];
    air_path_shares(with->path, scratch->rays, count, scratch->occluded, shares);
    for (size_t i = 0; i < count; i++) {
        if (shares[i] > 0.0f) {
            add_arrived(&scratch->queries[i], shares[i], lanes, ratios);
        }
    }
}

/* From the sample's point to the lamp's, short of the lamp by more than rounding. */
static air_ray shadow_ray(const area_lamp *lamp, const area_ray *ray, bool surface,
                          const area_sample *sample)
{
    air_ray out = {.tmin = 0.0f, .mask = lamp->casts_shadow ? AIR_MASK_SHADOW_OPAQUE : 0};
    air_vec3 from = vec3((float)sample->point[0], (float)sample->point[1], (float)sample->point[2]);
    const air_vec3 to =
        vec3((float)sample->source[0], (float)sample->source[1], (float)sample->source[2]);
    if (surface) {
        from = air_surface_origin(ray->surface, vec3_sub(to, from));
    }
    const air_vec3 way = vec3_sub(to, from);
    const float length = vec3_length(way);
    vec3_store(out.origin, from);
    vec3_store(out.dir, vec3_scale(way, 1.0f / length));
    out.tmax = 0.9999f * length;
    return out;
}

/* ---- drawing ---- */

/* One of M candidates, kept with a probability in proportion to what it brings: stands for all of
 * them [Talbot2005]. The candidates' numbers are sets of the sampler from `set` on. */
static area_sample draw(const air_with_arealight *with, const air_area_scratch *scratch,
                        const area_lamp *lamp, const area_ray *ray, bool surface,
                        const air_sampler *sampler, uint32_t set)
{
    const uint32_t candidates = with->params->shadow_candidates;
    area_sample kept = {.value = {0.0f, 0.0f, 0.0f}, .highlight = {0.0f, 0.0f, 0.0f}};
    double total = 0.0, of_kept = 0.0;
    for (uint32_t i = 0; i < candidates; i++) {
        const air_f32x4 four = air_sampler_get(sampler, set + i);
        const double u[3] = {(double)four[0], (double)four[1], (double)four[2]};
        const area_sample sample = surface ? air_area_sample_surface(with, lamp, ray, u)
                                   : lamp->mode == AIR_AREA_MODE_VOLUME_RIS
                                       ? air_area_sample_extinction(with, scratch, lamp, ray, u)
                                       : air_area_sample_volume(with, scratch, lamp, ray, u);
        const double value = (double)vec3_mean(vec3_add(sample.value, sample.highlight));
        total += value;
        if (value > 0.0 && (double)four[3] * total < value) {
            kept = sample;
            of_kept = value;
        }
    }
    if (of_kept > 0.0) {
        const float scale = (float)(total / (of_kept * candidates));
        kept.value = vec3_scale(kept.value, scale);
        kept.highlight = vec3_scale(kept.highlight, scale);
    }
    return kept;
}

/* How a lamp's light on a surface or in the volume is drawn. */
typedef struct area_draws {
    uint32_t count;
    bool ratio;  /* does it tell the visible share of analytic light? else it is the light */
    bool hidden; /* may something be in the way? */
} area_draws;

/* Highlights have no closed form here: they are drawn even where shadows are left out. */
static area_draws plan_draws(const air_with_arealight *with, const area_lamp *lamp,
                             const area_ray *ray, bool surface)
{
    const uint32_t asked = with->params->shadow_samples;
    if (lamp->mode == AIR_AREA_MODE_VOLUME_RIS) {
        return (area_draws){1, false, true};
    }
    const bool highlight = surface && ray->surface->bsdf.f90 > 0.0f;
    return (area_draws){asked > 0 ? asked : highlight, true, asked > 0};
}

static void add_samples(const air_with_arealight *with, air_area_scratch *scratch,
                        const area_lamp *lamp, const area_ray *ray, bool surface, size_t lane,
                        air_path_lane *lanes, air_lane_ratios *ratios)
{
    const area_draws draws = plan_draws(with, lamp, ray, surface);
    const air_sampler *of_lane = &lanes[lane].sampler;
    const uint32_t kind = 2 * (uint32_t)(lamp - with->lamps) + (surface ? 1 : 0);
    const uint32_t set = AREA_SETS + kind * with->params->shadow_candidates;
    air_ratio_sample *sums = surface ? &ratios[lane].surface : &ratios[lane].volume;
    for (uint32_t i = 0; i < draws.count; i++) {
        /* the samples of a sample, too, belong to one sequence */
        const air_sampler sampler =
            air_sampler_make(of_lane->sobol, of_lane->seed, of_lane->index * draws.count + i);
        area_sample sample = draw(with, scratch, lamp, ray, surface, &sampler, set);
        sample.value = vec3_scale(sample.value, 1.0f / (float)draws.count);
        sample.highlight = vec3_scale(sample.highlight, 1.0f / (float)draws.count);
        if (vec3_is_zero(vec3_add(sample.value, sample.highlight))) {
            continue;
        }
        if (draws.ratio) {
            sums->unoccluded = vec3_add(sums->unoccluded, sample.value);
        }
        air_ray *out = &scratch->rays[scratch->query_count];
        *out = shadow_ray(lamp, ray, surface, &sample);
        out->mask = draws.hidden ? out->mask : 0;
        scratch->queries[scratch->query_count++] =
            (area_query){lane, surface, draws.ratio, sample.value, sample.highlight};
        if (scratch->query_count == AREA_QUERIES) {
            send(with, scratch, lanes, ratios);
        }
    }
}

/* ---- one lane ---- */

static void add_analytic(const air_with_arealight *with, air_area_scratch *scratch,
                         const area_lamp *lamp, const area_ray *ray, bool surface,
                         air_path_lane *lane, air_lane_ratios *ratios)
{
    const air_vec3 wo = vec3((float)-ray->dir[0], (float)-ray->dir[1], (float)-ray->dir[2]);
    const air_vec3 light =
        surface ? vec3_mul(air_area_surface_light(with, scratch, lamp, ray->surface, wo),
                           ray->camera_transmittance)
                : air_area_volume_light(with, scratch, lamp, ray->origin, ray->dir);
    air_vec3 *sum = with->params->shadow_samples == 0
                        ? &lane->terms[surface ? AIR_TERM_S0 : AIR_TERM_M1]
                    : surface ? &ratios->surface.analytic
                              : &ratios->volume.analytic;
    *sum = vec3_add(*sum, light);
}

static void make_ray(const air_with_arealight *with, air_area_scratch *scratch,
                     const air_path_lane *lane, air_surface *surface, area_ray *out)
{
    const bool met = lane->hit.mesh != (uint32_t)AIR_NO_HIT;
    vec3_store64(out->origin, lane->origin);
    vec3_store64(out->dir, lane->dir);
    out->t_max = met ? (double)lane->hit.t : INFINITY;
    out->surface = NULL;
    out->camera_transmittance = vec3_set1(1.0f);
    air_ray_media_make(&scratch->media, &with->snapshot->media, lane->origin, lane->dir,
                       met ? lane->hit.t : INFINITY);
    if (met && with->surfaces) {
        air_surface_make(with->snapshot, &lane->hit, lane->dir, surface);
        out->surface = surface;
        out->camera_transmittance = scratch->media.transmittance;
    }
}

static void add_lane(const air_with_arealight *with, air_area_scratch *scratch, size_t i,
                     air_path_lane *lanes, air_lane_ratios *ratios)
{
    area_ray ray;
    air_surface surface;
    make_ray(with, scratch, &lanes[i], &surface, &ray);
    const bool volume = with->volume && scratch->media.scatters;
    for (size_t k = 0; k < with->lamp_count; k++) {
        const area_lamp *lamp = &with->lamps[k];
        for (int on_surface = 0; on_surface < 2; on_surface++) {
            if (on_surface ? ray.surface == NULL : !volume) {
                continue;
            }
            if (lamp->mode != AIR_AREA_MODE_VOLUME_RIS) {
                add_analytic(with, scratch, lamp, &ray, on_surface, &lanes[i], &ratios[i]);
            }
            add_samples(with, scratch, lamp, &ray, on_surface, i, lanes, ratios);
        }
    }
}

void air_with_arealight_add(const air_with_arealight *with, air_area_scratch *scratch,
                            air_path_lane *lanes, air_lane_ratios *ratios, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        add_lane(with, scratch, i, lanes, ratios);
    }
    send(with, scratch, lanes, ratios);
}
