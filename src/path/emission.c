/* emission.c: emitters that a ray meets. */
#include "path/tracking.h"
#include "path/vertex.h"

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
    const air_light_table *lights = path_lights(path, walk->depth, walk->from_surface);
    const float pdf =
        lights->count > 0 ? pdf_light * air_light_pick_probability(lights, entry) : 0.0f;
    return path_share(walk->pdf_dir, pdf);
}

/* Adds light that comes along the walk's ray to what the walk brings back. */
static void add(air_path_lane *lane, const path_walk *walk, air_term term, air_vec3 light)
{
    lane->terms[term] = vec3_add(lane->terms[term], vec3_mul(walk->beta, light));
    if (!vec3_is_zero(walk->scattered)) {
        lane->terms[AIR_TERM_M2] =
            vec3_add(lane->terms[AIR_TERM_M2], vec3_mul(walk->scattered, light));
    }
}

/* Emission seen directly is a term of its own; after events it belongs to theirs. */
static bool emission_term(const air_path *path, const path_walk *walk, uint32_t light_owner,
                          air_term seen, air_term *out)
{
    *out = walk->depth == 0 ? seen : path_term(walk);
    if (path_goes_through(path, walk)) {
        return false;
    }
    const bool sharp = walk->depth == 1 && walk->pdf_dir == 0.0f;
    return walk->depth == 0 || sharp ? ((path->settings.terms >> *out) & 1u) != 0
                                     : path_wanted(path, light_owner, walk->first_medium, *out);
}

void path_add_environments(const air_path *path, const path_walk *walk, const air_ray *ray,
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
        add(lane, walk, term, vec3_mul(transmittance, radiance));
    }
}

void path_add_surface_emission(const air_path *path, const path_walk *walk, const air_ray *ray,
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
        weight = hit_weight(path, walk, surface->emitter,
                            air_light_hit_pdf(path_lights(path, walk->depth, walk->from_surface),
                                              surface->emitter, vec3_load(ray->origin),
                                              vec3_load(ray->dir), hit->t));
    }
    add(lane, walk, term, vec3_scale(vec3_mul(transmittance, surface->emission), weight));
}

/* The radiance of one polygon light that the ray crosses at t. */
static void add_polygon_light(const air_path *path, const path_walk *walk, uint32_t entry,
                              air_vec3 from, air_vec3 dir, float t, const air_ray_media *media,
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
    air_rng rng = path_ray_rng(lane, walk, 0x30000u);
    const float weight =
        hit_weight(path, walk, entry, air_light_hit_pdf(lights, entry, from, dir, t));
    const air_vec3 transmittance = air_track_transmittance(media, t, &rng);
    add(lane, walk, term, vec3_scale(vec3_mul(transmittance, radiance), weight));
}

/* Polygon lights stop nothing; each one the ray crosses adds its radiance. */
void path_add_polygon_lights(const air_path *path, const path_walk *walk, const air_ray *ray,
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
                              vec3_load(ray->origin), vec3_load(ray->dir), hits[i].t, media, lane);
            polygon_ray.tmin = hits[i].t;
        }
    }
}

void path_add_media_emission(const air_path *path, const path_walk *walk,
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
    air_rng rng = path_ray_rng(lane, walk, 0x40000u);
    const air_vec3 radiance =
        varying ? air_track_emission(media, &rng) : air_ray_media_emission(media);
    add(lane, walk, term, radiance);
}
