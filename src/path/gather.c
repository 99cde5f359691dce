/* gather.c: next-event estimation: one light per vertex, by power. */
#include <float.h>
#include <string.h>

#include "core/phase.h"
#include "path/tracking.h"
#include "path/vertex.h"

void path_mixture_make(const air_path *path, const path_vertex *vertex, path_mixture *out)
{
    const air_media *media = path->media;
    out->count = 0;
    out->total = 0.0f;
    for (uint64_t rest = vertex->at.medium.regions; rest != 0; rest &= rest - 1) {
        const air_region *region = &media->regions[__builtin_ctzll(rest)];
        const air_vec3 sigma_s = region->constant
                                     ? region->sigma_s
                                     : air_medium_coefficients(&media->media[region->medium],
                                                               region, vertex->at.medium.position)
                                           .sigma_s;
        const float share = vec3_dot(vertex->walk.beta, sigma_s);
        if (share > 0.0f) {
            out->parts[out->count].medium = region->medium;
            out->parts[out->count].sigma_s = sigma_s;
            out->parts[out->count].share = share;
            out->total += share;
            out->count++;
        }
    }
    for (size_t i = 0; i < out->count; i++) {
        out->parts[i].share /= out->total;
    }
}

air_vec3 path_mixture_eval(const air_path *path, const path_vertex *vertex,
                           const path_mixture *mixture, air_vec3 wi, uint32_t light_owner,
                           float *out_pdf)
{
    const path_walk *walk = &vertex->walk;
    const float cosine = -vec3_dot(vertex->wo, wi);
    air_vec3 sum = vec3_set1(0.0f);
    float pdf = 0.0f;
    for (size_t i = 0; i < mixture->count; i++) {
        const uint32_t medium = mixture->parts[i].medium;
        const float phase = phase_eval(path->media->media[medium].phase, cosine);
        const uint32_t first = walk->depth == 1 ? medium : walk->first_medium;
        pdf += mixture->parts[i].share * phase;
        if (path_wanted(path, light_owner, first, path_term(walk))) {
            sum = vec3_madd(sum, phase, mixture->parts[i].sigma_s);
        }
    }
    if (out_pdf != NULL) {
        *out_pdf = pdf;
    }
    return sum;
}

/* f cos (surfaces) or sigma_s times phase (media) towards wi; receivers take radiance as it is. */
static air_vec3 scatter_eval(const air_path *path, const path_vertex *vertex,
                             const path_mixture *mixture, const air_path_lane *lane, air_vec3 wi,
                             uint32_t light_owner, float *out_pdf)
{
    const path_walk *walk = &vertex->walk;
    if (vertex->receives) {
        const float pdf = air_receiver_sample_pdf(lane->receiver, wi);
        if (out_pdf != NULL) {
            *out_pdf = pdf;
        }
        return vec3_set1(pdf > 0.0f ? 1.0f : 0.0f);
    }
    if (!vertex->on_surface) {
        return path_mixture_eval(path, vertex, mixture, wi, light_owner, out_pdf);
    }
    if (!path_wanted(path, light_owner, walk->first_medium, path_term(walk))) {
        return vec3_set1(0.0f);
    }
    const air_bsdf *bsdf = &vertex->at.surface.bsdf;
    if (out_pdf != NULL) {
        *out_pdf = air_bsdf_sample_pdf(bsdf, vertex->wo, wi);
    }
    return air_bsdf_eval(bsdf, vertex->wo, wi);
}

bool path_attenuate_closed(const air_path *path, air_path_scratch *scratch, const air_ray *ray,
                           float distance, air_vec3 *value)
{
    const air_media *media = path->media;
    const air_vec3 origin = vec3_load(ray->origin), dir = vec3_load(ray->dir);
    if (media->all_constant) {
        if (media->region_count > 0) {
            *value = vec3_mul(*value, air_constant_transmittance(media, origin, dir, distance));
        }
        return true;
    }
    air_ray_media_make(&scratch->media, media, origin, dir, distance);
    if (scratch->media.closed) {
        *value = vec3_mul(*value, scratch->media.transmittance);
    }
    return scratch->media.closed;
}

bool path_attenuate(const air_path *path, air_path_scratch *scratch, const air_ray *ray,
                    float distance, air_vec3 *value)
{
    /* crossings of meshes cost as much as the ray: it may not arrive */
    return path->media->boundary_accelerator == NULL &&
           path_attenuate_closed(path, scratch, ray, distance, value);
}

/* From a surface rays start beside the place that the connection was made for, which at the rim of
 * a sphere is enough to meet it far before: the ray is aimed anew at where the connection ends. */
static void aim_anew(const path_vertex *vertex, const air_connection *connection, air_ray *ray)
{
    const air_vec3 end =
        vec3_madd(vertex->at.surface.position, connection->distance, connection->dir);
    const air_vec3 way = vec3_sub(end, vec3_load(ray->origin));
    const float length = vec3_length(way);
    if (length > 0.0f) {
        vec3_store(ray->dir, vec3_scale(way, 1.0f / length));
        ray->tmax = length;
    }
}

air_ray path_shadow_ray(const path_vertex *vertex, const air_connection *connection,
                        const air_light_point *light)
{
    air_ray ray;
    const air_vec3 origin = vertex->on_surface
                                ? air_surface_origin(&vertex->at.surface, connection->dir)
                                : vertex->at.medium.position;
    ray.tmin = 0.0f;
    vec3_store(ray.origin, origin);
    vec3_store(ray.dir, connection->dir);
    /* Short of area lights by more than their own triangles' rounding. */
    ray.tmax = isinf(connection->distance) ? FLT_MAX : connection->distance;
    if (light->curved && vertex->on_surface) {
        aim_anew(vertex, connection, &ray);
    }
    if (!light->delta && !light->infinite) {
        ray.tmax *= 0.9999f;
    }
    ray.mask = AIR_MASK_SHADOW_OPAQUE;
    return ray;
}

/* Lights without extent need no numbers for a point, and the first medium event has its own for the
 * choice. */
void path_draw_light(const air_path *path, const air_light_table *lights, const air_path_lane *lane,
                     const path_walk *walk, const float *known, air_light_point *out_point,
                     float *out_probability)
{
    const bool first_in_medium = walk->depth == 1 && walk->branch == 1;
    air_f32x4 u = {0.0f, 0.0f, 0.0f, 0.0f};
    float rest;
    if (known != NULL) {
        memcpy(&u, known, sizeof u);
    } else if (path->extended_lights || (lights->count > 1 && !first_in_medium)) {
        u = air_sampler_get(&lane->sampler, path_light_set(walk));
    }
    const float pick = first_in_medium ? lane->u_pick : u[1];
    const uint32_t entry = air_light_pick(lights, pick, out_probability, &rest);
    air_light_sample(lights, entry, u[2], u[3], out_point);
}

/* What a throughput of 1 gets through a connection if nothing is in between; combined with the
 * chance of meeting the light by a sampled direction where there is one: not behind an event that
 * is asked for through media, from which nothing goes on. */
static air_vec3 connection_value(const air_path *path, const path_vertex *vertex,
                                 const path_mixture *mixture, const air_path_lane *lane,
                                 const air_light_point *light, const air_connection *connection,
                                 float probability)
{
    const uint32_t owner = path->snapshot->lights.entries[light->entry].owner;
    const bool shared = !light->delta && !vertex->walk.through && path_hittable(path, light->entry);
    float pdf_dir = 0.0f;
    const air_vec3 f =
        scatter_eval(path, vertex, mixture, lane, connection->dir, owner, shared ? &pdf_dir : NULL);
    const float pdf = connection->pdf * probability;
    if (!(pdf > 0.0f)) {
        return vec3_set1(0.0f);
    }
    return vec3_scale(vec3_mul(f, connection->incident),
                      vertex->light_share * path_share(pdf, pdf_dir) / pdf);
}

static uint32_t target_of(const path_vertex *vertex)
{
    return vertex->receives       ? (uint32_t)PATH_TO_RECEIVER
           : vertex->walk.through ? (uint32_t)PATH_THROUGH
                                  : (uint32_t)path_term(&vertex->walk);
}

/* Is a direction on the side of the surface from which it gets light? */
static bool faces(const path_vertex *vertex, const air_path_lane *lane, air_vec3 dir)
{
    if (vertex->receives) {
        return lane->receiver->sphere || vec3_dot(lane->receiver->geometric, dir) > 0.0f;
    }
    return vec3_dot(vertex->at.surface.bsdf.normal, dir) > 0.0f;
}

/* Behind a lamp with an area there is no light of its own, but of the media that it lights. */
static bool look_from_behind(const air_path *path, const path_vertex *vertex,
                             const air_light_point *light, air_vec3 position, air_connection *out)
{
    const air_vec3 way = vec3_sub(light->position, position);
    const float distance = vec3_length(way);
    if (!path_responds(path) || !vertex->on_surface || light->delta || light->infinite ||
        !(distance > 0.0f)) {
        return false;
    }
    *out = (air_connection){.dir = vec3_scale(way, 1.0f / distance), .distance = distance};
    return true;
}

void path_gather(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                 const path_vertex *vertex, const path_mixture *mixture)
{
    const path_walk *walk = &vertex->walk;
    air_path_lane *lane = &lanes[walk->lane];
    const air_light_table *lights = path_lights(path, walk->depth, vertex->on_surface);
    if (lights->count == 0 || vertex->light_share == 0.0f) {
        return;
    }
    air_light_point drawn;
    const air_light_point *light = &drawn;
    float probability = vertex->at.medium.light_probability;
    air_vec3 position = vertex->at.medium.position;
    if (vertex->on_surface) {
        path_draw_light(path, lights, lane, walk, path_light_numbers(vertex), &drawn, &probability);
        position = vertex->at.surface.position;
    } else {
        light = &vertex->at.medium.light;
    }
    air_connection connection;
    air_vec3 light_here = vec3_set1(0.0f);
    if (air_light_connect(lights, light, position, &connection)) {
        light_here = connection_value(path, vertex, mixture, lane, light, &connection, probability);
    } else if (!look_from_behind(path, vertex, light, position, &connection)) {
        return;
    }
    path_shadow shadow = {.lane = walk->lane,
                          .target = target_of(vertex),
                          .stream = path_direction_set(walk),
                          .distance = connection.distance};
    if (vec3_is_zero(light_here) && !path_responds(path)) {
        return;
    }
    if (vertex->receives) {
        lane->connected_dir = connection.dir;
    }
    if (vertex->on_surface && path_responds(path) && faces(vertex, lane, connection.dir) &&
        (vertex->receives || !vec3_is_zero(vertex->at.surface.bsdf.diffuse))) {
        path_respond_light(path, scratch, vertex, light, &connection, probability, lane, &shadow);
    }
    air_ray ray = path_shadow_ray(vertex, &connection, light);
    shadow.late = !path_attenuate(path, scratch, &ray, connection.distance, &light_here);
    shadow.value = vec3_mul(walk->beta, light_here);
    shadow.carried = vec3_mul(walk->scattered, light_here);
    if (vec3_is_zero(shadow.value) && vec3_is_zero(shadow.scattered) &&
        vec3_is_zero(shadow.carried) && !shadow.lit) {
        return;
    }
    if (!lights->entries[light->entry].casts_shadow) {
        ray.mask = 0;
    }
    scratch->shadows[scratch->shadow_count] = shadow;
    scratch->shadow_rays[scratch->shadow_count++] = ray;
}
