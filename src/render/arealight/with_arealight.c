#include "render/arealight/with_arealight.h"

#include <stdio.h>

#include "render/arealight/lamps.h"
#include "render/method.h"

/* ---- where it applies ---- */

/* More would cost more than they are worth: every sample asks all of them. */
enum { MOST_LAMPS = 256, MOST_TRIANGLES = 65536 };

static bool media_apply(const air_snapshot *snapshot, char reason[AIR_METHOD_REASON])
{
    const air_media *media = &snapshot->media;
    for (size_t r = 0; r < media->region_count; r++) {
        if (!media->regions[r].constant) {
            snprintf(reason, AIR_METHOD_REASON, "medium \"%.60s\" is not of constant density",
                     media->media[media->regions[r].medium].name);
            return false;
        }
    }
    return true;
}

static bool emitters_are_few(const air_snapshot *snapshot, char reason[AIR_METHOD_REASON])
{
    const size_t triangles = snapshot->lights.count - snapshot->lights.explicit_count;
    size_t lamps;
    if (triangles > MOST_TRIANGLES) {
        snprintf(reason, AIR_METHOD_REASON, "its %zu triangles are more than %d", triangles,
                 (int)MOST_TRIANGLES);
        return false;
    }
    if (air_area_lamps_count_emitters(snapshot, &lamps) != AIR_OK) {
        snprintf(reason, AIR_METHOD_REASON, "out of memory");
        return false;
    }
    if (lamps > MOST_LAMPS) {
        snprintf(reason, AIR_METHOD_REASON,
                 "its %zu triangles make %zu flat convex lamps, more than %d", triangles, lamps,
                 (int)MOST_LAMPS);
        return false;
    }
    return true;
}

/* Emissive meshes are one light to the owner table. */
static bool emitters_apply(const air_snapshot *snapshot, char reason[AIR_METHOD_REASON])
{
    const air_light_table *lights = &snapshot->lights;
    for (size_t i = lights->explicit_count; i < lights->count; i++) {
        if (lights->entries[i].quadric != NULL) {
            snprintf(reason, AIR_METHOD_REASON, "some of it comes from a sphere, cylinder or disk");
            return false;
        }
        if (lights->entries[i].emission_texture != NULL) {
            snprintf(reason, AIR_METHOD_REASON, "its emission is textured");
            return false;
        }
    }
    return emitters_are_few(snapshot, reason);
}

static bool applies(const air_snapshot *snapshot, size_t light, char reason[AIR_METHOD_REASON])
{
    const air_light_table *lights = &snapshot->lights;
    if (light < lights->explicit_count && lights->entries[light].kind != AIR_LIGHT_POLYGON) {
        snprintf(reason, AIR_METHOD_REASON, "its light is not that of a flat polygon");
        return false;
    }
    return (light < lights->explicit_count || emitters_apply(snapshot, reason)) &&
           media_apply(snapshot, reason);
}

static const char *const mode_names[] = {"edge", "mix", "ltsd", "volume-ris"};

const air_method_kind air_area_method = {"arealight", mode_names,
                                         sizeof mode_names / sizeof *mode_names,
                                         1u << AIR_TERM_S0 | 1u << AIR_TERM_M1, applies};

/* ---- getting ready ---- */

static void make_lobe(const air_area_table *given, const air_phase_lobe *from, area_lobe *out)
{
    const double g = from->kind == AIR_PHASE_HG ? (double)from->g : 0.0;
    out->rayleigh = from->kind == AIR_PHASE_RAYLEIGH;
    out->g = g;
    out->weight = (double)from->weight;
    out->nodes = air_area_edge_nodes(g);
    out->fits[0] = air_area_lobe_mix(g);
    out->fits[1] = air_area_lobe_ltsd(g);
    if (given != NULL) {
        out->fits[given->source == AIR_AREA_SOURCE_LTSD ? 1 : 0] = air_area_table_lobe(given, g);
    }
}

static void make_phase(const air_area_table *given, air_phase from, area_phase *out)
{
    const air_phase_lobe only = {from.kind, from.g, 1.0f};
    const bool mixture = from.kind == AIR_PHASE_MIXTURE;
    out->lobe_count = mixture ? from.mixture->lobe_count : 1;
    for (size_t i = 0; i < out->lobe_count; i++) {
        make_lobe(given, mixture ? &from.mixture->lobes[i] : &only, &out->lobes[i]);
    }
}

static air_status make_phases(air_with_arealight *with)
{
    const air_media *media = &with->snapshot->media;
    with->phases = air_allocate(with->context, media->count + 1, sizeof *with->phases);
    if (with->phases == NULL) {
        return air_fail_memory(with->context, "arealight: media");
    }
    for (size_t i = 0; i < media->count; i++) {
        make_phase(with->params->area_table, media->media[i].phase, &with->phases[i]);
    }
    return AIR_OK;
}

/* Is each the intersection of its planes? */
static bool media_are_convex(const air_media *media)
{
    for (size_t r = 0; r < media->region_count; r++) {
        if (media->regions[r].kind == AIR_REGION_MESH ||
            media->regions[r].kind == AIR_REGION_ELLIPSOID) {
            return false;
        }
    }
    return !media->any_replace || media->region_count == 1;
}

static bool some_light_is_owned(const air_owner_table *owners)
{
    for (size_t i = 0; i < owners->light_count; i++) {
        if (air_owner_table_uses(owners, i, AIR_METHOD_AREALIGHT)) {
            return true;
        }
    }
    return false;
}

air_status air_with_arealight_create(const air_path *path, const air_owner_table *owners,
                                     const air_render_params *params, uint32_t terms,
                                     air_with_arealight **out)
{
    air_context *context = path->snapshot->context;
    *out = NULL;
    if (!some_light_is_owned(owners) || (terms & (1u << AIR_TERM_S0 | 1u << AIR_TERM_M1)) == 0) {
        return AIR_OK;
    }
    air_with_arealight *with = air_allocate(context, 1, sizeof *with);
    if (with == NULL) {
        return air_fail_memory(context, "arealight");
    }
    with->context = context;
    with->path = path;
    with->snapshot = path->snapshot;
    with->params = params;
    with->surfaces = (terms >> AIR_TERM_S0 & 1u) != 0;
    with->volume = (terms >> AIR_TERM_M1 & 1u) != 0;
    with->convex = media_are_convex(&with->snapshot->media);
    air_status status = make_phases(with);
    status = status == AIR_OK ? air_area_lamps_make(with, owners) : status;
    if (status != AIR_OK) {
        air_with_arealight_destroy(with);
        return status;
    }
    for (size_t i = 0; i < with->lamp_count; i++) {
        with->ratio = with->ratio || (with->lamps[i].mode != AIR_AREA_MODE_VOLUME_RIS &&
                                      params->shadow_samples > 0);
    }
    *out = with;
    return AIR_OK;
}

void air_with_arealight_destroy(air_with_arealight *with)
{
    if (with == NULL) {
        return;
    }
    air_area_lamps_finish(with);
    air_free(with->context, with->phases);
    air_free(with->context, with);
}

bool air_with_arealight_is_ratio(const air_with_arealight *with)
{
    return with != NULL && with->ratio;
}

air_status air_area_scratch_create(const air_with_arealight *with, air_area_scratch **out)
{
    *out = air_allocate(with->context, 1, sizeof **out);
    return *out == NULL ? air_fail_memory(with->context, "arealight") : AIR_OK;
}

void air_area_scratch_destroy(const air_with_arealight *with, air_area_scratch *scratch)
{
    if (scratch != NULL) {
        air_free(with->context, scratch);
    }
}
