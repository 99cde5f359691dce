#include "scene/light_record.h"

#include "scene/lights/light_build.h"

const char *const air_light_kind_names[AIR_LIGHT_KINDS] = {"point",   "spot",        "collimated",
                                                           "polygon", "environment", "projector"};

static void destroy_light(air_record *record)
{
    air_light_record *light = (air_light_record *)record;
    air_free(record->context, (void *)light->desc.vertices);
    for (size_t i = 0; light->windows != NULL && i < light->desc.window_count; ++i)
        air_free(record->context, (void *)light->windows[i].vertices);
    air_free(record->context, light->windows);
}

/* Copies the arrays that the kind of light looks at; the others may point anywhere. */
static bool copy_arrays(const air_light_desc *desc, air_light_record *record)
{
    air_context *context = record->base.context;
    const bool polygon = desc->kind == AIR_LIGHT_POLYGON;
    bool ok = true;
    record->desc.windows = NULL;
    record->desc.vertices = NULL;
    record->desc.vertex_count = polygon ? desc->vertex_count : 0;
    record->desc.window_count = desc->kind == AIR_LIGHT_COLLIMATED ? desc->window_count : 0;
    if (polygon)
        record->desc.vertices =
            air_record_copy(context, desc->vertices, desc->vertex_count, 3 * sizeof(float), &ok);
    if (record->desc.window_count == 0)
        return ok;
    record->windows = air_allocate(context, record->desc.window_count, sizeof *record->windows);
    if (record->windows == NULL)
        return false;
    record->desc.windows = record->windows;
    for (size_t i = 0; i < record->desc.window_count; ++i) {
        const air_gobo_window *window = &desc->windows[i];
        record->windows[i].vertex_count = window->vertex_count;
        record->windows[i].vertices = air_record_copy(context, window->vertices,
                                                      window->vertex_count, 3 * sizeof(float), &ok);
    }
    return ok;
}

air_status air_light_record_create(air_context *context, const air_light_desc *desc,
                                   air_record **out_record)
{
    const air_status status = air_light_check(context, desc);
    if (status != AIR_OK)
        return status;
    air_light_record *record =
        air_record_create(context, sizeof *record, destroy_light, desc->name);
    if (record == NULL)
        return AIR_ERROR_MEMORY;
    record->desc = *desc;
    record->desc.name = record->base.name;
    if (!copy_arrays(desc, record)) {
        air_record_release(&record->base);
        return air_fail_memory(context, "light");
    }
    *out_record = &record->base;
    return AIR_OK;
}

size_t air_light_links(const air_light_desc *desc, air_link out_links[AIR_MAX_LINKS])
{
    if (desc->kind != AIR_LIGHT_ENVIRONMENT && desc->kind != AIR_LIGHT_PROJECTOR)
        return 0;
    out_links[0] = (air_link){desc->image, AIR_OBJECT_TEXTURE, "image", false};
    return 1;
}

static bool windows_equal(const air_light_desc *a, const air_light_desc *b)
{
    if (a->window_count != b->window_count)
        return false;
    for (size_t i = 0; i < a->window_count; ++i) {
        const size_t n = a->windows[i].vertex_count;
        if (n != b->windows[i].vertex_count ||
            !air_bytes_equal(a->windows[i].vertices, b->windows[i].vertices, n * 3 * sizeof(float)))
            return false;
    }
    return true;
}

static bool shape_equal(const air_light_desc *a, const air_light_desc *b)
{
    switch (a->kind) {
    case AIR_LIGHT_POINT:
        return air_bytes_equal(a->position, b->position, sizeof a->position);
    case AIR_LIGHT_SPOT:
        return air_bytes_equal(a->position, b->position, sizeof a->position) &&
               air_bytes_equal(a->dir, b->dir, sizeof a->dir) &&
               a->inner_cone_rad == b->inner_cone_rad && a->outer_cone_rad == b->outer_cone_rad &&
               a->falloff == b->falloff;
    case AIR_LIGHT_COLLIMATED:
        return air_bytes_equal(a->dir, b->dir, sizeof a->dir) && windows_equal(a, b);
    case AIR_LIGHT_POLYGON:
        return a->vertex_count == b->vertex_count && a->one_sided == b->one_sided &&
               a->camera_visible == b->camera_visible &&
               air_bytes_equal(a->vertices, b->vertices, a->vertex_count * 3 * sizeof(float));
    case AIR_LIGHT_PROJECTOR:
        return a->image == b->image && a->fov_x_rad == b->fov_x_rad &&
               air_bytes_equal(a->position, b->position, sizeof a->position) &&
               air_bytes_equal(a->to_world, b->to_world, sizeof a->to_world);
    case AIR_LIGHT_ENVIRONMENT:
        return a->image == b->image && a->camera_visible == b->camera_visible &&
               air_bytes_equal(a->to_world, b->to_world, sizeof a->to_world);
    }
    return false;
}

bool air_light_equal(const air_light_desc *a, const air_light_desc *b)
{
    return a->kind == b->kind && air_bytes_equal(a->color, b->color, sizeof a->color) &&
           a->casts_shadow == b->casts_shadow && shape_equal(a, b);
}
