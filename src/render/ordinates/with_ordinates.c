#include "render/ordinates/with_ordinates.h"

#include <math.h>
#include <stdio.h>

#include "render/method.h"
#include "render/ordinates/state.h"
#include "render/owner.h"
#include "render/render_state.h"
#include "scene/fingerprint.h"

/* ---- where it applies ---- */

/* Of a medium, anything but space without end. */
static bool has_end(const air_medium *medium)
{
    for (int axis = 0; axis < 3; axis++) {
        if (!isfinite(medium->bounds_min[axis]) || !isfinite(medium->bounds_max[axis])) {
            return false;
        }
    }
    return true;
}

static bool applies(const air_snapshot *snapshot, size_t light, char reason[AIR_METHOD_REASON])
{
    const air_light_table *lights = &snapshot->lights;
    bool scatters = false;
    if (light < lights->explicit_count && lights->entries[light].kind == AIR_LIGHT_PROJECTOR) {
        snprintf(reason, AIR_METHOD_REASON, "it is a projector");
        return false;
    }
    for (size_t i = 0; i < snapshot->media.count; i++) {
        const air_medium *medium = &snapshot->media.media[i];
        if (!vec3_is_zero(medium->sigma_t) && !has_end(medium)) {
            snprintf(reason, AIR_METHOD_REASON, "medium \"%.60s\" has no end", medium->name);
            return false;
        }
        scatters = scatters || !vec3_is_zero(medium->sigma_s);
    }
    if (!scatters) {
        snprintf(reason, AIR_METHOD_REASON, "no medium scatters light");
    }
    return scatters;
}

static const char *const mode_names[AIR_ORDINATES_MODE_COUNT] = {"dom", "cm", "six", "literal",
                                                                 "shdom"};

const air_method_kind air_ordinates_method = {"ordinates", mode_names, AIR_ORDINATES_MODE_COUNT,
                                              1u << AIR_TERM_M1 | 1u << AIR_TERM_M2, applies};

/* ---- getting ready ---- */

/* Is some light owned; does some of it have grids of its own? */
static bool some_light_is_owned(const air_owner_table *owners, bool *out_carries)
{
    bool any = false;
    *out_carries = false;
    for (size_t i = 0; i < owners->light_count; i++) {
        const bool owned = air_owner_table_uses(owners, i, AIR_METHOD_ORDINATES);
        any = any || owned;
        *out_carries = *out_carries || (owned && owners->modes[i] != AIR_ORDINATES_MODE_DOM);
    }
    return any;
}

/* Before anything large is allocated: the machine would rather swap than say no. */
static air_status check_memory(air_with_ordinates *with)
{
    const ord_domain *const d = &with->domain;
    const double bytes = ord_memory(with, with->all), machine = air_machine_memory();
    if (machine > 0.0 && bytes > machine) {
        return air_fail(with->context, AIR_ERROR_MEMORY,
                        "ordinates: %zu x %zu x %zu cells with %d bands need %.1f GB of memory, "
                        "the machine has %.1f GB: expected fewer cells (now %u along the longest "
                        "side) or fewer bands",
                        d->size[0], d->size[1], d->size[2], with->rule.bands, bytes * 1e-9,
                        machine * 1e-9, with->settings->cells);
    }
    air_inform(with->context, "ordinates: %zu x %zu x %zu cells of %.3g m, %.3g GB of memory",
               d->size[0], d->size[1], d->size[2], (double)d->cell_m, bytes * 1e-9);
    return AIR_OK;
}

/* What weights between cells look at. */
static air_status make_extinction(air_with_ordinates *with)
{
    const ord_domain *const d = &with->domain;
    with->extinction = air_allocate(with->context, d->cells, sizeof *with->extinction);
    if (with->extinction == NULL) {
        return air_fail_memory(with->context, "ordinates: cells");
    }
    for (size_t i = 0; i < d->cells; i++) {
        for (size_t c = 0; c < 3; c++) {
            const size_t at = c * d->cells + i;
            with->extinction[i] += (d->sigma_s[at] + d->sigma_a[at]) * (1.0f / 3.0f);
        }
        with->largest = float_max(with->largest, with->extinction[i]);
    }
    return AIR_OK;
}

air_status air_with_ordinates_create(const air_path *path, const air_owner_table *owners,
                                     const air_camera_view *view, const air_render_params *params,
                                     uint32_t terms, bool split, air_with_ordinates **out)
{
    air_context *const context = path->snapshot->context;
    const bool first = (terms >> AIR_TERM_M1 & 1u) != 0;
    const bool rest = (terms >> AIR_TERM_M2 & 1u) != 0 && params->max_depth > 1;
    bool carries;
    *out = NULL;
    if (!some_light_is_owned(owners, &carries) || !(first || rest)) {
        return AIR_OK;
    }
    air_with_ordinates *const with = air_allocate(context, 1, sizeof *with);
    if (with == NULL) {
        return air_fail_memory(context, "ordinates");
    }
    with->context = context;
    with->path = path;
    with->snapshot = path->snapshot;
    with->settings = &params->ordinates;
    with->all = rest;
    with->single = split || !(first && rest);
    with->first_wanted = first;
    with->carries = carries;
    with->past = params->state != NULL ? &params->state->ordinates : NULL;
    ord_rule_choose(with);
    ord_past_begin(with->past);
    air_status status = ord_domain_place(with->snapshot, params->ordinates.cells,
                                         ord_past_lattice(with->past), &with->domain);
    if (status == AIR_OK) {
        status = ord_voxels_lay_out(with, (size_t)params->width * params->height);
    }
    if (status == AIR_OK) {
        status = check_memory(with);
    }
    if (status == AIR_OK) {
        status = ord_domain_fill(&with->domain);
    }
    if (status == AIR_OK) {
        status = make_extinction(with);
    }
    if (status == AIR_OK) {
        status = ord_solve(with, owners, view, params);
    }
    if (status == AIR_OK) {
        status = ord_voxels_fill(with);
    }
    if (status != AIR_OK) {
        air_with_ordinates_destroy(with);
        return status;
    }
    *out = with;
    return AIR_OK;
}

void air_with_ordinates_destroy(air_with_ordinates *with)
{
    if (with == NULL) {
        return;
    }
    for (size_t i = 0; i < with->medium_count && with->media != NULL; i++) {
        air_free(with->context, with->media[i].light);
        air_free(with->context, with->media[i].first);
    }
    air_free(with->context, with->media);
    ord_voxels_finish(with);
    ord_sky_finish(&with->sky);
    air_free(with->context, with->carried);
    air_free(with->context, with->extinction);
    ord_domain_finish(&with->domain);
    air_free(with->context, with);
}

uint64_t air_with_ordinates_fingerprint(const air_with_ordinates *with, uint64_t hash)
{
    const air_ordinates_settings *const s = with->settings;
    const uint32_t numbers[] = {s->cells,
                                s->directions,
                                s->patches,
                                (uint32_t)with->rule.bands,
                                s->sweeps,
                                (uint32_t)with->rule.polar,
                                (uint32_t)with->rule.azimuths,
                                s->steps,
                                s->march,
                                (uint32_t)s->prefilter,
                                (uint32_t)s->importance,
                                (uint32_t)s->residuum,
                                (uint32_t)s->bilateral};
    hash = air_fingerprint_add(hash, numbers, sizeof numbers);
    if (with->history != 0) {
        hash = air_fingerprint_add(hash, &with->history, sizeof with->history);
    }
    return air_fingerprint_add(hash, &s->change, sizeof s->change);
}

air_status air_march_scratch_create(const air_with_ordinates *with, air_march_scratch **out)
{
    *out = air_allocate(with->context, 1, sizeof **out);
    return *out == NULL ? air_fail_memory(with->context, "ordinates") : AIR_OK;
}

void air_march_scratch_destroy(const air_with_ordinates *with, air_march_scratch *scratch)
{
    if (scratch != NULL) {
        air_free(with->context, scratch);
    }
}

/* ---- samples ---- */

void air_with_ordinates_add(const air_with_ordinates *with, air_march_scratch *scratch,
                            air_path_lane *lanes, size_t count)
{
    air_vec3 light[AIR_PATH_LANES][2];
    ord_march(with, scratch, lanes, count, light);
    for (size_t i = 0; i < count; i++) {
        air_vec3 *const m1 = &lanes[i].terms[AIR_TERM_M1], *const m2 = &lanes[i].terms[AIR_TERM_M2];
        if (with->all) {
            *m2 = vec3_add(*m2, with->single ? vec3_sub(light[i][0], light[i][1]) : light[i][0]);
        }
        if (with->single && with->first_wanted) {
            *m1 = vec3_add(*m1, light[i][1]);
        }
    }
}
