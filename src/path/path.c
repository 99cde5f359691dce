/* path.c: the walk: rays, what they see, where they go on. */
#include "path/path.h"

#include <float.h>

#include "core/phase.h"
#include "path/tracking.h"
#include "path/vertex.h"

size_t air_path_scratch_size(void) { return sizeof(air_path_scratch); }

static air_vec3 end_transmittance(const air_ray_media *media, bool needed, float tmax,
                                  const air_path_lane *lane, const path_walk *walk)
{
    if (media->closed) {
        return media->transmittance;
    }
    if (!needed) {
        return vec3_set1(0.0f);
    }
    air_rng rng = path_ray_rng(lane, walk, 0x50000u);
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

/* What the base of a surface reflects of light that it is known to get; its facets are left to the
 * walk. With a limit on events, and with responses, which follow walks from surface to surface,
 * only at the first surface. */
static void reflect_arrived(const air_path *path, const path_walk *walk, const air_hit *hit,
                            air_vec3 transmittance, air_vec3 dir, air_surface *surface,
                            air_path_lane *lane)
{
    const air_path_arrived *arrived = &path->settings.arrived;
    const bool deeper = path->settings.max_depth == UINT32_MAX && !path_responds(path);
    air_vec3 light[2];
    if (arrived->irradiance == NULL || path->settings.media == AIR_PATH_SCATTER ||
        !walk->received || !(walk->depth == 1 || deeper) ||
        !arrived->irradiance(arrived->user, hit, vec3_dot(surface->normal, dir) < 0.0f, light)) {
        return;
    }
    const air_vec3 base = air_bsdf_take_base(&surface->bsdf, vec3_neg(dir));
    const air_vec3 factor =
        vec3_scale(vec3_mul(vec3_mul(walk->beta, transmittance), base), 1.0f / AIR_PI_F);
    air_vec3 *plain = &lane->terms[AIR_TERM_S_PLUS], *scattered = &lane->terms[AIR_TERM_M2];
    *plain = vec3_add(*plain, vec3_mul(factor, light[0]));
    *scattered = vec3_add(*scattered, vec3_mul(factor, light[1]));
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
    if (walk->through) {
        path_arrive_through(path, scratch, walk, ray, t, lane);
        return;
    }
    if (!matters(path, walk, hit)) {
        return;
    }
    air_surface *surface = &path_next_vertex(scratch)->at.surface;
    air_ray_media *media = &scratch->media;
    air_ray_media_make(media, path->media, vec3_load(ray->origin), vec3_load(ray->dir), t);
    if (met) {
        air_surface_make(path->snapshot, hit, vec3_load(ray->dir), surface);
        if (walk->depth == 0 && path->settings.guides) {
            note_guides(surface, t, lane);
        }
    }
    const bool emission_at_end =
        met ? !vec3_is_zero(surface->emission) : path->snapshot->lights.environment_count > 0;
    const bool events_at_end = met && path->settings.media != AIR_PATH_SCATTER;
    const air_vec3 transmittance =
        end_transmittance(media, emission_at_end || events_at_end, t, lane, walk);
    if (emission_at_end && met) {
        path_add_surface_emission(path, walk, ray, hit, surface, transmittance, lane);
    } else if (emission_at_end) {
        path_add_environments(path, walk, ray, transmittance, lane);
    }
    if (path->snapshot->lights.visible_accelerator != NULL) {
        path_add_polygon_lights(path, walk, ray, t, media, lane);
    }
    if (path->emissive_media) {
        path_add_media_emission(path, walk, media, lane);
    }
    if (walk->depth >= path->settings.max_depth) {
        return;
    }
    if (met) {
        reflect_arrived(path, walk, hit, transmittance, vec3_load(ray->dir), surface, lane);
    }
    path_events(path, scratch, walk, ray, met, t, transmittance, lane);
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
    const air_medium *media = path->media->media;
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

static bool sample_surface(const air_path *path, const path_vertex *vertex, air_f32x4 u,
                           path_walk *walk, air_vec3 *dir)
{
    const float numbers[3] = {u[0], u[1], u[2]};
    const air_bsdf *bsdf = &vertex->at.surface.bsdf;
    air_vec3 weight;
    if (!air_bsdf_sample(bsdf, vertex->wo, numbers, dir, &weight, &walk->pdf_dir)) {
        return false;
    }
    if (path_responds(path)) {
        const float density = walk->pdf_dir > 0.0f ? 1.0f / (AIR_PI_F * walk->pdf_dir) : 0.0f;
        walk->flat =
            vec3_scale(vec3_mul(vec3_add(walk->beta, walk->scattered), bsdf->diffuse), density);
        walk->normal = bsdf->frame.n;
        walk->scattered = vec3_mul(walk->scattered, weight);
    }
    walk->beta = vec3_mul(walk->beta, weight);
    walk->dense *= air_bsdf_radiance_factor(bsdf, *dir);
    return true;
}

/* Below this throughput a walk survives with a probability in proportion to it. */
#define ROULETTE_THRESHOLD 0.25f

/* Where nothing else ends walks, one in a hundred does at each event after these. */
enum { ENDLESS_EVENTS = 64 };
#define ENDLESS_SURVIVAL 0.99f

static bool survives(const air_path *path, path_walk *walk, float u)
{
    const float most = vec3_max(vec3_add(walk->beta, walk->scattered)) / walk->dense;
    const bool tired = path->endless && walk->depth > ENDLESS_EVENTS;
    const float q = float_min(most * (1.0f / ROULETTE_THRESHOLD), tired ? ENDLESS_SURVIVAL : 1.0f);
    if (q >= 1.0f) {
        return true;
    }
    if (u >= q) {
        return false;
    }
    walk->beta = vec3_scale(walk->beta, 1.0f / q);
    walk->scattered = vec3_scale(walk->scattered, 1.0f / q);
    walk->flat = vec3_scale(walk->flat, 1.0f / q);
    return true;
}

/* What the source says that a point of media sends along the walk. */
static void add_source(const air_path *path, const path_vertex *vertex, const path_mixture *mixture,
                       air_path_lane *lane)
{
    const air_path_source *source = &path->settings.source;
    const bool lights = !source->through || vertex->walk.depth > 2;
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < mixture->count; i++) {
        const air_vec3 scattered = source->scattered(source->user, vertex->at.medium.position,
                                                     mixture->parts[i].medium, vertex->wo, lights);
        sum = vec3_add(sum, vec3_mul(mixture->parts[i].sigma_s, scattered));
    }
    air_vec3 *term = &lane->terms[AIR_TERM_M2];
    *term = vec3_add(*term, vec3_mul(vertex->walk.beta, sum));
}

/* Draws the direction of the ray that leaves a receiver; what comes along it is weighted by one
 * over its density when the walk has ended, so that throughput starts at 1. */
static bool sample_receiver(air_f32x4 u, path_walk *walk, air_vec3 *dir, air_path_lane *lane)
{
    lane->left = air_receiver_sample(lane->receiver, u, dir, &walk->pdf_dir);
    lane->dir = *dir;
    return lane->left;
}

/* Light at the vertex, then the ray that leaves it. */
static void leave(const air_path *path, air_path_scratch *scratch, const path_vertex *vertex,
                  air_path_lane *lanes)
{
    path_mixture mixture;
    mixture.count = 0;
    if (vertex->on_surface && !vertex->receives && air_bsdf_is_black(&vertex->at.surface.bsdf)) {
        return;
    }
    if (!vertex->on_surface) {
        path_mixture_make(path, vertex, &mixture);
        if (mixture.count == 0) {
            return;
        }
    }
    /* early, so that it is worked out beside the light */
    const air_f32x4 u =
        air_sampler_get(&lanes[vertex->walk.lane].sampler, path_direction_set(&vertex->walk));
    path_gather(path, scratch, lanes, vertex, &mixture);
    if (vertex->gathers && path->settings.source.scattered != NULL) {
        add_source(path, vertex, &mixture, &lanes[vertex->walk.lane]);
    }
    if (vertex->ends) {
        return;
    }
    if (vertex->receives && path->settings.source.through) {
        path_ask_through(path, scratch, lanes, vertex);
    }
    path_walk walk = vertex->walk;
    if (walk.depth >= path->settings.max_depth && !path->hittable_lights) {
        return;
    }
    air_vec3 dir;
    const bool sampled = vertex->receives ? sample_receiver(u, &walk, &dir, &lanes[walk.lane])
                         : vertex->on_surface
                             ? sample_surface(path, vertex, u, &walk, &dir)
                             : sample_medium(path, vertex, &mixture, u, &walk, &dir);
    if (!sampled || !survives(path, &walk, u[3])) {
        return;
    }
    walk.from_surface = vertex->on_surface;
    const air_vec3 origin = vertex->on_surface ? air_surface_origin(&vertex->at.surface, dir)
                                               : vertex->at.medium.position;
    const size_t i = scratch->walk_count++;
    scratch->walks[i] = walk;
    scratch->rays[i] = (air_ray){
        {origin.x, origin.y, origin.z}, 0.0f, {dir.x, dir.y, dir.z}, FLT_MAX, AIR_MASK_SCATTER};
}

static void clear(air_path_lane *lane)
{
    for (int term = 0; term < AIR_TERM_COUNT; term++) {
        lane->terms[term] = vec3_set1(0.0f);
    }
    lane->albedo = lane->normal = vec3_set1(0.0f);
    lane->depth = 0.0f;
    lane->hit.mesh = (uint32_t)AIR_NO_HIT;
}

static void start(air_path_scratch *scratch, air_path_lane *lanes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        air_path_lane *lane = &lanes[i];
        clear(lane);
        scratch->walks[i] = (path_walk){.lane = (uint32_t)i,
                                        .first_medium = AIR_NO_MEDIUM,
                                        .beta = vec3_set1(1.0f),
                                        .dense = 1.0f};
        scratch->rays[i] = (air_ray){{lane->origin.x, lane->origin.y, lane->origin.z},
                                     0.0f,
                                     {lane->dir.x, lane->dir.y, lane->dir.z},
                                     FLT_MAX,
                                     AIR_MASK_CAMERA};
    }
    scratch->walk_count = count;
}

/* From vertices to the rays that leave them. */
static void leave_all(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes)
{
    scratch->walk_count = scratch->shadow_count = 0;
    for (size_t i = 0; i < scratch->vertex_count; i++) {
        leave(path, scratch, &scratch->vertices[i], lanes);
    }
    path_connect(path, scratch, lanes);
}

/* Walks until none is left. first: the depth of walks whose hits are the lanes'. */
static void walk_on(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                    uint32_t first)
{
    while (scratch->walk_count > 0) {
        const size_t walks = scratch->walk_count;
        path_intersect(path, scratch, lanes, walks);
        for (size_t i = 0; i < walks && scratch->walks[i].depth == first; i++) {
            if (!scratch->walks[i].through) {
                lanes[scratch->walks[i].lane].hit = scratch->hits[i];
            }
        }
        scratch->vertex_count = 0;
        for (size_t i = 0; i < walks; i++) {
            arrive(path, scratch, i, lanes);
        }
        leave_all(path, scratch, lanes);
    }
}

void air_path_trace(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                    size_t count)
{
    start(scratch, lanes, count);
    walk_on(path, scratch, lanes, 0);
}

air_vec3 air_path_view_transmittance(const air_path *path, air_path_scratch *scratch,
                                     const air_path_lane *lane)
{
    const path_walk walk = {.first_medium = AIR_NO_MEDIUM};
    const float t = lane->hit.mesh != (uint32_t)AIR_NO_HIT ? lane->hit.t : AIR_FAR;
    air_ray_media_make(&scratch->media, path->media, lane->origin, lane->dir, t);
    return end_transmittance(&scratch->media, true, t, lane, &walk);
}

static void receive(path_vertex *vertex, size_t i, air_path_lane *lane)
{
    const air_path_receiver *receiver = lane->receiver;
    clear(lane);
    lane->left = false;
    lane->connected = lane->through = lane->first = vec3_set1(0.0f);
    lane->lit_share = 0.0f;
    lane->origin = receiver->position;
    vertex->walk = (path_walk){.lane = (uint32_t)i,
                               .depth = 1,
                               .first_medium = AIR_NO_MEDIUM,
                               .received = true,
                               .beta = vec3_set1(1.0f),
                               .dense = 1.0f};
    path_vertex_begin(vertex, true);
    vertex->receives = true;
    vertex->at.surface.position = receiver->position;
    vertex->at.surface.normal = receiver->geometric;
    vertex->at.surface.offset = receiver->sphere ? 0.0f : receiver->offset;
}

void air_path_receive(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                      size_t count)
{
    for (size_t i = 0; i < count; i++) {
        receive(&scratch->vertices[i], i, &lanes[i]);
    }
    scratch->vertex_count = count;
    leave_all(path, scratch, lanes);
    walk_on(path, scratch, lanes, 1);
}
