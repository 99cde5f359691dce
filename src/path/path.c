/* path.c: the walk: camera rays, what they see, where they scatter, where they go on. */
#include "path/path.h"

#include <float.h>

#include "core/phase.h"
#include "path/distance.h"
#include "path/tracking.h"
#include "path/vertex.h"

size_t air_path_scratch_size(void) { return sizeof(air_path_scratch); }

static bool any_emission(const air_snapshot *snapshot)
{
    for (size_t i = 0; i < snapshot->material_count; i++) {
        if (!vec3_is_zero(snapshot->materials[i].emission)) {
            return true;
        }
    }
    return snapshot->lights.environment_count > 0 || snapshot->lights.visible_accelerator != NULL;
}

/* ---- what is path's to compute ---- */

/* Does path own the term of this light in some medium, or in none? */
static bool owns(const air_path_settings *settings, size_t media_count, size_t owner, air_term term)
{
    for (size_t m = 0; settings->wanted != NULL && m <= media_count; m++) {
        if (settings->wanted[(owner * (media_count + 1) + m) * AIR_TERM_COUNT + term] != 0) {
            return true;
        }
    }
    return settings->wanted == NULL;
}

static bool owns_first(const air_path *path, size_t entry)
{
    const size_t owner = path->snapshot->lights.entries[entry].owner;
    const size_t media = path->snapshot->media.count;
    return owns(&path->settings, media, owner, AIR_TERM_S0) ||
           owns(&path->settings, media, owner, AIR_TERM_M1);
}

/* Leaves out the terms of light that other methods own altogether, and events that would then give
 * nothing. */
static void narrow_terms(air_path *path)
{
    const air_snapshot *snapshot = path->snapshot;
    const uint32_t deep = (1u << AIR_TERM_S_PLUS) | (1u << AIR_TERM_M2);
    const uint32_t first = (1u << AIR_TERM_S0) | (1u << AIR_TERM_M1);
    air_path_settings *settings = &path->settings;
    for (unsigned term = AIR_TERM_S0; term <= AIR_TERM_M2; term++) {
        bool owned = snapshot->lights.owner_count == 0 || path->emissive_media;
        for (size_t owner = 0; owner < snapshot->lights.owner_count; owner++) {
            owned = owned || owns(settings, snapshot->media.count, owner, (air_term)term);
        }
        if (!owned) {
            settings->terms &= ~(1u << term);
        }
    }
    if (settings->max_depth <= 1) {
        settings->terms &= ~deep;
    }
    if ((settings->terms & deep) == 0 && settings->max_depth > 1) {
        settings->max_depth = 1;
    }
    if ((settings->terms & (deep | first)) == 0) {
        settings->max_depth = 0;
    }
}

/* A cumulative distribution over the lights that path is asked for at first events. */
static air_status choose_first_lights(air_path *path)
{
    const air_light_table *lights = &path->snapshot->lights;
    size_t owned = 0;
    float total = 0.0f, sum = 0.0f;
    path->first_lights = *lights;
    for (size_t i = 0; i < lights->count; i++) {
        if (owns_first(path, i)) {
            total += air_light_pick_probability(lights, (uint32_t)i);
            owned++;
        }
    }
    if (owned == lights->count) {
        return AIR_OK;
    }
    if (!(total > 0.0f)) {
        path->first_lights.count = 0;
        return AIR_OK;
    }
    path->first_cdf = air_allocate(path->snapshot->context, lights->count, sizeof(float));
    if (path->first_cdf == NULL) {
        return air_fail_memory(path->snapshot->context, "lights");
    }
    for (size_t i = 0; i < lights->count; i++) {
        sum += owns_first(path, i) ? air_light_pick_probability(lights, (uint32_t)i) : 0.0f;
        path->first_cdf[i] = sum / total;
    }
    path->first_lights.cdf = path->first_cdf;
    return AIR_OK;
}

air_status air_path_init(air_path *path, const air_snapshot *snapshot, const air_sobol *sobol,
                         const air_path_settings *settings)
{
    path->snapshot = snapshot;
    path->rays = air_context_ray_backend(snapshot->context);
    path->sobol = sobol;
    path->settings = *settings;
    path->first_cdf = NULL;
    path->emissive_media = false;
    for (size_t i = 0; i < snapshot->media.count; i++) {
        path->emissive_media =
            path->emissive_media || !vec3_is_zero(snapshot->media.media[i].emission);
    }
    path->pervious = false;
    for (size_t i = 0; i < snapshot->mesh_count; i++) {
        const uint32_t shadow = AIR_MASK_SHADOW_OPAQUE | AIR_MASK_SHADOW_ALPHA;
        path->pervious = path->pervious || (snapshot->meshes[i]->mask & shadow) == 0;
    }
    path->extended_lights = snapshot->lights.count > snapshot->lights.explicit_count;
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        const air_light_kind kind = snapshot->lights.entries[i].kind;
        path->extended_lights =
            path->extended_lights || kind == AIR_LIGHT_POLYGON || kind == AIR_LIGHT_ENVIRONMENT;
    }
    path->hittable_lights = path->emissive_media || any_emission(snapshot);
    const air_media *media = &snapshot->media;
    path->whole_volume = media->region_count == 1 && media->all_constant &&
                         media->regions[0].kind == AIR_REGION_CONVEX;
    if (path->whole_volume) {
        air_region_planes(&media->regions[0], &path->volume);
    }
    narrow_terms(path);
    return choose_first_lights(path);
}

void air_path_finish(air_path *path)
{
    if (path->snapshot != NULL) {
        air_free(path->snapshot->context, path->first_cdf);
        path->first_cdf = NULL;
    }
}

/* A stream for one purpose of the ray under way. The camera's ray has one of its own: a tracked ray
 * that leaves the surface must not repeat the numbers that let the camera's ray reach it. */
static air_rng ray_rng(const air_path_lane *lane, const path_walk *walk, uint32_t purpose)
{
    return air_sampler_rng(&lane->sampler, purpose + walk->depth * 2 + walk->branch);
}

/* ---- emitters that a ray meets ---- */

/* The share of the direct hit in the combination with next-event estimation. */
static float hit_weight(const air_path *path, const path_walk *walk, uint32_t entry,
                        float pdf_light)
{
    if (walk->pdf_dir == 0.0f) {
        return 1.0f;
    }
    if (!path_hittable(path, entry)) {
        return 0.0f; /* all of it comes by next-event estimation */
    }
    const air_light_table *lights = path_lights(path, walk->depth);
    const float pdf =
        lights->count > 0 ? pdf_light * air_light_pick_probability(lights, entry) : 0.0f;
    return walk->pdf_dir / (walk->pdf_dir + pdf);
}

static void add(air_path_lane *lane, air_term term, air_vec3 value)
{
    lane->terms[term] = vec3_add(lane->terms[term], value);
}

/* Emission seen directly is a term of its own; after events it belongs to theirs. */
static bool emission_term(const air_path *path, const path_walk *walk, uint32_t light_owner,
                          air_term seen, air_term *out)
{
    *out = walk->depth == 0 ? seen : path_term(walk);
    return walk->depth == 0 ? ((path->settings.terms >> seen) & 1u) != 0
                            : path_wanted(path, light_owner, walk->first_medium, *out);
}

static void add_environments(const air_path *path, const path_walk *walk, const air_ray *ray,
                             air_vec3 transmittance, air_path_lane *lane)
{
    const air_light_table *lights = &path->snapshot->lights;
    const air_vec3 dir = vec3_load(ray->dir);
    for (uint32_t k = 0; k < lights->environment_count; k++) {
        const uint32_t entry = lights->environments[k];
        const air_light *light = &lights->entries[entry];
        air_term term;
        if ((walk->depth == 0 && !light->camera_visible) ||
            !emission_term(path, walk, light->owner, AIR_TERM_BACKGROUND, &term)) {
            continue;
        }
        const float weight = hit_weight(path, walk, entry, air_environment_pdf(light, dir));
        const air_vec3 radiance = vec3_scale(air_environment_radiance(light, dir), weight);
        add(lane, term, vec3_mul(vec3_mul(walk->beta, transmittance), radiance));
    }
}

static void add_surface_emission(const air_path *path, const path_walk *walk, const air_ray *ray,
                                 const air_hit *hit, const air_surface *surface,
                                 air_vec3 transmittance, air_path_lane *lane)
{
    const air_light_table *lights = &path->snapshot->lights;
    const air_mesh *mesh = path->snapshot->meshes[hit->mesh];
    float weight = 1.0f;
    air_term term;
    if (vec3_is_zero(surface->emission) ||
        (walk->depth > 0 && path->snapshot->materials[mesh->material].unlit)) {
        return;
    }
    const uint32_t owner = (uint32_t)lights->explicit_count;
    if (!emission_term(path, walk, owner, AIR_TERM_EMISSION, &term)) {
        return;
    }
    if (surface->emitter != UINT32_MAX) {
        weight =
            hit_weight(path, walk, surface->emitter,
                       air_light_hit_pdf(lights, surface->emitter, vec3_load(ray->dir), hit->t));
    }
    const air_vec3 value = vec3_mul(vec3_mul(walk->beta, transmittance), surface->emission);
    add(lane, term, vec3_scale(value, weight));
}

/* The radiance of one polygon light that the ray crosses at t. */
static void add_polygon_light(const air_path *path, const path_walk *walk, uint32_t entry,
                              air_vec3 dir, float t, const air_ray_media *media,
                              air_path_lane *lane)
{
    const air_light_table *lights = &path->snapshot->lights;
    const air_light *light = &lights->entries[entry];
    const air_vec3 radiance = air_polygon_radiance(light, dir);
    air_term term;
    if (vec3_is_zero(radiance) ||
        !emission_term(path, walk, light->owner, AIR_TERM_EMISSION, &term)) {
        return;
    }
    air_rng rng = ray_rng(lane, walk, 0x30000u);
    const float weight = hit_weight(path, walk, entry, air_light_hit_pdf(lights, entry, dir, t));
    const air_vec3 transmittance = air_track_transmittance(media, t, &rng);
    const air_vec3 value = vec3_mul(vec3_mul(walk->beta, transmittance), radiance);
    add(lane, term, vec3_scale(value, weight));
}

/* Polygon lights stop nothing; each one the ray crosses adds its radiance. */
static void add_polygon_lights(const air_path *path, const path_walk *walk, const air_ray *ray,
                               float tmax, const air_ray_media *media, air_path_lane *lane)
{
    enum { MOST = 32 };
    const air_light_table *lights = &path->snapshot->lights;
    air_ray polygon_ray = *ray;
    air_hit hits[MOST];
    size_t count = MOST;
    polygon_ray.tmin = 0.0f;
    polygon_ray.tmax = tmax * 1.0001f; /* as far as shadow rays reach */
    polygon_ray.mask = UINT32_MAX;
    while (count == MOST) {
        count = path->rays->intersect_all(lights->visible_accelerator, &polygon_ray, hits, MOST);
        for (size_t i = 0; i < count; i++) {
            add_polygon_light(path, walk, lights->visible_entries[hits[i].mesh],
                              vec3_load(ray->dir), hits[i].t, media, lane);
            polygon_ray.tmin = hits[i].t;
        }
    }
}

static void add_media_emission(const air_path *path, const path_walk *walk,
                               const air_ray_media *media, air_path_lane *lane)
{
    const air_term term = walk->depth == 0 ? AIR_TERM_EMISSION : path_term(walk);
    if (!media->emits || ((path->settings.terms >> term) & 1u) == 0) {
        return;
    }
    bool varying = !media->closed;
    for (size_t i = 0; i < media->count; i++) {
        varying = varying || media->segments[i].exponential;
    }
    air_rng rng = ray_rng(lane, walk, 0x40000u);
    const air_vec3 radiance =
        varying ? air_track_emission(media, &rng) : air_ray_media_emission(media);
    add(lane, term, vec3_mul(walk->beta, radiance));
}

/* ---- events ---- */

static uint64_t media_of_regions(const air_media *media, uint64_t regions)
{
    uint64_t mask = 0;
    for (uint64_t rest = regions; rest != 0; rest &= rest - 1) {
        mask |= (uint64_t)1 << media->regions[__builtin_ctzll(rest)].medium;
    }
    return mask;
}

/* The media of a ray as callers see them. */
static size_t list_intervals(const air_ray_media *ray, air_media_interval *out)
{
    for (size_t i = 0; i < ray->count; i++) {
        const air_ray_segment *segment = &ray->segments[i];
        out[i] = (air_media_interval){segment->t0, segment->t1,
                                      media_of_regions(ray->media, segment->regions)};
    }
    return ray->count;
}

/* Throughput including the event, but for its direction: sigma_s where it was in a medium. */
static air_vec3 throughput_at(const air_path *path, const path_vertex *vertex)
{
    if (vertex->on_surface) {
        return vertex->walk.beta;
    }
    path_mixture mixture;
    air_vec3 sigma_s = vec3_set1(0.0f);
    path_mixture_make(path, vertex, &mixture);
    for (size_t i = 0; i < mixture.count; i++) {
        sigma_s = vec3_add(sigma_s, mixture.parts[i].sigma_s);
    }
    return vec3_mul(vertex->walk.beta, sigma_s);
}

static void call_hook(const air_path *path, const air_ray_media *ray, const air_path_lane *lane,
                      const path_vertex *vertex, float length)
{
    air_media_interval intervals[AIR_MAX_SEGMENTS];
    air_path_vertex out = {.intervals = intervals,
                           .interval_count = list_intervals(ray, intervals),
                           .segment_length = length,
                           .depth = vertex->walk.depth,
                           .on_surface = vertex->on_surface};
    vec3_store(out.dir_in, vec3_neg(vertex->wo));
    vec3_store(out.throughput, throughput_at(path, vertex));
    if (vertex->on_surface) {
        vec3_store(out.position, vertex->at.surface.position);
        vec3_store(out.normal, vertex->at.surface.bsdf.normal);
    } else {
        vec3_store(out.position, vertex->at.medium.position);
    }
    for (size_t i = 0; i < out.interval_count; i++) {
        if (length >= intervals[i].t0 && length <= intervals[i].t1) {
            out.media_mask = intervals[i].media_mask;
        }
    }
    path->settings.vertex_hook(path->settings.vertex_hook_user, lane->x, lane->y, lane->sample,
                               &out);
}

/* The vertex at which the next event will be written; the surface a ray ends on is made there at
 * once. */
static path_vertex *next_vertex(air_path_scratch *scratch)
{
    return &scratch->vertices[scratch->vertex_count];
}

static void push_surface(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                         air_vec3 weight, const air_ray *ray, float t, const air_path_lane *lane)
{
    path_vertex *vertex = next_vertex(scratch);
    scratch->vertex_count++;
    vertex->walk = *walk;
    vertex->walk.depth++;
    vertex->walk.beta = vec3_mul(walk->beta, weight);
    if (walk->depth == 0) {
        vertex->walk.branch = 0;
        vertex->walk.first_medium = AIR_NO_MEDIUM;
    }
    vertex->on_surface = true;
    vertex->ends = false;
    vertex->light_share = 1.0f;
    vertex->wo = vec3_neg(vec3_load(ray->dir));
    if (path->settings.vertex_hook != NULL) {
        call_hook(path, &scratch->media, lane, vertex, t);
    }
}

static path_vertex *push_medium(air_path_scratch *scratch, const path_walk *walk)
{
    path_vertex *vertex = next_vertex(scratch);
    scratch->vertex_count++;
    vertex->walk = *walk;
    vertex->walk.depth++;
    if (walk->depth == 0) {
        vertex->walk.branch = 1;
        vertex->walk.first_medium = AIR_NO_MEDIUM;
    }
    vertex->on_surface = false;
    vertex->ends = false;
    vertex->light_share = 1.0f;
    return vertex;
}

static void place_medium(const air_path *path, path_vertex *vertex, const air_ray_media *media,
                         size_t segment, float t, const air_path_lane *lane)
{
    vertex->wo = vec3_neg(media->dir);
    vertex->at.medium.position = vec3_madd(media->origin, t, media->dir);
    vertex->at.medium.regions = media->segments[segment].regions;
    if (path->settings.vertex_hook != NULL && !vertex->ends) {
        call_hook(path, media, lane, vertex, t);
    }
}

/* Draws the light of a medium event before its distance, so that the distance can follow it. False
 * if there is none to be asked. */
static bool draw_light(const air_path *path, path_vertex *vertex, const air_path_lane *lane)
{
    if (path_lights(path, vertex->walk.depth)->count == 0) {
        return false;
    }
    path_draw_light(path, lane, &vertex->walk, &vertex->at.medium.light,
                    &vertex->at.medium.light_probability);
    return true;
}

/* What a light from infinity would send along the ray under way, through its windows, if nothing
 * were in between; NULL if nothing. */
static const air_collimated_profile *light_profile(const air_path *path, air_path_scratch *scratch,
                                                   const air_light_point *point)
{
    enum { CAPACITY = AIR_COLLIMATED_MAX_PIECES + PATH_MOST_WINDOWS };
    const air_ray_media *media = &scratch->media;
    const air_light *light = &path->snapshot->lights.entries[point->entry];
    const air_ray_segment *segment = &media->segments[0];
    double origin[3], dir[3], to_light[3];
    vec3_store64(origin, media->origin);
    vec3_store64(dir, media->dir);
    vec3_store64(to_light, point->dir);
    air_collimated_profile *profile = &scratch->profile;
    *profile = (air_collimated_profile){.pieces = scratch->pieces[0], .capacity = CAPACITY};
    air_collimated_profile_make(&path->volume, to_light, (double)vec3_mean(segment->sigma_t),
                                origin, dir, (double)segment->t1, profile);
    if (light->window_count > 0 && profile->count > 0) {
        const air_collimated_profile whole = *profile;
        const size_t open = air_light_open_stretches(light, origin, dir, scratch->windows);
        profile->pieces = scratch->pieces[1];
        air_collimated_profile_restrict(&whole, scratch->windows, open, profile);
    }
    return profile->count > 0 ? profile : NULL;
}

/* Shares of the samples that follow the light; the rest is drawn by extinction. What a light from
 * infinity sends through media of one extinction in all channels is followed exactly. Only first
 * events follow it: the noise of later ones lies elsewhere (docs/decisions.md). */
#define EQUIANGULAR_SHARE        0.5f
#define WHOLE_VOLUME_SHARE_GREY  1.0f
#define WHOLE_VOLUME_SHARE_COLOR 0.5f

typedef enum light_use { LIGHT_NONE, LIGHT_ASKED, LIGHT_FOLLOWED } light_use;

/* How the vertex's light is used along this ray. */
static light_use use_light(const air_path *path, air_path_scratch *scratch,
                           const path_vertex *vertex, air_distance_guide *guide)
{
    const air_light_point *light = &vertex->at.medium.light;
    const air_light *entry = &path->snapshot->lights.entries[light->entry];
    *guide = (air_distance_guide){.point = &light->position, .share = EQUIANGULAR_SHARE};
    if (!light->infinite) {
        return LIGHT_FOLLOWED;
    }
    if (!light->delta || !path->whole_volume || vertex->walk.depth > 1 ||
        air_light_window_limit(entry) > PATH_MOST_WINDOWS) {
        return LIGHT_ASKED;
    }
    guide->point = NULL;
    guide->profile = light_profile(path, scratch, light);
    guide->share = scratch->media.grey ? WHOLE_VOLUME_SHARE_GREY : WHOLE_VOLUME_SHARE_COLOR;
    return guide->profile != NULL ? LIGHT_FOLLOWED : LIGHT_NONE;
}

static void place_closed(const air_path *path, path_vertex *vertex, const air_ray_media *media,
                         const path_walk *walk, const air_distance *distance, float weight,
                         const air_path_lane *lane)
{
    vertex->walk.beta = vec3_scale(vec3_mul(walk->beta, distance->weight), weight);
    place_medium(path, vertex, media, distance->segment, distance->t, lane);
}

/* A vertex beside another of the same event, at a distance that follows its light. */
static void push_lit(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                     float weight, const air_distance_guide *guide, float u, path_vertex *beside,
                     const air_path_lane *lane)
{
    path_vertex *lit = push_medium(scratch, walk);
    air_distance distance;
    lit->at.medium = beside->at.medium;
    lit->ends = true;
    beside->light_share = 0.0f;
    if (air_distance_sample(&scratch->media, walk->beta, guide, u, &distance)) {
        place_closed(path, lit, &scratch->media, walk, &distance, weight, lane);
    } else {
        scratch->vertex_count--;
    }
}

/* An event in the media of a closed ray. weight: the probability-compensated share of it that
 * scatters. The walk goes on from a distance drawn by extinction alone: if half of them were drawn
 * about the light, throughput would double with every event in dense media. Light worth following
 * is asked for there or at a distance of its own, by the balance heuristic. */
static void scatter_closed(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                           float weight, float u, const air_path_lane *lane)
{
    const air_ray_media *media = &scratch->media;
    path_vertex *vertex = push_medium(scratch, walk);
    air_distance_guide guide = {.share = 0.0f};
    const light_use use =
        draw_light(path, vertex, lane) ? use_light(path, scratch, vertex, &guide) : LIGHT_NONE;
    const bool followed = use == LIGHT_FOLLOWED, apart = followed && u < guide.share;
    air_distance distance;
    if (!air_distance_sample(media, walk->beta, followed && !apart ? &guide : NULL,
                             apart ? u / guide.share : u, &distance)) {
        scratch->vertex_count--;
        return;
    }
    vertex->light_share = use == LIGHT_NONE ? 0.0f : distance.extinction_share;
    distance.weight = vec3_scale(distance.weight, 1.0f / distance.extinction_share);
    place_closed(path, vertex, media, walk, &distance, weight, lane);
    if (apart) {
        push_lit(path, scratch, walk, weight, &guide, u, vertex, lane);
    }
}

static void scatter_tracked(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                            const air_collision *collision, const air_path_lane *lane)
{
    path_vertex *vertex = push_medium(scratch, walk);
    (void)draw_light(path, vertex, lane);
    vertex->walk.beta = vec3_mul(walk->beta, collision->weight);
    place_medium(path, vertex, &scratch->media, collision->segment, collision->t, lane);
}

/* Closed rays: the camera sample goes both ways, scattered and not; a later walk chooses, unless
 * nothing lies at the end. */
static void events_closed(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                          const air_ray *ray, bool met, float t, air_vec3 transmittance,
                          const air_path_lane *lane)
{
    const air_ray_media *media = &scratch->media;
    const uint32_t surface_terms = (1u << AIR_TERM_S0) | (1u << AIR_TERM_S_PLUS);
    const uint32_t medium_terms = (1u << AIR_TERM_M1) | (1u << AIR_TERM_M2);
    const bool scatters = media->scatters && vec3_max(media->depth) > 0.0f;
    if (walk->depth == 0) {
        if (met && (path->settings.terms & surface_terms) != 0) {
            push_surface(path, scratch, walk, transmittance, ray, t, lane);
        }
        if (scatters && (path->settings.terms & medium_terms) != 0) {
            scatter_closed(path, scratch, walk, 1.0f, lane->u_distance, lane);
        }
        return;
    }
    if (!scatters) {
        if (met) {
            push_surface(path, scratch, walk, transmittance, ray, t, lane);
        }
        return;
    }
    path_walk next = *walk;
    next.depth++;
    const float u = air_sampler_get(&lane->sampler, path_light_set(&next))[0];
    const float p = met ? air_distance_event_probability(media, walk->beta) : 1.0f;
    if (u < p) {
        scatter_closed(path, scratch, walk, 1.0f / p, u / p, lane);
    } else if (met) {
        push_surface(path, scratch, walk, vec3_scale(transmittance, 1.0f / (1.0f - p)), ray, t,
                     lane);
    }
}

static void events_tracked(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                           const air_ray *ray, bool met, float t, const air_path_lane *lane)
{
    air_rng rng = ray_rng(lane, walk, 0x20000u);
    const air_collision collision = air_track_collision(&scratch->media, walk->beta, &rng);
    if (collision.happened) {
        scatter_tracked(path, scratch, walk, &collision, lane);
    } else if (met) {
        push_surface(path, scratch, walk, collision.weight, ray, t, lane);
    }
}

static air_vec3 end_transmittance(const air_ray_media *media, bool emission_at_end, float tmax,
                                  const air_path_lane *lane, const path_walk *walk)
{
    if (media->closed) {
        return media->transmittance;
    }
    if (!emission_at_end) {
        return vec3_set1(0.0f);
    }
    air_rng rng = ray_rng(lane, walk, 0x50000u);
    return air_track_transmittance(media, tmax, &rng);
}

static void note_guides(const air_surface *surface, float t, air_path_lane *lane)
{
    lane->albedo = vec3_add(surface->bsdf.diffuse, surface->bsdf.f0);
    lane->normal = surface->bsdf.frame.n;
    lane->depth = t;
}

/* Can the ray bring anything: a further event, emission, guides? */
static bool matters(const air_path *path, const path_walk *walk, const air_hit *hit)
{
    const air_snapshot *snapshot = path->snapshot;
    if (walk->depth < path->settings.max_depth || path->emissive_media || path->settings.guides ||
        snapshot->lights.visible_accelerator != NULL) {
        return true;
    }
    if (hit->mesh == (uint32_t)AIR_NO_HIT) {
        return snapshot->lights.environment_count > 0;
    }
    const air_material *material = &snapshot->materials[snapshot->meshes[hit->mesh]->material];
    return material->unlit || !vec3_is_zero(material->emission);
}

/* Everything that happens along one ray: emission seen, then the next event. */
static void arrive(const air_path *path, air_path_scratch *scratch, size_t i, air_path_lane *lanes)
{
    const path_walk *walk = &scratch->walks[i];
    const air_ray *ray = &scratch->rays[i];
    const air_hit *hit = &scratch->hits[i];
    air_path_lane *lane = &lanes[walk->lane];
    const bool met = hit->mesh != (uint32_t)AIR_NO_HIT;
    const float t = met ? hit->t : AIR_FAR;
    if (!matters(path, walk, hit)) {
        return;
    }
    air_surface *surface = &next_vertex(scratch)->at.surface;
    air_ray_media *media = &scratch->media;
    air_ray_media_make(media, &path->snapshot->media, vec3_load(ray->origin), vec3_load(ray->dir),
                       t);
    if (met) {
        air_surface_make(path->snapshot, hit, vec3_load(ray->dir), surface);
        if (walk->depth == 0 && path->settings.guides) {
            note_guides(surface, t, lane);
        }
    }
    const bool emission_at_end =
        met ? !vec3_is_zero(surface->emission) : path->snapshot->lights.environment_count > 0;
    const air_vec3 transmittance = end_transmittance(media, emission_at_end, t, lane, walk);
    if (emission_at_end && met) {
        add_surface_emission(path, walk, ray, hit, surface, transmittance, lane);
    } else if (emission_at_end) {
        add_environments(path, walk, ray, transmittance, lane);
    }
    if (path->snapshot->lights.visible_accelerator != NULL) {
        add_polygon_lights(path, walk, ray, t, media, lane);
    }
    if (path->emissive_media) {
        add_media_emission(path, walk, media, lane);
    }
    if (walk->depth >= path->settings.max_depth) {
        return;
    }
    if (media->closed) {
        events_closed(path, scratch, walk, ray, met, t, transmittance, lane);
    } else {
        events_tracked(path, scratch, walk, ray, met, t, lane);
    }
}

/* ---- onward ---- */

/* Chooses a direction by the mixture of phase functions; false if nothing scatters. */
static bool sample_medium(const air_path *path, const path_vertex *vertex,
                          const path_mixture *mixture, air_f32x4 u, path_walk *walk, air_vec3 *dir)
{
    if (mixture->count == 0) {
        return false;
    }
    size_t chosen = 0;
    float rest = u[2];
    while (chosen + 1 < mixture->count && rest >= mixture->parts[chosen].share) {
        rest -= mixture->parts[chosen].share;
        chosen++;
    }
    const air_medium *media = path->snapshot->media.media;
    const uint32_t medium = mixture->parts[chosen].medium;
    float pdf = 0.0f;
    *dir = air_phase_sample(media[medium].phase, vec3_neg(vertex->wo), u[0], u[1], &pdf);
    if (mixture->count > 1) {
        pdf = 0.0f;
        for (size_t i = 0; i < mixture->count; i++) {
            pdf += mixture->parts[i].share *
                   phase_eval(media[mixture->parts[i].medium].phase, -vec3_dot(vertex->wo, *dir));
        }
    }
    /* One medium stands for the mixture, so that a walk belongs to one medium. */
    const air_vec3 weight =
        vec3_scale(mixture->parts[chosen].sigma_s, 1.0f / mixture->parts[chosen].share);
    walk->beta = vec3_mul(walk->beta, weight);
    walk->pdf_dir = pdf;
    if (walk->depth == 1) {
        walk->first_medium = medium;
    }
    return true;
}

static bool sample_surface(const path_vertex *vertex, air_f32x4 u, path_walk *walk, air_vec3 *dir)
{
    const float numbers[3] = {u[0], u[1], u[2]};
    air_vec3 weight;
    if (!air_bsdf_sample(&vertex->at.surface.bsdf, vertex->wo, numbers, dir, &weight,
                         &walk->pdf_dir)) {
        return false;
    }
    walk->beta = vec3_mul(walk->beta, weight);
    return true;
}

/* Below this throughput a walk survives with a probability in proportion to it. */
#define ROULETTE_THRESHOLD 0.25f

static bool survives(path_walk *walk, float u)
{
    const float q = vec3_max(walk->beta) * (1.0f / ROULETTE_THRESHOLD);
    if (q >= 1.0f) {
        return true;
    }
    if (u >= q) {
        return false;
    }
    walk->beta = vec3_scale(walk->beta, 1.0f / q);
    return true;
}

/* Light at the vertex, then the ray that leaves it. */
static void leave(const air_path *path, air_path_scratch *scratch, const path_vertex *vertex,
                  const air_path_lane *lanes)
{
    path_mixture mixture;
    mixture.count = 0;
    if (!vertex->on_surface) {
        path_mixture_make(path, vertex, &mixture);
        if (mixture.count == 0) {
            return;
        }
    }
    path_gather(path, scratch, lanes, vertex, &mixture);
    if (vertex->ends) {
        return;
    }
    path_walk walk = vertex->walk;
    if (walk.depth >= path->settings.max_depth && !path->hittable_lights) {
        return;
    }
    const air_f32x4 u = air_sampler_get(&lanes[walk.lane].sampler, path_direction_set(&walk));
    air_vec3 dir;
    const bool sampled = vertex->on_surface ? sample_surface(vertex, u, &walk, &dir)
                                            : sample_medium(path, vertex, &mixture, u, &walk, &dir);
    if (!sampled || !survives(&walk, u[3])) {
        return;
    }
    const air_vec3 origin = vertex->on_surface ? air_surface_origin(&vertex->at.surface, dir)
                                               : vertex->at.medium.position;
    const size_t i = scratch->walk_count++;
    scratch->walks[i] = walk;
    scratch->rays[i] = (air_ray){
        {origin.x, origin.y, origin.z}, 0.0f, {dir.x, dir.y, dir.z}, FLT_MAX, AIR_MASK_SCATTER};
}

static void start(air_path_scratch *scratch, air_path_lane *lanes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        air_path_lane *lane = &lanes[i];
        for (int term = 0; term < AIR_TERM_COUNT; term++) {
            lane->terms[term] = vec3_set1(0.0f);
        }
        lane->albedo = lane->normal = vec3_set1(0.0f);
        lane->depth = 0.0f;
        scratch->walks[i] = (path_walk){(uint32_t)i, 0, AIR_NO_MEDIUM, 0, vec3_set1(1.0f), 0.0f};
        scratch->rays[i] = (air_ray){{lane->origin.x, lane->origin.y, lane->origin.z},
                                     0.0f,
                                     {lane->dir.x, lane->dir.y, lane->dir.z},
                                     FLT_MAX,
                                     AIR_MASK_CAMERA};
    }
    scratch->walk_count = count;
}

void air_path_trace(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                    size_t count)
{
    start(scratch, lanes, count);
    while (scratch->walk_count > 0) {
        const size_t walks = scratch->walk_count;
        path_intersect(path, scratch, lanes, walks);
        for (size_t i = 0; i < walks && scratch->walks[i].depth == 0; i++) {
            lanes[i].hit = scratch->hits[i];
        }
        scratch->vertex_count = 0;
        for (size_t i = 0; i < walks; i++) {
            arrive(path, scratch, i, lanes);
        }
        scratch->walk_count = scratch->shadow_count = 0;
        for (size_t i = 0; i < scratch->vertex_count; i++) {
            leave(path, scratch, &scratch->vertices[i], lanes);
        }
        path_connect(path, scratch, lanes);
    }
}
