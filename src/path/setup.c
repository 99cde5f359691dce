/* setup.c: what of a scene a path tracer is asked for, found once before the samples. */
#include "path/path.h"

#include <string.h>

static bool any_emission(const air_snapshot *snapshot)
{
    for (size_t i = 0; i < snapshot->material_count; i++) {
        if (!vec3_is_zero(snapshot->materials[i].emission)) {
            return true;
        }
    }
    return snapshot->lights.environment_count > 0 || snapshot->lights.visible_accelerator != NULL;
}

static bool any_sharp(const air_snapshot *snapshot)
{
    for (size_t i = 0; i < snapshot->material_count; i++) {
        const air_material *material = &snapshot->materials[i];
        if (material->transmission > 0.0f || (material->model != AIR_MATERIAL_METALLIC_ROUGHNESS &&
                                              air_facets_smooth(&material->optics.facets))) {
            return true;
        }
    }
    return false;
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
    const uint32_t scattered = ((1u << AIR_TERM_M1) | (1u << AIR_TERM_M2)) & settings->terms;
    for (unsigned term = AIR_TERM_S0; term <= AIR_TERM_M2; term++) {
        bool owned = snapshot->lights.owner_count == 0 || path->emissive_media ||
                     (term == AIR_TERM_S0 && path->sharp);
        for (size_t owner = 0; owner < snapshot->lights.owner_count; owner++) {
            owned = owned || owns(settings, path->media->count, owner, (air_term)term);
        }
        if (!owned) {
            settings->terms &= ~(1u << term);
        }
    }
    path->passes_media = scattered != 0 && (settings->terms & scattered) == 0;
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

/* Is an entry asked for by vertices of one sort? */
static bool is_asked(const air_path *path, size_t entry, bool first, bool on_surface)
{
    const air_light *light = &path->snapshot->lights.entries[entry];
    const bool met = light->kind == AIR_LIGHT_ENVIRONMENT && light->environment == NULL &&
                     light->casts_shadow && !path->pervious;
    return (!first || owns_first(path, entry)) && !(on_surface && met);
}

/* A table over the lights that vertices of one sort ask. */
static air_status choose_lights(air_path *path, bool first, bool on_surface)
{
    const air_light_table *lights = &path->snapshot->lights;
    air_light_table *out = &path->lights[first][on_surface];
    size_t asked = 0;
    float total = 0.0f, sum = 0.0f;
    *out = *lights;
    /* responses follow the way to the light point itself */
    out->spheres_by_sight = path->settings.respond.patch == NULL;
    out->spheres_unplaced = on_surface; /* only distances follow places */
    for (size_t i = 0; i < lights->count; i++) {
        if (is_asked(path, i, first, on_surface)) {
            total += air_light_pick_probability(lights, (uint32_t)i);
            asked++;
        }
    }
    if (asked == lights->count) {
        return AIR_OK;
    }
    if (!(total > 0.0f)) {
        out->count = 0;
        return AIR_OK;
    }
    float *cdf = air_allocate(path->snapshot->context, lights->count, sizeof *cdf);
    if (cdf == NULL) {
        return air_fail_memory(path->snapshot->context, "lights");
    }
    for (size_t i = 0; i < lights->count; i++) {
        sum += is_asked(path, i, first, on_surface)
                   ? air_light_pick_probability(lights, (uint32_t)i)
                   : 0.0f;
        cdf[i] = sum / total;
    }
    out->cdf = path->cdfs[first][on_surface] = cdf;
    return AIR_OK;
}

static air_status choose_all_lights(air_path *path)
{
    air_status status = AIR_OK;
    for (int i = 0; i < 4 && status == AIR_OK; i++) {
        status = choose_lights(path, (i & 1) != 0, (i & 2) != 0);
    }
    if (status != AIR_OK) {
        air_path_finish(path);
    }
    return status;
}

static const air_media no_media = {.all_constant = true};

/* Do walks never leave a medium, and lose nothing in it? */
static bool is_endless(const air_medium *medium)
{
    const air_vec3 sigma_a = vec3_sub(medium->sigma_t, medium->sigma_s);
    return isinf(medium->bounds_max[0]) && air_medium_is_constant(medium) &&
           vec3_min(sigma_a) <= 0.0f && !vec3_is_zero(medium->sigma_s);
}

air_status air_path_init(air_path *path, const air_snapshot *snapshot, const air_sobol *sobol,
                         const air_path_settings *settings)
{
    path->snapshot = snapshot;
    path->media = settings->media == AIR_PATH_IGNORE ? &no_media : &snapshot->media;
    path->rays = air_context_ray_backend(snapshot->context);
    path->sobol = sobol;
    path->settings = *settings;
    memset(path->cdfs, 0, sizeof path->cdfs);
    path->emissive_media = path->endless = false;
    for (size_t i = 0; i < path->media->count; i++) {
        const air_medium *medium = &path->media->media[i];
        path->emissive_media = path->emissive_media || !vec3_is_zero(medium->emission);
        path->endless = path->endless || is_endless(medium);
    }
    path->pervious = false;
    for (size_t i = 0; i < snapshot->mesh_count; i++) {
        const uint32_t shadow = AIR_MASK_SHADOW_OPAQUE | AIR_MASK_SHADOW_ALPHA;
        const uint32_t mask = snapshot->meshes[i]->mask;
        path->pervious = path->pervious || (mask != 0 && (mask & shadow) == 0);
    }
    path->extended_lights = snapshot->lights.count > snapshot->lights.explicit_count;
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        const air_light_kind kind = snapshot->lights.entries[i].kind;
        path->extended_lights =
            path->extended_lights || kind == AIR_LIGHT_POLYGON || kind == AIR_LIGHT_ENVIRONMENT;
    }
    path->hittable_lights = path->emissive_media || any_emission(snapshot);
    path->sharp = any_sharp(snapshot);
    const air_media *media = path->media;
    path->whole_volume = media->region_count == 1 && media->all_constant &&
                         media->regions[0].kind == AIR_REGION_CONVEX;
    if (path->whole_volume) {
        air_region_planes(&media->regions[0], &path->volume);
    }
    narrow_terms(path);
    return choose_all_lights(path);
}

void air_path_finish(air_path *path)
{
    if (path->snapshot != NULL) {
        for (int i = 0; i < 4; i++) {
            air_free(path->snapshot->context, path->cdfs[i & 1][i >> 1]);
            path->cdfs[i & 1][i >> 1] = NULL;
        }
    }
}
