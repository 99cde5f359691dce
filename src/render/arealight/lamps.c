#include "render/arealight/lamps.h"

#include <string.h>

#include "core/triple.h"
#include "scene/lights/convex_pieces.h"

/* ---- the shapes of lights ---- */

/* Lights [begin, end) of the table that differ in their triangles only. */
typedef struct light_run {
    size_t begin, end;
} light_run;

static bool is_alike(const air_light *a, const air_light *b)
{
    return a->color.x == b->color.x && a->color.y == b->color.y && a->color.z == b->color.z &&
           a->one_sided == b->one_sided && a->casts_shadow == b->casts_shadow &&
           a->owner == b->owner;
}

/* A light that was added stands alone; emissive triangles follow each other mesh by mesh. */
static light_run find_run(const air_light_table *lights, size_t begin)
{
    light_run out = {begin, begin + 1};
    while (begin >= lights->explicit_count && out.end < lights->count &&
           is_alike(&lights->entries[begin], &lights->entries[out.end])) {
        out.end++;
    }
    return out;
}

/* Does its normal point to where its triangles run clockwise? */
static bool is_mirrored(const air_light *light)
{
    double sum = 0.0, normal[3];
    vec3_store64(normal, light->normal);
    for (size_t i = 0; i < light->triangle_count; i++) {
        double p[3][3], a[3], b[3], cross[3];
        for (int k = 0; k < 3; k++) {
            vec3_store64(p[k], light->triangles[i][k]);
        }
        air_subtract3(p[1], p[0], a);
        air_subtract3(p[2], p[0], b);
        air_cross3(a, b, cross);
        sum += air_dot3(cross, normal);
    }
    return sum < 0.0;
}

/* Counter-clockwise as seen from the front, 3 vertices for each triangle. */
static void store_triangles(const air_light *light, double (*out)[3])
{
    const bool mirrored = is_mirrored(light);
    for (size_t i = 0; i < light->triangle_count; i++) {
        for (size_t k = 0; k < 3; k++) {
            vec3_store64(out[3 * i + k], light->triangles[i][mirrored ? 2 - k : k]);
        }
    }
}

static air_status make_pieces(air_context *context, const air_light_table *lights, light_run run,
                              air_convex_pieces *out)
{
    size_t count = 0, next = 0;
    for (size_t i = run.begin; i < run.end; i++) {
        count += lights->entries[i].triangle_count;
    }
    double(*vertices)[3] = air_allocate(context, count, 3 * sizeof *vertices);
    if (vertices == NULL) {
        return air_fail_memory(context, "arealight: lamps");
    }
    for (size_t i = run.begin; i < run.end; i++) {
        store_triangles(&lights->entries[i], vertices + 3 * next);
        next += lights->entries[i].triangle_count;
    }
    const air_status status =
        air_convex_pieces_make(context, (const double(*)[3])vertices, count, out);
    air_free(context, vertices);
    return status;
}

air_status air_area_lamps_count_emitters(const air_snapshot *snapshot, size_t *out_count)
{
    const air_light_table *lights = &snapshot->lights;
    size_t count = 0;
    light_run run;
    for (size_t i = lights->explicit_count; i < lights->count; i = run.end) {
        air_convex_pieces pieces;
        run = find_run(lights, i);
        const air_status status = make_pieces(snapshot->context, lights, run, &pieces);
        if (status != AIR_OK) {
            return status;
        }
        count += pieces.count;
        air_convex_pieces_finish(snapshot->context, &pieces);
    }
    *out_count = count;
    return AIR_OK;
}

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

/* Room for so many more. */
static air_status reserve(air_with_arealight *with, size_t count)
{
    if (with->lamp_capacity - with->lamp_count >= count) {
        return AIR_OK;
    }
    const size_t capacity = 2 * with->lamp_count + count;
    area_lamp *lamps = air_reallocate(with->context, with->lamps, capacity, sizeof *with->lamps);
    if (lamps == NULL) {
        return air_fail_memory(with->context, "arealight: lamps");
    }
    with->lamps = lamps;
    with->lamp_capacity = capacity;
    return AIR_OK;
}

static air_status add_lamp(air_with_arealight *with, const air_light *light, air_area_mode mode,
                           const double (*corners)[3], size_t count)
{
    air_status status = reserve(with, 1);
    if (status != AIR_OK) {
        return status;
    }
    area_lamp *lamp = &with->lamps[with->lamp_count];
    *lamp = (area_lamp){.mode = mode, .casts_shadow = light->casts_shadow};
    /* What has no area gives no light. */
    if (air_area_lamp_make(NULL, corners, count, !light->one_sided, &lamp->shape) != AIR_OK) {
        return AIR_OK;
    }
    with->lamp_count++;
    lamp->radiance = light->color;
    make_fan(lamp);
    /* Points across the lamp from afar, and near it; a polygon of more corners has them in each
     * triangle of a fan. */
    const bool simple = count <= 4;
    status = make_cubature(with->context, &lamp->shape, simple ? 3 : 2, &lamp->few);
    return status == AIR_OK
               ? make_cubature(with->context, &lamp->shape, simple ? 8 : 4, &lamp->many)
               : status;
}

/* Convex polygons stay as they are. */
static air_status add_whole(air_with_arealight *with, const air_light *light, air_area_mode mode)
{
    double corners[AIR_AREA_MAX_VERTICES][3];
    if (light->vertex_count > AIR_AREA_MAX_VERTICES) {
        return AIR_OK;
    }
    for (size_t i = 0; i < light->vertex_count; i++) {
        vec3_store64(corners[i], light->vertices[i]);
    }
    return add_lamp(with, light, mode, (const double(*)[3])corners, light->vertex_count);
}

static air_status add_pieces(air_with_arealight *with, light_run run, air_area_mode mode)
{
    const air_light_table *lights = &with->snapshot->lights;
    air_convex_pieces pieces;
    air_status status = make_pieces(with->context, lights, run, &pieces);
    size_t begin = 0;
    for (size_t i = 0; i < pieces.count && status == AIR_OK; i++) {
        status = add_lamp(with, &lights->entries[run.begin], mode,
                          (const double(*)[3])pieces.corners + begin, pieces.ends[i] - begin);
        begin = pieces.ends[i];
    }
    air_convex_pieces_finish(with->context, &pieces);
    return status;
}

static air_status add_run(air_with_arealight *with, light_run run, air_area_mode mode)
{
    const size_t before = with->lamp_count;
    air_status status = AIR_OK;
    if (run.begin < with->snapshot->lights.explicit_count) {
        status = add_whole(with, &with->snapshot->lights.entries[run.begin], mode);
    }
    return status == AIR_OK && with->lamp_count == before ? add_pieces(with, run, mode) : status;
}

air_status air_area_lamps_make(air_with_arealight *with, const air_owner_table *owners)
{
    const air_light_table *lights = &with->snapshot->lights;
    air_status status = AIR_OK;
    light_run run;
    for (size_t i = 0; i < lights->count && status == AIR_OK; i = run.end) {
        const air_light *light = &lights->entries[i];
        run = find_run(lights, i);
        if (light->kind == AIR_LIGHT_POLYGON &&
            air_owner_table_uses(owners, light->owner, AIR_METHOD_AREALIGHT)) {
            status = add_run(with, run, (air_area_mode)owners->modes[light->owner]);
        }
    }
    return status;
}

void air_area_lamps_finish(air_with_arealight *with)
{
    for (size_t i = 0; i < with->lamp_count; i++) {
        const area_cubature *both[2] = {&with->lamps[i].few, &with->lamps[i].many};
        for (int k = 0; k < 2; k++) {
            air_free(with->context, both[k]->points);
            air_free(with->context, both[k]->weights);
        }
    }
    air_free(with->context, with->lamps);
}
