#include "bake/cache_grid.h"

#include <stdlib.h>

#include "core/host.h"

enum {
    FLAT_RESOLUTION = 8, /* cells across a layer */
    LAMP_RESOLUTION = 12,
    FAR_RESOLUTION = 8,
    LEAST_RESOLUTION = 8,
    MOST_RESOLUTION = 64,
    MOST_GRIDS = 10
};

typedef struct box {
    air_vec3 low, high;
} box;

static bool box_is_empty(box b)
{
    return !(b.low.x <= b.high.x && b.low.y <= b.high.y && b.low.z <= b.high.z);
}

static box box_add(box b, air_vec3 p)
{
    return (box){vec3(fminf(b.low.x, p.x), fminf(b.low.y, p.y), fminf(b.low.z, p.z)),
                 vec3(fmaxf(b.high.x, p.x), fmaxf(b.high.y, p.y), fmaxf(b.high.z, p.z))};
}

static box box_grow(box b, float margin)
{
    return (box){vec3_sub(b.low, vec3_set1(margin)), vec3_add(b.high, vec3_set1(margin))};
}

static box box_cut(box a, box b)
{
    return (box){
        vec3(fmaxf(a.low.x, b.low.x), fmaxf(a.low.y, b.low.y), fmaxf(a.low.z, b.low.z)),
        vec3(fminf(a.high.x, b.high.x), fminf(a.high.y, b.high.y), fminf(a.high.z, b.high.z))};
}

static float box_side(box b)
{
    return float_max(b.high.x - b.low.x, float_max(b.high.y - b.low.y, b.high.z - b.low.z));
}

/* Surfaces and lamps. */
static box scene_box(const air_snapshot *snapshot)
{
    box b = {vec3_load(snapshot->bounds_min), vec3_load(snapshot->bounds_max)};
    for (size_t i = 0; i < snapshot->lights.explicit_count; i++) {
        const air_light *light = &snapshot->lights.entries[i];
        if (air_light_is_placed(light)) {
            b = box_is_empty(b) ? (box){light->position, light->position}
                                : box_add(b, light->position);
        }
    }
    return b;
}

/* `resolution` cells along the longest side; cubes, but layers get at least FLAT_RESOLUTION across,
 * for that is where their light varies. */
static void lay_out(box b, uint32_t resolution, air_cache_grid *out)
{
    const float extent[3] = {b.high.x - b.low.x, b.high.y - b.low.y, b.high.z - b.low.z};
    const float cell = box_side(b) / (float)resolution;
    const uint32_t least = resolution < FLAT_RESOLUTION ? resolution : FLAT_RESOLUTION;
    float step[3];
    for (int k = 0; k < 3; k++) {
        const float cells = cell > 0.0f ? ceilf(extent[k] / cell - 1e-3f) : 1.0f;
        out->size[k] = cells > (float)least ? (uint32_t)cells : extent[k] > 0.0f ? least : 1;
        step[k] = float_max(extent[k], 0.0f) / (float)out->size[k];
    }
    out->step = vec3(step[0], step[1], step[2]);
    out->low = vec3_madd(b.low, 0.5f, out->step);
}

static float cell_of(const air_cache_grid *g)
{
    return float_max(g->step.x, float_max(g->step.y, g->step.z));
}

/* A lamp's centre and reach. False for what has none. */
static bool lamp_of(const air_light *light, air_vec3 *out_center, float *out_radius)
{
    *out_center = light->position;
    *out_radius = 0.0f;
    if (air_light_is_placed(light)) {
        return true;
    }
    if (light->kind != AIR_LIGHT_POLYGON || light->vertex_count == 0) {
        return false;
    }
    air_vec3 sum = vec3_set1(0.0f);
    for (size_t i = 0; i < light->vertex_count; i++) {
        sum = vec3_add(sum, light->vertices[i]);
    }
    *out_center = vec3_scale(sum, 1.0f / (float)light->vertex_count);
    *out_radius = sqrtf(light->area);
    return true;
}

/* Is the point well inside of a grid whose cells are no larger, and that is not much smaller than
 * the box? */
static bool has_finer(const air_cache_grids *m, air_vec3 p, float cell, float side)
{
    for (size_t i = 0; i < m->count; i++) {
        const air_cache_grid *g = &m->grids[i];
        const air_vec3 d = vec3_sub(p, g->low);
        const float reach[3] = {g->step.x * (float)g->size[0], g->step.y * (float)g->size[1],
                                g->step.z * (float)g->size[2]};
        const float at[3] = {d.x, d.y, d.z};
        const float most = float_max(reach[0], float_max(reach[1], reach[2]));
        bool inside = cell_of(g) <= cell * 1.01f && most > 0.5f * side;
        for (int k = 0; k < 3; k++) {
            inside = inside && at[k] > 0.25f * reach[k] && at[k] < 0.75f * reach[k];
        }
        if (inside) {
            return true;
        }
    }
    return false;
}

/* About a lamp light varies over distances in proportion to the distance from it: boxes, each half
 * as large as the one before, until cells are a third of the mean free path or of the way to the
 * nearest wall, or of the lamp's own size. All are finer than the grid that holds all, to which
 * is left what lies in none of them. */
static void add_lamp(const air_medium *medium, box bounds, air_vec3 center, float radius,
                     float wall, float coarsest, air_cache_grids *m)
{
    const float extinction = vec3_max(medium->sigma_t);
    const float path = extinction > 0.0f ? 1.0f / extinction : INFINITY;
    const float finest = float_max(float_min(path, wall), radius) * (1.0f / 3.0f);
    for (float half = 0.25f * box_side(bounds);
         m->count < MOST_GRIDS - 1 && 2.0f * half / LAMP_RESOLUTION > 0.5f * finest; half *= 0.5f) {
        const box b = box_cut(box_grow((box){center, center}, half), bounds);
        air_cache_grid *g = &m->grids[m->count];
        if (box_is_empty(b) || !(box_side(b) > 0.0f)) {
            return;
        }
        lay_out(b, LAMP_RESOLUTION, g);
        if (cell_of(g) < coarsest && !has_finer(m, center, cell_of(g), box_side(b))) {
            m->count++;
        }
    }
}

/* The distance from a lamp to the nearest surface, by some rays. */
static float wall_distance(const air_snapshot *snapshot, air_vec3 from)
{
    const air_ray_backend *rays = air_context_ray_backend(snapshot->context);
    float nearest = INFINITY;
    for (int i = 0; i < 26 && snapshot->accelerator != NULL; i++) {
        const int k = i < 13 ? i : i + 1;
        const air_vec3 dir =
            vec3_normalize(vec3((float)(k % 3 - 1), (float)(k / 3 % 3 - 1), (float)(k / 9 - 1)));
        const air_ray ray = {
            {from.x, from.y, from.z}, 1e-3f, {dir.x, dir.y, dir.z}, 3e38f, AIR_MASK_SCATTER};
        air_hit hit;
        rays->intersect(snapshot->accelerator, &ray, 1, &hit);
        if (hit.mesh != (uint32_t)AIR_NO_HIT && hit.t > 1e-2f) {
            nearest = float_min(nearest, hit.t);
        }
    }
    return nearest;
}

static int by_cell(const void *a, const void *b)
{
    const float x = cell_of(a), y = cell_of(b);
    return x < y ? -1 : x > y;
}

/* The part of a medium that is near the scene, and what lies within four mean free paths. */
static void near_and_far(const air_snapshot *snapshot, const air_medium *medium, box *out_near,
                         box *out_far)
{
    const float extinction = vec3_max(medium->sigma_t);
    const float path = extinction > 0.0f ? 1.0f / extinction : 0.0f;
    box scene = scene_box(snapshot);
    if (box_is_empty(scene)) {
        scene = (box){vec3_set1(-path), vec3_set1(path)};
    }
    const float side = float_max(box_side(scene), 1e-3f * path);
    const box medium_box = {vec3_load(medium->bounds_min), vec3_load(medium->bounds_max)};
    const float margin = float_min(0.25f * side, 2.0f * path) + 1e-3f * path;
    *out_near = box_cut(box_grow(scene, margin), medium_box);
    *out_far = box_cut(box_grow(scene, 4.0f * path), medium_box);
}

double air_cache_scene_points(const air_snapshot *snapshot, uint32_t resolution)
{
    double count = 0.0;
    for (size_t i = 0; i < snapshot->media.count; i++) {
        air_cache_grid g;
        box near, far;
        near_and_far(snapshot, &snapshot->media.media[i], &near, &far);
        if (!box_is_empty(near)) {
            lay_out(near, resolution, &g);
            count += (double)air_cache_point_count(&g);
        }
    }
    return count;
}

uint32_t air_cache_resolution(const air_snapshot *snapshot, double points)
{
    uint32_t resolution = MOST_RESOLUTION;
    while (resolution > LEAST_RESOLUTION && air_cache_scene_points(snapshot, resolution) > points) {
        resolution -= 2;
    }
    return resolution;
}

air_status air_cache_grids_place(air_context *context, const air_snapshot *snapshot,
                                 const air_medium *medium, uint32_t resolution,
                                 air_cache_grids *out_grids)
{
    air_cache_grids m = {air_allocate(context, MOST_GRIDS, sizeof *m.grids), 0};
    box near, far;
    if (m.grids == NULL) {
        return air_fail_memory(context, "light in media");
    }
    near_and_far(snapshot, medium, &near, &far);
    if (!box_is_empty(near)) { /* else nothing of it is near anything */
        const bool reaches = box_side(far) > 1.5f * box_side(near);
        air_cache_grid all = {.points = NULL};
        lay_out(near, resolution, &m.grids[m.count++]);
        lay_out(far, resolution < FAR_RESOLUTION ? resolution : FAR_RESOLUTION, &all);
        const float coarsest = cell_of(reaches ? &all : &m.grids[0]);
        for (size_t i = 0; i < snapshot->lights.count && m.count < MOST_GRIDS - 1; i++) {
            air_vec3 center;
            float radius;
            if (lamp_of(&snapshot->lights.entries[i], &center, &radius)) {
                add_lamp(medium, far, center, radius, wall_distance(snapshot, center), coarsest,
                         &m);
            }
        }
        if (reaches) {
            m.grids[m.count++] = all;
        }
        qsort(m.grids, m.count, sizeof *m.grids, by_cell);
    }
    *out_grids = m;
    return AIR_OK;
}

void air_cache_grids_finish(air_context *context, air_cache_grids *grids)
{
    for (size_t i = 0; i < grids->count; i++) {
        air_free(context, grids->grids[i].points);
        air_free(context, grids->grids[i].sight);
    }
    air_free(context, grids->grids);
}
