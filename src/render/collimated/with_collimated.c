/* with_collimated.c: which lights the collimated method can own, and what it needs for them. */
#include "render/collimated/with_collimated.h"

#include <stdio.h>
#include <string.h>

#include "render/collimated/moments.h"
#include "render/collimated/state.h"
#include "render/method.h"
#include "render/owner.h"
#include "scene/shadows.h"

/* ---- modes ---- */

static const char *const mode_names[AIR_COLLIMATED_MODE_COUNT] = {
    "exact", "rm", "ds", "wvds", "rees", "reds", "me", "me6", "me-ideal", "me6-ideal"};

/* ---- where it applies ---- */

static const air_medium *medium_of(const air_snapshot *snapshot, const air_region *region)
{
    return &snapshot->media.media[region->medium];
}

static bool media_apply(const air_snapshot *snapshot, char reason[AIR_METHOD_REASON])
{
    const air_media *media = &snapshot->media;
    if (media->region_count == 0) {
        snprintf(reason, AIR_METHOD_REASON, "there is no medium");
        return false;
    }
    for (size_t r = 0; r < media->region_count; r++) {
        const char *name = medium_of(snapshot, &media->regions[r])->name;
        if (media->regions[r].kind == AIR_REGION_MESH) {
            snprintf(reason, AIR_METHOD_REASON, "medium \"%.60s\" is not convex", name);
            return false;
        }
        if (media->regions[r].kind == AIR_REGION_ELLIPSOID) {
            snprintf(reason, AIR_METHOD_REASON, "medium \"%.60s\" does not end at planes", name);
            return false;
        }
        if (!media->regions[r].constant) {
            snprintf(reason, AIR_METHOD_REASON, "medium \"%.60s\" is not of constant density",
                     name);
            return false;
        }
    }
    if (media->any_replace && media->region_count > 1) {
        snprintf(reason, AIR_METHOD_REASON, "a medium replaces others instead of adding to them");
        return false;
    }
    return true;
}

/* Shadow trees hold triangles only. */
static bool shadows_apply(const air_snapshot *snapshot, char reason[AIR_METHOD_REASON])
{
    for (size_t i = 0; i < snapshot->mesh_count; i++) {
        const air_mesh *mesh = snapshot->meshes[i];
        if (mesh->quadric != NULL && (mesh->mask & AIR_MASK_SHADOW_OPAQUE) != 0) {
            snprintf(reason, AIR_METHOD_REASON,
                     "mesh \"%.60s\" casts shadows and is not made of "
                     "triangles",
                     mesh->name);
            return false;
        }
    }
    return true;
}

static bool applies(const air_snapshot *snapshot, size_t light, char reason[AIR_METHOD_REASON])
{
    if (light >= snapshot->lights.explicit_count ||
        snapshot->lights.entries[light].kind != AIR_LIGHT_COLLIMATED) {
        snprintf(reason, AIR_METHOD_REASON, "its light does not come along one direction");
        return false;
    }
    if (!media_apply(snapshot, reason) ||
        (snapshot->lights.entries[light].casts_shadow && !shadows_apply(snapshot, reason))) {
        return false;
    }
    if (!air_shadows_end(snapshot, light)) {
        snprintf(reason, AIR_METHOD_REASON, "a medium has no end away from the light");
        return false;
    }
    return true;
}

const air_method_kind air_collimated_method = {"collimated", mode_names, AIR_COLLIMATED_MODE_COUNT,
                                               1u << AIR_TERM_S0 | 1u << AIR_TERM_M1, applies};

/* ---- cells ---- */

static void make_cell(const air_region *region, int channel, air_collimated_cell *out)
{
    const float sigma_t[3] = {region->sigma_t.x, region->sigma_t.y, region->sigma_t.z};
    air_region_planes(region, &out->medium);
    out->sigma_t = (double)sigma_t[channel];
    out->weight = 1.0;
}

static bool is_grey(air_vec3 v) { return v.x == v.y && v.x == v.z; }

static air_status make_cells(air_with_collimated *with)
{
    const air_media *media = &with->snapshot->media;
    with->region_count = media->region_count;
    with->channels = 1;
    for (size_t r = 0; r < media->region_count; r++) {
        const air_region *region = &media->regions[r];
        const bool one = media->region_count == 1; /* then sigma_s is no part of the profile */
        if (!is_grey(region->sigma_t) || !(one || is_grey(region->sigma_s))) {
            with->channels = 3;
        }
    }
    with->cells =
        air_allocate(with->context, with->channels * with->region_count, sizeof *with->cells);
    if (with->cells == NULL) {
        return air_fail_memory(with->context, "collimated: media");
    }
    for (size_t c = 0; c < with->channels; c++) {
        for (size_t r = 0; r < with->region_count; r++) {
            make_cell(&media->regions[r], (int)c, &with->cells[c * with->region_count + r]);
        }
    }
    with->piece_limit = with->region_count == 1
                            ? (size_t)AIR_COLLIMATED_MAX_PIECES
                            : air_collimated_cells_piece_limit(with->cells, with->region_count);
    return AIR_OK;
}

/* ---- lamps ---- */

static bool uses_moments(air_collimated_mode mode) { return mode >= AIR_COLLIMATED_MODE_ME; }

/* What tells the lamp's shadows in modes that do not send rays for each sample. */
static air_status make_shadows(air_with_collimated *with, collimated_lamp *lamp, size_t light,
                               const air_camera_view *view)
{
    if (!with->volume || !lamp->light->casts_shadow) {
        return AIR_OK;
    }
    if (with->snapshot->has_alpha) {
        air_inform(with->context, "light \"%s\": shadows of surfaces with coverage are %s",
                   lamp->light->name,
                   uses_moments(lamp->mode) ? "left out" : "sampled, all others are exact");
    }
    const air_status status = air_snapshot_shadows(with->snapshot, light, &lamp->shadows);
    return status == AIR_OK && uses_moments(lamp->mode)
               ? air_collimated_moments_make(with, lamp, view)
               : status;
}

static air_status make_lamp(air_with_collimated *with, const air_owner_table *owners, size_t light,
                            const air_camera_view *view)
{
    collimated_lamp *lamp = &with->lamps[with->lamp_count++];
    lamp->light = &with->snapshot->lights.entries[light];
    lamp->mode = (air_collimated_mode)owners->modes[light];
    const size_t windows = air_light_window_limit(lamp->light);
    with->window_limit = windows > with->window_limit ? windows : with->window_limit;
    air_shadows_direction(lamp->light, lamp->to_light);
    if (uses_moments(lamp->mode) && view->kind != AIR_CAMERA_PERSPECTIVE) {
        air_warn(with->context,
                 "light \"%s\": moments need a perspective camera; its shadows are exact instead",
                 lamp->light->name);
        lamp->mode = AIR_COLLIMATED_EXACT;
    }
    if (air_collimated_mode_samples(lamp->mode)) {
        with->ratio = with->ratio ||
                      air_collimated_estimator_is_ratio(air_collimated_mode_estimator(lamp->mode));
        return AIR_OK;
    }
    return make_shadows(with, lamp, light, view);
}

static air_status make_lamps(air_with_collimated *with, const air_owner_table *owners,
                             const air_camera_view *view, size_t count)
{
    air_status status = AIR_OK;
    with->lamps = air_allocate(with->context, count, sizeof *with->lamps);
    if (with->lamps == NULL) {
        return air_fail_memory(with->context, "collimated: lights");
    }
    for (size_t i = 0; i < owners->light_count && status == AIR_OK; i++) {
        if (air_owner_table_uses(owners, i, AIR_METHOD_COLLIMATED)) {
            status = make_lamp(with, owners, i, view);
        }
    }
    return status;
}

air_status air_with_collimated_create(const air_path *path, const air_owner_table *owners,
                                      const air_camera_view *view, uint32_t terms,
                                      air_with_collimated **out)
{
    air_context *context = path->snapshot->context;
    size_t count = 0;
    *out = NULL;
    for (size_t i = 0; i < owners->light_count; i++) {
        count += air_owner_table_uses(owners, i, AIR_METHOD_COLLIMATED);
    }
    if (count == 0 || (terms & (1u << AIR_TERM_S0 | 1u << AIR_TERM_M1)) == 0) {
        return AIR_OK;
    }
    air_with_collimated *with = air_allocate(context, 1, sizeof *with);
    if (with == NULL) {
        return air_fail_memory(context, "collimated");
    }
    with->context = context;
    with->path = path;
    with->snapshot = path->snapshot;
    with->window_limit = 1;
    with->surfaces = (terms >> AIR_TERM_S0 & 1u) != 0;
    with->volume = (terms >> AIR_TERM_M1 & 1u) != 0;
    air_status status = make_cells(with);
    status = status == AIR_OK ? make_lamps(with, owners, view, count) : status;
    if (status != AIR_OK) {
        air_with_collimated_destroy(with);
        return status;
    }
    *out = with;
    return AIR_OK;
}

void air_with_collimated_destroy(air_with_collimated *with)
{
    if (with == NULL) {
        return;
    }
    for (size_t i = 0; with->lamps != NULL && i < with->lamp_count; i++) {
        air_moment_map_destroy(with->lamps[i].moments);
    }
    air_free(with->context, with->lamps);
    air_free(with->context, with->cells);
    air_free(with->context, with);
}

bool air_with_collimated_is_ratio(const air_with_collimated *with)
{
    return with != NULL && with->ratio;
}

/* ---- scratch ---- */

/* Beams at a time: of a block's lanes, or of one lane's lamps. */
static size_t place_count(const air_with_collimated *with)
{
    return with->lamp_count > AIR_PATH_LANES ? with->lamp_count : AIR_PATH_LANES;
}

/* Profiles per beam and channel, one before windows, and one per channel for lit stretches. */
static void share_out_pieces(const air_with_collimated *with, air_collimated_scratch *scratch)
{
    const size_t cut = with->piece_limit + with->window_limit;
    const size_t lit = cut + COLLIMATED_INTERVALS + 1;
    air_collimated_piece *next = scratch->pieces;
    for (size_t i = 0; i < 3 * place_count(with); i++, next += cut) {
        scratch->profiles[i] = (air_collimated_profile){.pieces = next, .capacity = cut};
    }
    scratch->plain = (air_collimated_profile){.pieces = next, .capacity = with->piece_limit};
    next += with->piece_limit;
    for (size_t c = 0; c < 3; c++, next += lit) {
        scratch->lit[c] = (air_collimated_profile){.pieces = next, .capacity = lit};
    }
}

air_status air_collimated_scratch_create(const air_with_collimated *with,
                                         air_collimated_scratch **out)
{
    air_context *context = with->context;
    const size_t places = place_count(with), cut = with->piece_limit + with->window_limit;
    const size_t pieces =
        3 * places * cut + with->piece_limit + 3 * (cut + COLLIMATED_INTERVALS + 1);
    air_collimated_scratch *scratch = air_allocate(context, 1, sizeof *scratch);
    *out = scratch;
    if (scratch == NULL) {
        return air_fail_memory(context, "collimated");
    }
    scratch->pieces = air_allocate(context, pieces, sizeof *scratch->pieces);
    scratch->profiles = air_allocate(context, 3 * places, sizeof *scratch->profiles);
    scratch->beams = air_allocate(context, places, sizeof *scratch->beams);
    scratch->open = air_allocate(context, with->window_limit, sizeof *scratch->open);
    scratch->contributions =
        air_allocate(context, with->lamp_count, sizeof *scratch->contributions);
    scratch->cells =
        air_allocate(context, with->channels * with->region_count, sizeof *scratch->cells);
    if (scratch->pieces == NULL || scratch->profiles == NULL || scratch->beams == NULL ||
        scratch->open == NULL || scratch->contributions == NULL || scratch->cells == NULL) {
        return air_fail_memory(context, "collimated");
    }
    memcpy(scratch->cells, with->cells,
           with->channels * with->region_count * sizeof *scratch->cells);
    share_out_pieces(with, scratch);
    return AIR_OK;
}

void air_collimated_scratch_destroy(const air_with_collimated *with,
                                    air_collimated_scratch *scratch)
{
    if (scratch != NULL) {
        air_free(with->context, scratch->pieces);
        air_free(with->context, scratch->profiles);
        air_free(with->context, scratch->beams);
        air_free(with->context, scratch->open);
        air_free(with->context, scratch->contributions);
        air_free(with->context, scratch->cells);
        air_free(with->context, scratch);
    }
}
