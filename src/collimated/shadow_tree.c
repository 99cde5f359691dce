/* shadow_tree.c: making and asking the shadow tree. */
#include "collimated/shadow_tree.h"

#include <math.h>
#include <string.h>

#include "collimated/shadow_build.h"
#include "collimated/shadow_mesh.h"
#include "core/host.h"
#include "core/triple.h"
#include "core/vec.h"

void air_shadow_tree_params_default(air_shadow_tree_params *params)
{
    *params = (air_shadow_tree_params){.leaf_size = 8, .max_depth = 12, .covers = true};
}

/* ---- making ---- */

static air_status check(air_context *context, const air_shadow_tree_params *params)
{
    const double *l = params->to_light;
    const double length = sqrt(air_dot3(l, l));
    if (!(fabs(length - 1.0) <= 1e-6)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "shadow tree: the direction to the light has length %g, expected 1",
                        length);
    }
    if (params->hull == NULL || params->hull_count == 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "shadow tree: the hull has no points");
    }
    for (size_t i = 0; i < 3 * params->hull_count; i++) {
        if (!isfinite(params->hull[i])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "shadow tree: point %zu of the hull is not finite", i / 3);
        }
    }
    if (params->leaf_size < 1 || params->leaf_size > 64 || params->max_depth > SHADOW_DEPTH_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "shadow tree: leaf size %u, depth %u: expected 1 to 64 and at most %d",
                        params->leaf_size, params->max_depth, (int)SHADOW_DEPTH_MAX);
    }
    return AIR_OK;
}

/* Two axes across the light, and the light's own. The first is as near as can be to the coordinate
 * axis that is most across it: rooms are built along these, and boxes of fog then fill the square
 * that the tree covers: with others the atrium's tree has 14 % more bytes. */
static void make_axes(const double to_light[3], double axes[3][3])
{
    const double scale = 1.0 / sqrt(air_dot3(to_light, to_light));
    int least = 0;
    for (int k = 0; k < 3; k++) {
        axes[2][k] = to_light[k] * scale;
        least = fabs(to_light[k]) < fabs(to_light[least]) ? k : least;
    }
    for (int k = 0; k < 3; k++) {
        axes[0][k] = (k == least ? 1.0 : 0.0) - axes[2][least] * axes[2][k];
    }
    const double length = sqrt(air_dot3(axes[0], axes[0]));
    for (int k = 0; k < 3; k++) {
        axes[0][k] /= length;
    }
    air_cross3(axes[2], axes[0], axes[1]);
}

/* Cells are widened by 2e-6 of the domain: ten times the rounding of a point in floats there. */
static const double pad_share = 2e-6;

static void make_frame(const air_shadow_tree_params *params, shadow_frame *out)
{
    double low[3], high[3];
    make_axes(params->to_light, out->axes);
    for (int a = 0; a < 3; a++) {
        low[a] = INFINITY;
        high[a] = -INFINITY;
        for (size_t i = 0; i < params->hull_count; i++) {
            const double at = air_dot3(out->axes[a], params->hull + 3 * i);
            low[a] = fmin(low[a], at);
            high[a] = fmax(high[a], at);
        }
    }
    for (int k = 0; k < 3; k++) {
        out->centre[k] = 0.0;
        for (int a = 0; a < 3; a++) {
            out->centre[k] += out->axes[a][k] * 0.5 * (low[a] + high[a]);
        }
    }
    const double width = fmax(high[0] - low[0], high[1] - low[1]);
    const double size = fmax(width, 1e-6 * (high[2] - low[2]));
    out->pad = pad_share * size + 1e-300;
    out->half[0] = 0.5 * (high[0] - low[0]) + out->pad;
    out->half[1] = 0.5 * (high[1] - low[1]) + out->pad;
    out->side = 2.0 * fmax(out->half[0], out->half[1]);
    out->floor = 0.5 * (low[2] - high[2]) - 1e-6 * (high[2] - low[2] + size);
}

static shadow_walk *choose_walk(air_cpu cpu)
{
    switch (cpu) {
#if defined(__x86_64__)
    case AIR_CPU_AVX512:
        return air_shadow_walk_avx512;
    case AIR_CPU_AVX2:
        return air_shadow_walk_avx2;
    case AIR_CPU_SSE42:
        return air_shadow_walk_sse42;
#endif
    default:
        return air_shadow_walk_c;
    }
}

air_status air_shadow_tree_create(air_context *context, const air_shadow_tree_params *params,
                                  const air_shadow_mesh *meshes, size_t mesh_count,
                                  air_shadow_tree **out_tree)
{
    shadow_mesh mesh;
    *out_tree = NULL;
    air_status status = check(context, params);
    if (status != AIR_OK) {
        return status;
    }
    air_shadow_tree *tree = air_allocate(context, 1, sizeof *tree);
    if (tree == NULL) {
        return air_fail_memory(context, "shadow tree");
    }
    tree->context = context;
    tree->walk = choose_walk(air_context_cpu(context));
    make_frame(params, &tree->frame);
    status = air_shadow_mesh_init(context, &tree->frame, meshes, mesh_count, &mesh);
    if (status == AIR_OK) {
        status = air_shadow_build(params, &mesh, tree);
    }
    air_shadow_mesh_finish(context, &mesh);
    if (status != AIR_OK) {
        air_shadow_tree_destroy(tree);
        return status;
    }
    *out_tree = tree;
    return AIR_OK;
}

void air_shadow_tree_destroy(air_shadow_tree *tree)
{
    if (tree != NULL) {
        air_free(tree->context, tree->nodes);
        air_free(tree->context, tree->triangles);
        air_free(tree->context, tree);
    }
}

size_t air_shadow_tree_size(const air_shadow_tree *tree)
{
    return sizeof *tree + tree->node_count * sizeof *tree->nodes +
           tree->triangle_count * sizeof *tree->triangles;
}

/* ---- asking ---- */

void air_shadow_list_insert(shadow_list *list, float begin, float end)
{
    const double b = (double)begin, e = (double)end;
    size_t first = list->count; /* the first interval that does not end before [begin, end] */
    while (first > 0 && list->intervals[first - 1].end >= b) {
        first--;
    }
    size_t stop = first; /* one past the last that touches it */
    air_interval joined = {b, e};
    while (stop < list->count && list->intervals[stop].begin <= e) {
        joined.begin = double_min(joined.begin, list->intervals[stop].begin);
        joined.end = double_max(joined.end, list->intervals[stop].end);
        stop++;
    }
    if (stop == first && list->count == list->capacity) {
        list->full = true;
        return;
    }
    memmove(&list->intervals[first + 1], &list->intervals[stop],
            (list->count - stop) * sizeof *list->intervals);
    list->intervals[first] = joined;
    list->count = list->count + 1 - (stop - first);
}

static float clamped_inverse(double x)
{
    return (float)double_min(double_max(1.0 / (x + 0.0), -1e20), 1e20); /* of 0 and -0: 1e20 */
}

/* Returns the parameter of the point from which the ray's own counts. */
static double make_ray(const shadow_frame *frame, const double origin[3], const double dir[3],
                       shadow_ray *out)
{
    double o[3], v[3], q[3];
    for (int k = 0; k < 3; k++) {
        q[k] = origin[k] - frame->centre[k];
    }
    for (int a = 0; a < 3; a++) {
        o[a] = air_dot3(frame->axes[a], q);
        v[a] = air_dot3(frame->axes[a], dir);
    }
    const double shift = -air_dot3(o, v);
    for (int a = 0; a < 3; a++) {
        o[a] += shift * v[a];
    }
    double s = sqrt(v[0] * v[0] + v[1] * v[1]), wx = v[0] / s, wy = v[1] / s;
    if (!(s >= 1e-12)) {
        s = 1e-12;
        wx = 1.0;
        wy = 0.0;
    }
    *out = (shadow_ray){.x = (float)o[0],
                        .y = (float)o[1],
                        .z = (float)o[2],
                        .wx = (float)wx,
                        .wy = (float)wy,
                        .s = (float)s,
                        .c = (float)v[2],
                        .inverse_s = (float)(1.0 / s),
                        .inverse_c = clamped_inverse((double)(float)v[2]), /* of c's sign */
                        .qx = (float)(o[0] / frame->side + 0.5),
                        .qy = (float)(o[1] / frame->side + 0.5),
                        .inverse_qx = clamped_inverse(s * wx / frame->side),
                        .inverse_qy = clamped_inverse(s * wy / frame->side),
                        .right = s * wx / frame->side >= 0.0,
                        .up = s * wy / frame->side >= 0.0};
    return shift;
}

/* A query while it is worked on. */
typedef struct asked_ray {
    double shift, from, to; /* the stretch, in the ray's own parameter */
} asked_ray;

static bool make_asked(const air_shadow_tree *tree, const air_shadow_query *query, asked_ray *out,
                       shadow_ray *ray)
{
    out->shift = make_ray(&tree->frame, query->origin, query->dir, ray);
    out->from = query->begin - out->shift;
    out->to = query->end - out->shift;
    ray->begin = (float)out->from;
    ray->end = (float)out->to;
    return out->from < out->to && isfinite(out->from) && isfinite(out->to);
}

/* Ends that are those of the ray are so to the last bit, which can leave nothing of an interval
 * that is one float long. */
static size_t keep_shadows(const air_shadow_query *query, const asked_ray *asked, size_t count)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        const air_interval found = query->out[i];
        const air_interval part = {
            found.begin <= (double)(float)asked->from ? query->begin : found.begin + asked->shift,
            found.end >= (double)(float)asked->to ? query->end : found.end + asked->shift,
        };
        if (part.begin < part.end) {
            query->out[kept++] = part;
        }
    }
    return kept;
}

enum { BATCH = 64 };

static void query_batch(const air_shadow_tree *tree, air_shadow_query *queries, size_t count)
{
    shadow_ray rays[BATCH];
    shadow_list lists[BATCH];
    asked_ray asked[BATCH];
    size_t of[BATCH], n = 0;
    for (size_t i = 0; i < count; i++) {
        queries[i].count = 0;
        if (make_asked(tree, &queries[i], &asked[n], &rays[n])) {
            lists[n] = (shadow_list){.intervals = queries[i].out, .capacity = queries[i].capacity};
            of[n++] = i;
        }
    }
    tree->walk(tree, rays, n, lists);
    for (size_t i = 0; i < n; i++) {
        air_shadow_query *query = &queries[of[i]];
        query->count =
            lists[i].full ? query->capacity + 1 : keep_shadows(query, &asked[i], lists[i].count);
    }
}

void air_shadow_tree_query_rays(const air_shadow_tree *tree, air_shadow_query *queries,
                                size_t count)
{
    for (size_t i = 0; i < count; i += BATCH) {
        query_batch(tree, queries + i, count - i < BATCH ? count - i : BATCH);
    }
}

size_t air_shadow_tree_query(const air_shadow_tree *tree, const double origin[3],
                             const double dir[3], double begin, double end, air_interval *out,
                             size_t capacity)
{
    air_shadow_query query = {.begin = begin, .end = end, .out = out, .capacity = capacity};
    memcpy(query.origin, origin, sizeof query.origin);
    memcpy(query.dir, dir, sizeof query.dir);
    query_batch(tree, &query, 1);
    return query.count;
}
