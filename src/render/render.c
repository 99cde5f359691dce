/* render.c: a snapshot into a film: passes over the samples, tiles in parallel, blocks of samples
 * in order. */
#include "airlight/render.h"

#include <math.h>
#include <string.h>

#include "airlight/ordinates_dom.h"
#include "render/picture.h"
#include "render/render_state.h"

void air_render_params_default(air_render_params *params)
{
    memset(params, 0, sizeof *params);
    params->camera = AIR_NONE;
    params->width = 960;
    params->height = 720;
    params->sample_end = 64;
    params->max_depth = UINT32_MAX;
    params->terms = AIR_TERMS_ALL;
    params->methods = "auto";
    params->filter = AIR_FILTER_BOX;
    params->filter_radius = air_filter_radius_default(AIR_FILTER_BOX);
    params->pattern = AIR_PATTERN_STRATIFIED;
    params->area_rule = AIR_AREA_EQUIANGULAR;
    params->area_nodes = 8;
    params->shadow_samples = 1;
    params->shadow_candidates = 8;
    params->ordinates = (air_ordinates_settings){.cells = 32,
                                                 .directions = 64,
                                                 .patches = 64,
                                                 .bands = 5,
                                                 .sweeps = 64,
                                                 .change = 1e-3,
                                                 .steps = 32,
                                                 .march = 2,
                                                 .prefilter = true,
                                                 .importance = false,
                                                 .residuum = true,
                                                 .bilateral = true};
    params->time_limit_s = INFINITY;
    params->tile_size = 32;
}

/* As air_dom_create, which comes late: after all light was carried to the cells. */
static air_status check_angles(air_context *context, const air_ordinates_settings *o)
{
    const bool polar = o->polar == 0 || (o->polar % 2 == 0 && o->polar >= 2 &&
                                         o->polar >= o->bands && o->polar <= 64);
    const bool azimuths = o->azimuths == 0 || (o->azimuths % 4 == 0 && o->azimuths >= 4 &&
                                               o->azimuths >= 2 * o->bands && o->azimuths <= 128);
    if (o->bands < 0 || o->bands > AIR_DOM_BANDS_MAX || !polar || !azimuths) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "ordinates: %d x %d angles for %d bands: expected 1 to %d bands, an even number of "
            "polar angles, at least as many as bands and at most 64, and a multiple of 4 round "
            "the axis, at least twice as many as bands and at most 128; 0 is a choice by the media",
            o->polar, o->azimuths, o->bands, (int)AIR_DOM_BANDS_MAX);
    }
    return AIR_OK;
}

static air_status check_ordinates(air_context *context, const air_ordinates_settings *o)
{
    if (o->cells < 2 || o->cells > 256 || o->directions < 1 || o->directions > 4096 ||
        o->patches < 1 || o->patches > 4096) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "ordinates: %u cells, %u directions, %u patches: expected 2 to 256, and 1 to "
            "4096 of the others",
            o->cells, o->directions, o->patches);
    }
    if (o->sweeps < 1 || !(o->change >= 0.0) || o->steps < 1 || o->steps > 4096 || o->march < 1 ||
        o->march > 64) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "ordinates: %u sweeps to a change of %g, %u steps, %u looks per cell: expected "
            "at least 1, at least 0, 1 to 4096 and 1 to 64",
            o->sweeps, o->change, o->steps, o->march);
    }
    return check_angles(context, o);
}

static air_status check_area(air_context *context, const air_render_params *p)
{
    if (p->area_rule < AIR_AREA_RIEMANN || p->area_rule > AIR_AREA_EQUIANGULAR) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "quadrature %d is not known", p->area_rule);
    }
    if (p->area_nodes < 1 || p->area_nodes > AIR_AREA_MAX_NODES) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%u nodes along a ray: expected 1 to %d",
                        p->area_nodes, (int)AIR_AREA_MAX_NODES);
    }
    if (p->shadow_samples > AIR_AREA_MAX_DRAWS || p->shadow_candidates < 1 ||
        p->shadow_candidates > AIR_AREA_MAX_DRAWS) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%u shadow samples of %u candidates each: expected at most %d, and 1 to %d",
                        p->shadow_samples, p->shadow_candidates, (int)AIR_AREA_MAX_DRAWS,
                        (int)AIR_AREA_MAX_DRAWS);
    }
    return AIR_OK;
}

static air_status check_size(air_context *context, const air_render_params *p)
{
    if (p->width < 1 || p->width > 65535 || p->height < 1 || p->height > 65535) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "picture size %zu x %zu: expected 1 to 65535 on both sides", p->width,
                        p->height);
    }
    const bool all = p->crop[0] == 0 && p->crop[1] == 0 && p->crop[2] == 0 && p->crop[3] == 0;
    if (!all && (p->crop[0] >= p->crop[2] || p->crop[1] >= p->crop[3] || p->crop[2] > p->width ||
                 p->crop[3] > p->height)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "crop %zu,%zu,%zu,%zu: expected x0 < x1 <= %zu and y0 < y1 <= %zu",
                        p->crop[0], p->crop[1], p->crop[2], p->crop[3], p->width, p->height);
    }
    return AIR_OK;
}

static air_status check_samples(air_context *context, const air_render_params *p)
{
    if (p->sample_begin >= p->sample_end || p->sample_begin % AIR_FILM_BLOCK != 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "samples %u:%u: expected begin < end and begin a multiple of %d",
                        p->sample_begin, p->sample_end, AIR_FILM_BLOCK);
    }
    const uint32_t count = p->sample_end - p->sample_begin;
    if (p->variance_replicates == 0) {
        return AIR_OK;
    }
    if (p->variance_replicates < 2 || count % p->variance_replicates != 0 ||
        p->sample_begin % (count / p->variance_replicates) != 0) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "variance from %u replicates: expected at least 2, a number of samples that "
            "is a multiple of it (not %u), and a begin that is a multiple of the samples "
            "of one replicate",
            p->variance_replicates, count);
    }
    if (isfinite(p->time_limit_s)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "variance from replicates needs all its samples: a time limit excludes it");
    }
    return AIR_OK;
}

static air_status check(air_context *context, const air_snapshot *snapshot,
                        const air_render_params *p)
{
    air_status status = check_size(context, p);
    status = status == AIR_OK ? check_samples(context, p) : status;
    status = status == AIR_OK ? check_area(context, p) : status;
    status = status == AIR_OK ? check_ordinates(context, &p->ordinates) : status;
    if (status != AIR_OK) {
        return status;
    }
    if (p->max_depth < 1 || (p->terms & ~(uint32_t)AIR_TERMS_ALL) != 0 || p->terms == 0) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "max depth %u, terms %u: expected a depth of at least 1 and at least one of "
            "the six terms",
            p->max_depth, p->terms);
    }
    if (!(p->filter_radius > 0.0f) || !(p->filter_radius <= 16.0f) || !(p->time_limit_s > 0.0) ||
        p->tile_size < 1) {
        return air_fail(
            context, AIR_ERROR_ARGUMENT,
            "expected a filter radius in (0, 16], a positive time limit and a tile size "
            "of at least 1");
    }
    if ((unsigned)p->pattern > AIR_PATTERN_BLUE_NOISE) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "pattern %u is none of the four",
                        (unsigned)p->pattern);
    }
    if (air_snapshot_camera(snapshot, p->camera) == SIZE_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "camera handle %u names no camera", p->camera);
    }
    return AIR_OK;
}

/* Light from infinity through fog without end is light of optical depth infinity: the picture is
 * black, and who asked for it should know why. */
static void warn_of_endless_fog(air_context *context, const air_snapshot *snapshot)
{
    const air_region *endless = NULL;
    for (size_t r = 0; r < snapshot->media.region_count; r++) {
        const air_region *region = &snapshot->media.regions[r];
        if (region->kind == AIR_REGION_EVERYWHERE && region->constant &&
            vec3_max(region->sigma_t) > 0.0f) {
            endless = region;
        }
    }
    for (size_t i = 0; endless != NULL && i < snapshot->lights.explicit_count; i++) {
        const air_light *light = &snapshot->lights.entries[i];
        if (light->kind == AIR_LIGHT_COLLIMATED || light->kind == AIR_LIGHT_ENVIRONMENT) {
            air_warn(
                context,
                "medium \"%s\" has no end, so nothing of light \"%s\" arrives from infinity: give "
                "the medium a boundary",
                snapshot->media.media[endless->medium].name, light->name);
        }
    }
}

/* ---- passes ---- */

/* The next pass: the largest run that doubles at most what is there, so that an interruption loses
 * little, and that the time left allows. Replicates go in one pass. */
static uint32_t pass_end(const air_render_params *p, uint32_t begin, double spent_s, double left_s)
{
    const uint32_t done = begin - p->sample_begin;
    uint32_t end = p->sample_end;
    if (p->variance_replicates > 0) {
        return end;
    }
    const uint32_t most = done < AIR_FILM_BLOCK ? AIR_FILM_BLOCK : done;
    end = end - begin > most ? begin + most : end;
    end = air_film_node_end(begin, end);
    while (done > 0 && isfinite(left_s) && end - begin > AIR_FILM_BLOCK &&
           spent_s / done * (end - begin) > left_s) {
        end = begin + (end - begin) / 2 / AIR_FILM_BLOCK * AIR_FILM_BLOCK;
        end = air_film_node_end(begin, end);
    }
    return end;
}

static air_status run_passes(air_picture *picture, air_film *film)
{
    const air_render_params *p = picture->params;
    uint32_t begin = p->sample_begin;
    while (begin < p->sample_end) {
        const double spent = air_clock(picture->context) - picture->start_s;
        if (spent >= p->time_limit_s) {
            break;
        }
        const uint32_t end = pass_end(p, begin, spent, p->time_limit_s - spent);
        const air_status status = air_picture_pass(picture, film, begin, end);
        if (status != AIR_OK) {
            return status;
        }
        begin = end;
        if (p->pass_done != NULL && !p->pass_done(p->pass_user, film)) {
            break;
        }
    }
    return AIR_OK;
}

static air_status make_film(air_context *context, const air_snapshot *snapshot,
                            const air_render_params *params, air_film **out_film)
{
    air_picture picture;
    air_status status = air_picture_init(&picture, context, snapshot, params);
    if (status == AIR_OK) {
        status = air_picture_film(&picture, out_film);
    }
    if (status == AIR_OK) {
        status = run_passes(&picture, *out_film);
    }
    air_picture_finish(&picture);
    return status;
}

air_status air_render(air_context *context, const air_snapshot *snapshot,
                      const air_render_params *params, air_film **out_film)
{
    air_film *film = NULL;
    *out_film = NULL;
    air_status status = check(context, snapshot, params);
    if (status == AIR_OK) {
        status = air_render_state_enter(context, params->state);
    }
    if (status != AIR_OK) {
        return status;
    }
    warn_of_endless_fog(context, snapshot);
    status = make_film(context, snapshot, params, &film);
    air_render_state_leave(params->state);
    if (status == AIR_OK || status == AIR_ERROR_INTERRUPTED) {
        *out_film = film;
    } else {
        air_film_destroy(film);
    }
    return status;
}
