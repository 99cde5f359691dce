/* sources.c: lights of a scene as directions and points. */
#include "render/ordinates/sources.h"

#include <math.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "core/random.h"
#include "scene/lights/environment.h"
#include "scene/lights/light_table.h"

air_status ord_sources_add(ord_source_list *list, const ord_source *source)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity > 0 ? 2 * list->capacity : 64;
        ord_source *const items =
            air_reallocate(list->context, list->items, capacity, sizeof *items);
        if (items == NULL) {
            return air_fail_memory(list->context, "ordinates: lights");
        }
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = *source;
    return AIR_OK;
}

void ord_sources_finish(ord_source_list *list)
{
    air_free(list->context, list->items);
    memset(list, 0, sizeof *list);
}

/* ---- environments ---- */

static air_status add_ordinates(const air_light *light, const air_ordinate *ordinates, size_t count,
                                bool prefilter, ord_source_list *out)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        const air_ordinate *const o = &ordinates[i];
        const ord_source source = {
            .place = vec3((float)o->travel[0], (float)o->travel[1], (float)o->travel[2]),
            .power =
                vec3((float)o->irradiance[0], (float)o->irradiance[1], (float)o->irradiance[2]),
            .lobe = prefilter ? (float)o->lobe : 1.0f,
            .solid_angle = prefilter ? (float)o->solid_angle : 0.0f,
            .casts_shadow = light->casts_shadow,
            .sky = true};
        if (!vec3_is_zero(source.power)) {
            status = ord_sources_add(out, &source);
        }
    }
    return status;
}

void ord_environment_map(const air_light *light, air_environment_map *out)
{
    air_environment_map_default(out);
    vec3_store(out->radiance, light->color);
    if (light->environment != NULL) {
        out->pixels = light->environment->pixels;
        out->width = light->environment->width;
        out->height = light->environment->height;
        out->pixel_stride = light->environment->stride;
        out->row_stride = out->pixel_stride * out->width;
    }
}

static air_status add_environment(const ord_lighting *lighting, const air_light *light,
                                  ord_source_list *out)
{
    const size_t count = lighting->settings->directions;
    air_environment_map map;
    air_environment_choice choice;
    air_environment_ordinates *prepared = NULL;
    air_ordinate *const ordinates = air_allocate(out->context, count, sizeof *ordinates);
    if (ordinates == NULL) {
        return air_fail_memory(out->context, "ordinates: directions");
    }
    ord_environment_map(light, &map);
    air_environment_choice_default(&choice);
    choice.count = count;
    choice.importance = lighting->importance;
    if (light->environment != NULL) {
        memcpy(choice.to_world, light->environment->to_world, sizeof choice.to_world);
    }
    air_status status = ord_past_prepare_sky(lighting->past, out->context, &map, &prepared);
    if (status == AIR_OK) {
        status = air_environment_ordinates_choose(out->context, prepared, &choice, ordinates);
    }
    if (status == AIR_OK) {
        status = add_ordinates(light, ordinates, count, lighting->settings->prefilter, out);
    }
    ord_past_release_sky(lighting->past, prepared);
    air_free(out->context, ordinates);
    return status;
}

/* ---- lamps ---- */

static air_status add_plain(const air_light *light, ord_source_list *out)
{
    const ord_source source = {.local = light->kind != AIR_LIGHT_COLLIMATED,
                               .place = light->kind == AIR_LIGHT_COLLIMATED ? light->dir
                                                                            : light->position,
                               .power = light->color,
                               .lobe = 1.0f,
                               .casts_shadow = light->casts_shadow,
                               .light = light};
    return ord_sources_add(out, &source);
}

/* An even sequence in the unit square: the golden ratio's plane cousin [Roberts2018]. */
static void even_pair(size_t n, float out[2])
{
    const double at = (double)n + 0.5;
    out[0] = (float)(at * 0.7548776662466927 - floor(at * 0.7548776662466927));
    out[1] = (float)(at * 0.5698402909980532 - floor(at * 0.5698402909980532));
}

/* A patch of a light with an area: count of them stand for the entry's area between them. */
static air_status add_patch(const air_light_table *table, uint32_t entry, size_t n, float share,
                            size_t total, ord_source_list *out)
{
    const air_light *const light = &table->entries[entry];
    air_light_point point;
    float u[2];
    even_pair(n, u);
    air_light_sample(table, entry, u[0], u[1], &point);
    const float area = share / point.pdf;
    const ord_source source = {.local = true,
                               .place = point.position,
                               .power = vec3_scale(point.value, area),
                               .lobe = 1.0f,
                               .radius_m = sqrtf(light->area / ((float)total * AIR_PI_F)),
                               .cosine = true,
                               .two_sided = !light->one_sided,
                               .casts_shadow = light->casts_shadow,
                               .normal = point.normal};
    return vec3_is_zero(source.power) ? AIR_OK : ord_sources_add(out, &source);
}

static float entry_power(const air_light *light) { return vec3_max(light->color) * light->area; }

/* `patches` of them over entries [begin, end), as many as each has of the power. */
static air_status add_patches(const ord_lighting *lighting, size_t begin, size_t end,
                              ord_source_list *out)
{
    const air_light_table *const table = &lighting->path->snapshot->lights;
    double total = 0.0, sum = 0.0;
    size_t done = 0;
    air_status status = AIR_OK;
    for (size_t i = begin; i < end; i++) {
        total += (double)entry_power(&table->entries[i]);
    }
    for (size_t i = begin; i < end && total > 0.0 && status == AIR_OK; i++) {
        sum += (double)entry_power(&table->entries[i]);
        const size_t until = (size_t)ceil((double)lighting->settings->patches * sum / total - 1e-9);
        const size_t count = until > done ? until - done : 0;
        const size_t at_least = entry_power(&table->entries[i]) > 0.0f && count == 0 ? 1 : count;
        for (size_t n = 0; n < at_least && status == AIR_OK; n++) {
            status = add_patch(table, (uint32_t)i, n, 1.0f / (float)at_least, at_least, out);
        }
        done = until > done ? until : done;
    }
    return status;
}

/* What was added since came from this owner's light. */
static void set_mode(const air_owner_table *owners, size_t owner, size_t since,
                     ord_source_list *out)
{
    for (size_t i = since; i < out->count; i++) {
        out->items[i].mode = (air_ordinates_mode)owners->modes[owner];
    }
}

air_status ord_sources_make(const ord_lighting *lighting, ord_source_list *out)
{
    const air_snapshot *const snapshot = lighting->path->snapshot;
    const air_light_table *const table = &snapshot->lights;
    air_status status = AIR_OK;
    memset(out, 0, sizeof *out);
    out->context = snapshot->context;
    for (size_t i = 0; i < table->explicit_count && status == AIR_OK; i++) {
        const air_light *const light = &table->entries[i];
        if (!air_owner_table_uses(lighting->owners, i, AIR_METHOD_ORDINATES)) {
            continue;
        }
        const size_t since = out->count;
        status = light->kind == AIR_LIGHT_ENVIRONMENT ? add_environment(lighting, light, out)
                 : light->kind == AIR_LIGHT_POLYGON   ? add_patches(lighting, i, i + 1, out)
                                                      : add_plain(light, out);
        set_mode(lighting->owners, i, since, out);
    }
    const size_t since = out->count;
    if (status == AIR_OK && table->owner_count > table->explicit_count &&
        air_owner_table_uses(lighting->owners, table->explicit_count, AIR_METHOD_ORDINATES)) {
        status = add_patches(lighting, table->explicit_count, table->count, out);
        set_mode(lighting->owners, table->explicit_count, since, out);
    }
    return status;
}
