#include "bake/probes.h"

#include <string.h>

enum { MOST = 1 << 24 };

/* A grid with a point in the middle of each cell of the scene's bounds. */
static air_status place_auto(air_context *context, const air_snapshot *snapshot,
                             const air_probe_request *request, air_probe_set *out)
{
    if (!(request->spacing > 0.0f) || !isfinite(request->spacing)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "bake: probes \"%s\": expected a positive spacing, got %g", request->name,
                        (double)request->spacing);
    }
    memset(out->step, 0, sizeof out->step);
    for (int k = 0; k < 3; k++) {
        const float low = snapshot->bounds_min[k], extent = snapshot->bounds_max[k] - low;
        if (!(extent >= 0.0f) || !isfinite(extent)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "bake: probes \"%s\": the scene has no bounds to place them in",
                            request->name);
        }
        const double cells = double_max(ceil((double)(extent / request->spacing) - 1e-3), 1.0);
        if (cells > MOST) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "bake: probes \"%s\": a spacing of %g m gives %g probes along one side "
                            "of the scene",
                            request->name, (double)request->spacing, cells);
        }
        out->size[k] = (size_t)cells;
        out->step[k][k] = extent / (float)cells;
        out->origin[k] = low + 0.5f * out->step[k][k];
    }
    return AIR_OK;
}

static air_status place_grid(air_context *context, const air_probe_request *request,
                             air_probe_set *out)
{
    memcpy(out->size, request->size, sizeof out->size);
    memcpy(out->origin, request->origin, sizeof out->origin);
    memcpy(out->step, request->step, sizeof out->step);
    for (int k = 0; k < 3; k++) {
        bool finite = isfinite(request->origin[k]);
        for (int c = 0; c < 3; c++) {
            finite = finite && isfinite(request->step[k][c]);
        }
        if (request->size[k] < 1 || request->size[k] > MOST || !finite) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "bake: probes \"%s\": expected a size of 1 to %d along axis %d and "
                            "finite numbers",
                            request->name, MOST, k);
        }
    }
    return AIR_OK;
}

static air_status allocate(air_context *context, const char *name, air_probe_set *out)
{
    const size_t floats = (size_t)3 * AIR_PROBE_COEFFICIENTS;
    bool complete = true;
    out->name = air_string_copy(context, name);
    out->positions = air_allocate(context, out->count, 3 * sizeof *out->positions);
    out->validity = air_allocate(context, out->count, sizeof *out->validity);
    for (int layer = 0; layer < AIR_LAYER_COUNT; layer++) {
        out->layers[layer] = air_allocate(context, out->count, floats * sizeof(float));
        complete = complete && out->layers[layer] != NULL;
    }
    complete = complete && out->name != NULL && out->positions != NULL && out->validity != NULL;
    return complete ? AIR_OK : air_fail_memory(context, "probes");
}

static void fill_positions(air_probe_set *out)
{
    for (size_t i = 0; i < out->count; i++) {
        const size_t cell[3] = {i % out->size[0], i / out->size[0] % out->size[1],
                                i / (out->size[0] * out->size[1])};
        for (size_t c = 0; c < 3; c++) {
            float at = out->origin[c];
            for (size_t k = 0; k < 3; k++) {
                at += (float)cell[k] * out->step[k][c];
            }
            out->positions[3 * i + c] = at;
        }
    }
}

static air_status check_positions(air_context *context, const air_probe_request *request)
{
    if (request->kind != AIR_PROBES_FREE) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "bake: probes \"%s\": there is no kind %d",
                        request->name, (int)request->kind);
    }
    if (request->count > 0 && request->positions == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "bake: probes \"%s\": no positions",
                        request->name);
    }
    for (size_t i = 0; i < 3 * request->count; i++) {
        if (!isfinite(request->positions[i])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "bake: probes \"%s\": position %zu is not finite", request->name,
                            i / 3);
        }
    }
    return AIR_OK;
}

/* Probes far from everything are most likely a mistake of units or axes. */
static void warn_outside(air_context *context, const air_snapshot *snapshot,
                         const air_probe_set *set)
{
    size_t outside = 0, first = 0;
    for (size_t i = 0; i < set->count; i++) {
        bool inside = true;
        for (int k = 0; k < 3; k++) {
            const float at = set->positions[3 * i + (size_t)k];
            const float extent = snapshot->bounds_max[k] - snapshot->bounds_min[k];
            inside = inside && at >= snapshot->bounds_min[k] - extent &&
                     at <= snapshot->bounds_max[k] + extent;
        }
        first = !inside && outside == 0 ? i : first;
        outside += !inside;
    }
    if (outside > 0 && snapshot->bounds_min[0] <= snapshot->bounds_max[0]) {
        const float *at = set->positions + 3 * first;
        air_warn(context,
                 "bake: probes \"%s\": %zu of %zu are far outside of the scene, the first, %zu, at "
                 "(%g, %g, %g)",
                 set->name, outside, set->count, first, (double)at[0], (double)at[1],
                 (double)at[2]);
    }
}

air_status air_probes_place(air_context *context, const air_snapshot *snapshot,
                            const air_probe_request *request, air_probe_set *out)
{
    air_status status = AIR_OK;
    memset(out, 0, sizeof *out);
    out->grid = request->kind != AIR_PROBES_FREE;
    if (request->kind == AIR_PROBES_AUTO) {
        status = place_auto(context, snapshot, request, out);
    } else if (request->kind == AIR_PROBES_GRID) {
        status = place_grid(context, request, out);
    } else {
        out->count = request->count;
        status = check_positions(context, request);
    }
    if (status == AIR_OK && out->grid) {
        const double count = (double)out->size[0] * (double)out->size[1] * (double)out->size[2];
        if (count > MOST) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "bake: probes \"%s\": %zu x %zu x %zu are more than %d", request->name,
                            out->size[0], out->size[1], out->size[2], MOST);
        }
        out->count = (size_t)count;
    }
    if (status == AIR_OK) {
        status = allocate(context, request->name, out);
    }
    if (status == AIR_OK && out->grid) {
        fill_positions(out);
    } else if (status == AIR_OK && out->count > 0) {
        memcpy(out->positions, request->positions, out->count * 3 * sizeof(float));
    }
    if (status == AIR_OK) {
        warn_outside(context, snapshot, out);
    }
    return status;
}

bool air_probe_draw(const void *user, size_t site, const float u[2], air_path_receiver *out)
{
    const air_probe_set *set = user;
    (void)u;
    *out = (air_path_receiver){.position = vec3_load(set->positions + 3 * site), .sphere = true};
    return true;
}

void air_probes_take(const air_site_list *list, air_probe_set *set)
{
    const size_t floats = (size_t)3 * AIR_PROBE_COEFFICIENTS;
    for (size_t i = 0; i < set->count; i++) {
        const float *record = list->records + i * air_site_stride(list);
        set->validity[i] = record[AIR_SITE_VALIDITY];
        for (size_t layer = 0; layer < AIR_LAYER_COUNT; layer++) {
            memcpy(set->layers[layer] + i * floats, record + AIR_SITE_HARMONICS + layer * floats,
                   floats * sizeof(float));
        }
    }
}
