/* events.c: where on a ray the walk scatters, in a medium or on the surface at its end. */
#include <string.h>

#include "path/distance.h"
#include "path/tracking.h"
#include "path/vertex.h"

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

static void call_hook(const air_path *path, const air_ray_media *ray, air_path_lane *lane,
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

static path_vertex *push_surface(const air_path *path, air_path_scratch *scratch,
                                 const path_walk *walk, air_vec3 weight, const air_ray *ray,
                                 float t, air_path_lane *lane)
{
    path_vertex *vertex = path_next_vertex(scratch);
    scratch->vertex_count++;
    vertex->walk = *walk;
    vertex->walk.depth++;
    vertex->walk.beta = vec3_mul(walk->beta, weight);
    if (path_responds(path)) {
        vertex->walk.scattered = vec3_mul(walk->scattered, weight);
        path_respond_patch(path, scratch, ray, &vertex->at.surface, t, &vertex->walk, lane);
    }
    if (walk->depth == 0) {
        vertex->walk.branch = 0;
        vertex->walk.first_medium = AIR_NO_MEDIUM;
    }
    path_vertex_begin(vertex, true);
    vertex->wo = vec3_neg(vec3_load(ray->dir));
    if (path->settings.vertex_hook != NULL) {
        call_hook(path, &scratch->media, lane, vertex, t);
    }
    return vertex;
}

static path_vertex *push_medium(air_path_scratch *scratch, const path_walk *walk)
{
    path_vertex *vertex = path_next_vertex(scratch);
    scratch->vertex_count++;
    vertex->walk = *walk;
    vertex->walk.depth++;
    if (walk->depth == 0) {
        vertex->walk.branch = 1;
        vertex->walk.first_medium = AIR_NO_MEDIUM;
    }
    if (walk->received) {
        vertex->walk.branch = 1;
    }
    path_vertex_begin(vertex, false);
    return vertex;
}

static void place_medium(const air_path *path, path_vertex *vertex, const air_ray_media *media,
                         size_t segment, float t, air_path_lane *lane)
{
    vertex->wo = vec3_neg(media->dir);
    vertex->at.medium.position = vec3_madd(media->origin, t, media->dir);
    vertex->at.medium.regions = media->segments[segment].regions;
    if (path->settings.vertex_hook != NULL && !vertex->ends) {
        call_hook(path, media, lane, vertex, t);
    }
}

/* The event's light set was drawn from already. */
static void set_numbers(path_vertex *vertex, const air_f32x4 *numbers)
{
    vertex->numbered = true;
    memcpy(vertex->light_numbers, numbers, sizeof *numbers);
}

/* Draws the light of a medium event before its distance, so that the distance can follow it. False
 * if there is none to be asked. */
static bool draw_light(const air_path *path, path_vertex *vertex, air_path_lane *lane)
{
    if (vertex->walk.through) {
        vertex->at.medium.light = lane->through_light;
        vertex->at.medium.light_probability = lane->through_probability;
        return true;
    }
    if (path_lights(path, vertex->walk.depth, false)->count == 0 ||
        path_goes_through(path, &vertex->walk)) {
        return false;
    }
    path_draw_light(path, path_lights(path, vertex->walk.depth, false), lane, &vertex->walk,
                    path_light_numbers(vertex), &vertex->at.medium.light,
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

static bool first_event(const path_walk *walk) { return walk->depth == (walk->received ? 2u : 1u); }

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
    if (!light->delta || !path->whole_volume || !first_event(&vertex->walk) ||
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
                         air_path_lane *lane)
{
    vertex->walk.beta = vec3_scale(vec3_mul(walk->beta, distance->weight), weight);
    place_medium(path, vertex, media, distance->segment, distance->t, lane);
}

/* A vertex beside another of the same event, at a distance that follows its light. */
static void push_lit(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                     float weight, const air_distance_guide *guide, float u, path_vertex *beside,
                     air_path_lane *lane)
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
 * is asked for there or at a distance of its own, by the balance heuristic. numbers: of the light
 * set of the walk's next event, or NULL. */
static void scatter_closed(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                           float weight, float u, const air_f32x4 *numbers, air_path_lane *lane)
{
    const air_ray_media *media = &scratch->media;
    path_vertex *vertex = push_medium(scratch, walk);
    if (numbers != NULL && vertex->walk.branch == walk->branch) {
        set_numbers(vertex, numbers);
    }
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
                            const air_collision *collision, air_path_lane *lane)
{
    path_vertex *vertex = push_medium(scratch, walk);
    if (!draw_light(path, vertex, lane)) {
        vertex->light_share = 0.0f;
    }
    vertex->walk.beta = vec3_mul(walk->beta, collision->weight);
    place_medium(path, vertex, &scratch->media, collision->segment, collision->t, lane);
}

/* Closed rays: the camera sample goes both ways, scattered and not; a later walk chooses, unless
 * nothing lies at the end. */
static void events_closed(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                          const air_ray *ray, bool met, float t, air_vec3 transmittance,
                          air_path_lane *lane)
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
            scatter_closed(path, scratch, walk, 1.0f, lane->u_distance, NULL, lane);
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
    const air_f32x4 u = air_sampler_get(&lane->sampler, path_light_set(&next));
    const float p = met ? air_distance_event_probability(media, walk->beta) : 1.0f;
    if (u[0] < p) {
        scatter_closed(path, scratch, walk, 1.0f / p, u[0] / p, &u, lane);
    } else if (met) {
        set_numbers(push_surface(path, scratch, walk, vec3_scale(transmittance, 1.0f / (1.0f - p)),
                                 ray, t, lane),
                    &u);
    }
}

static void events_tracked(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                           const air_ray *ray, bool met, float t, air_path_lane *lane)
{
    const uint32_t surface_terms = (1u << AIR_TERM_S0) | (1u << AIR_TERM_S_PLUS);
    const bool ends = walk->depth > 0 || (path->settings.terms & surface_terms) != 0;
    air_rng rng = path_ray_rng(lane, walk, 0x20000u);
    if (walk->depth == 0 && path->passes_media) {
        if (met && ends) {
            const air_vec3 left = air_track_transmittance(&scratch->media, t, &rng);
            push_surface(path, scratch, walk, left, ray, t, lane);
        }
        return;
    }
    const air_collision collision = air_track_collision(&scratch->media, walk->beta, &rng);
    if (collision.happened) {
        scatter_tracked(path, scratch, walk, &collision, lane);
    } else if (met && ends) {
        push_surface(path, scratch, walk, collision.weight, ray, t, lane);
    }
}

/* Light that media scatter towards a walk that stays on surfaces: one point on the ray, drawn by
 * extinction, sends what the source says. */
static void gather_on_ray(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                          air_path_lane *lane)
{
    const air_ray_media *media = &scratch->media;
    path_vertex *vertex = push_medium(scratch, walk);
    vertex->gathers = vertex->ends = true;
    vertex->light_share = 0.0f;
    if (media->closed) {
        const float u = air_sampler_get(&lane->sampler, path_light_set(&vertex->walk))[0];
        air_distance distance;
        if (air_distance_sample(media, walk->beta, NULL, u, &distance)) {
            place_closed(path, vertex, media, walk, &distance, 1.0f, lane);
            return;
        }
    } else {
        air_rng rng = path_ray_rng(lane, walk, 0x20000u);
        const air_collision collision = air_track_collision(media, walk->beta, &rng);
        if (collision.happened) {
            vertex->walk.beta = vec3_mul(walk->beta, collision.weight);
            place_medium(path, vertex, media, collision.segment, collision.t, lane);
            return;
        }
    }
    scratch->vertex_count--;
}

void path_events(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                 const air_ray *ray, bool met, float t, air_vec3 transmittance, air_path_lane *lane)
{
    const air_ray_media *media = &scratch->media;
    if (path->settings.media == AIR_PATH_SCATTER) {
        if (media->closed) {
            events_closed(path, scratch, walk, ray, met, t, transmittance, lane);
        } else {
            events_tracked(path, scratch, walk, ray, met, t, lane);
        }
        return;
    }
    if (met) {
        push_surface(path, scratch, walk, transmittance, ray, t, lane);
        lane->first = walk->depth == 1 ? transmittance : lane->first;
    }
    const bool scatters = media->scatters && (!media->closed || vec3_max(media->depth) > 0.0f);
    if (path->settings.media == AIR_PATH_GATHER && path->settings.source.scattered != NULL &&
        scatters) {
        gather_on_ray(path, scratch, walk, lane);
    }
}

void path_arrive_through(const air_path *path, air_path_scratch *scratch, const path_walk *walk,
                         const air_ray *ray, float t, air_path_lane *lane)
{
    air_ray_media *media = &scratch->media;
    air_ray_media_make(media, path->media, vec3_load(ray->origin), vec3_load(ray->dir), t);
    if (!media->scatters || (media->closed && vec3_max(media->depth) == 0.0f)) {
        return;
    }
    const size_t first = scratch->vertex_count;
    if (media->closed) {
        const float u = air_sampler_get(&lane->sampler, path_through_set(walk))[3];
        scatter_closed(path, scratch, walk, 1.0f, u, NULL, lane);
    } else {
        air_rng rng = path_ray_rng(lane, walk, 0x60000u);
        const air_collision collision = air_track_collision(media, walk->beta, &rng);
        if (collision.happened) {
            scatter_tracked(path, scratch, walk, &collision, lane);
        }
    }
    for (size_t i = first; i < scratch->vertex_count; i++) {
        scratch->vertices[i].ends = true;
    }
}
