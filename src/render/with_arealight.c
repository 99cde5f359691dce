#include "render/with_arealight.h"

#include <stdio.h>
#include <string.h>

#include "core/triple.h"
#include "render/arealight_state.h"
#include "render/method.h"
#include "render/owner.h"

/* ---- where it applies ---- */

/* More would cost more than they are worth: every sample asks all of them. */
enum { MOST_LAMPS = 256 };

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

/* Emissive meshes are one light to the owner table. */
static bool emitters_apply(const air_snapshot *snapshot, char reason[AIR_METHOD_REASON])
{
    const air_light_table *lights = &snapshot->lights;
    if (lights->count - lights->explicit_count > MOST_LAMPS) {
        snprintf(reason, AIR_METHOD_REASON, "its %zu triangles are more than %d",
                 lights->count - lights->explicit_count, (int)MOST_LAMPS);
        return false;
    }
    for (size_t i = lights->explicit_count; i < lights->count; i++) {
        if (lights->entries[i].emission_texture != NULL) {
            snprintf(reason, AIR_METHOD_REASON, "its emission is textured");
            return false;
        }
    }
    return true;
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
                                         sizeof mode_names / sizeof *mode_names, applies};

/* ---- lamps ---- */

static air_status make_cubature(air_context *context, const air_area_lamp *shape, int m,
                                area_cubature *out)
{
    double points[AIR_AREA_MAX_POINTS][3], weights[AIR_AREA_MAX_POINTS];
    out->count = air_area_lamp_points(shape, m, points, weights);
    out->points = air_allocate(context, out->count, sizeof *out->points);
    out->weights = air_allocate(context, out->count, sizeof *out->weights);
    if (out->points == NULL || out->weights == NULL) {
        return air_fail_memory(context, "arealight: lamps");
    }
    memcpy(out->points, points, out->count * sizeof *out->points);
    memcpy(out->weights, weights, out->count * sizeof *out->weights);
    return AIR_OK;
}

static void make_fan(area_lamp *lamp)
{
    const air_area_lamp *shape = &lamp->shape;
    double sum = 0.0;
    for (size_t i = 2; i < shape->vertex_count; i++) {
        double a[3], b[3], normal[3];
        air_subtract3(shape->vertices[i - 1], shape->vertices[0], a);
        air_subtract3(shape->vertices[i], shape->vertices[0], b);
        air_cross3(a, b, normal);
        sum += air_length3(normal);
        lamp->fan[i - 2] = sum;
    }
    for (size_t i = 2; i < shape->vertex_count; i++) {
        lamp->fan[i - 2] /= sum;
    }
}

static air_status add_lamp(air_with_arealight *with, const air_light *light, air_area_mode mode,
                           const air_vec3 *vertices, size_t count)
{
    double corners[AIR_AREA_MAX_VERTICES][3];
    area_lamp *lamp = &with->lamps[with->lamp_count];
    for (size_t i = 0; i < count; i++) {
        vec3_store64(corners[i], vertices[i]);
    }
    /* What has no area gives no light. */
    if (air_area_lamp_make(NULL, (const double(*)[3])corners, count, !light->one_sided,
                           &lamp->shape) != AIR_OK) {
        return AIR_OK;
    }
    with->lamp_count++;
    vec3_store64(lamp->radiance, light->color);
    lamp->mode = mode;
    lamp->casts_shadow = light->casts_shadow;
    make_fan(lamp);
    /* Points across the lamp from afar, and near it; a polygon of more corners has them in each
     * triangle of a fan. */
    const bool simple = count <= 4;
    air_status status = make_cubature(with->context, &lamp->shape, simple ? 3 : 2, &lamp->few);
    return status == AIR_OK
               ? make_cubature(with->context, &lamp->shape, simple ? 8 : 4, &lamp->many)
               : status;
}

/* Convex polygons stay whole, others come as the triangles they were cut into. */
static air_status add_light(air_with_arealight *with, const air_light *light, air_area_mode mode)
{
    const size_t before = with->lamp_count;
    if (light->vertices != NULL && light->vertex_count <= AIR_AREA_MAX_VERTICES) {
        const air_status status = add_lamp(with, light, mode, light->vertices, light->vertex_count);
        if (status != AIR_OK || with->lamp_count > before) {
            return status;
        }
    }
    air_status status = AIR_OK;
    for (size_t i = 0; i < light->triangle_count && status == AIR_OK; i++) {
        status = add_lamp(with, light, mode, light->triangles[i], 3);
    }
    return status;
}

static size_t lamp_limit(const air_with_arealight *with)
{
    size_t count = 0;
    for (size_t i = 0; i < with->snapshot->lights.count; i++) {
        const air_light *light = &with->snapshot->lights.entries[i];
        count += light->kind == AIR_LIGHT_POLYGON ? light->triangle_count + 1 : 0;
    }
    return count;
}

static air_status make_lamps(air_with_arealight *with, const air_owner_table *owners)
{
    const air_light_table *lights = &with->snapshot->lights;
    air_status status = AIR_OK;
    with->lamps = air_allocate(with->context, lamp_limit(with) + 1, sizeof *with->lamps);
    if (with->lamps == NULL) {
        return air_fail_memory(with->context, "arealight: lamps");
    }
    for (size_t i = 0; i < lights->count && status == AIR_OK; i++) {
        const air_light *light = &lights->entries[i];
        if (light->kind == AIR_LIGHT_POLYGON &&
            air_owner_table_uses(owners, light->owner, AIR_METHOD_AREALIGHT)) {
            status = add_light(with, light, (air_area_mode)owners->modes[light->owner]);
        }
    }
    return status;
}

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

static bool media_are_convex(const air_media *media)
{
    for (size_t r = 0; r < media->region_count; r++) {
        if (media->regions[r].kind == AIR_REGION_MESH) {
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
                                     const air_render_params *params, air_with_arealight **out)
{
    air_context *context = path->snapshot->context;
    *out = NULL;
    if (!some_light_is_owned(owners) ||
        (params->terms & (1u << AIR_TERM_S0 | 1u << AIR_TERM_M1)) == 0) {
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
    with->surfaces = (params->terms >> AIR_TERM_S0 & 1u) != 0;
    with->volume = (params->terms >> AIR_TERM_M1 & 1u) != 0;
    with->convex = media_are_convex(&with->snapshot->media);
    air_status status = make_phases(with);
    status = status == AIR_OK ? make_lamps(with, owners) : status;
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
    for (size_t i = 0; i < with->lamp_count; i++) {
        const area_cubature *both[2] = {&with->lamps[i].few, &with->lamps[i].many};
        for (int k = 0; k < 2; k++) {
            air_free(with->context, both[k]->points);
            air_free(with->context, both[k]->weights);
        }
    }
    air_free(with->context, with->lamps);
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
