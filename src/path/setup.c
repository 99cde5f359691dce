/* setup.c: what of a scene a path tracer is asked for, found once before the samples. */
#include "path/path.h"

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
    const size_t media = path->media->count;
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
            owned = owned || owns(settings, path->media->count, owner, (air_term)term);
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

static const air_media no_media = {.all_constant = true};

air_status air_path_init(air_path *path, const air_snapshot *snapshot, const air_sobol *sobol,
                         const air_path_settings *settings)
{
    path->snapshot = snapshot;
    path->media = settings->media == AIR_PATH_IGNORE ? &no_media : &snapshot->media;
    path->rays = air_context_ray_backend(snapshot->context);
    path->sobol = sobol;
    path->settings = *settings;
    path->first_cdf = NULL;
    path->emissive_media = false;
    for (size_t i = 0; i < path->media->count; i++) {
        path->emissive_media =
            path->emissive_media || !vec3_is_zero(path->media->media[i].emission);
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
    const air_media *media = path->media;
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
