#include "scene/shadows.h"

#include "scene/media/convex.h"
#include "scene/shared.h"

/* A tree, and what it was made for. */
typedef struct air_shadow_record {
    air_record base;
    double to_light[3];
    double low[3], high[3];
    air_shadow_tree *tree;
} air_shadow_record;

void air_shadows_direction(const air_light *light, double out_to_light[3])
{
    const double d[3] = {-(double)light->dir.x, -(double)light->dir.y, -(double)light->dir.z};
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int k = 0; k < 3; ++k)
        out_to_light[k] = d[k] / length;
}

/* ---- parts of a snapshot ---- */

static bool same_direction(const air_light *light, const air_shadow_record *record)
{
    double d[3];
    air_shadows_direction(light, d);
    return d[0] == record->to_light[0] && d[1] == record->to_light[1] &&
           d[2] == record->to_light[2];
}

/* A tree of the previous snapshot that serves the light too, or NULL. */
static air_shadow_record *find_previous(const struct air_shared *previous, const air_light *light)
{
    for (size_t i = 0; i < previous->shadow_count; ++i) {
        air_shadow_record *record = (air_shadow_record *)atomic_load(&previous->shadows[i]);
        if (record != NULL && same_direction(light, record))
            return record;
    }
    return NULL;
}

air_status air_snapshot_set_shadows(air_snapshot *snapshot, const air_snapshot *previous)
{
    struct air_shared *shared = snapshot->shared;
    const size_t count = snapshot->lights.explicit_count;
    const bool same = previous != NULL && previous->shared->accelerator == shared->accelerator &&
                      previous->shared->media == shared->media;
    shared->shadows = air_allocate(snapshot->context, count, sizeof *shared->shadows);
    if (shared->shadows == NULL)
        return air_fail_memory(snapshot->context, "shadows");
    shared->shadow_count = count;
    for (size_t i = 0; i < count; ++i) {
        const air_light *light = &snapshot->lights.entries[i];
        air_shadow_record *record = same && light->kind == AIR_LIGHT_COLLIMATED
                                        ? find_previous(previous->shared, light)
                                        : NULL;
        if (record != NULL)
            air_record_retain(&record->base);
        atomic_init(&shared->shadows[i], (air_record *)record);
    }
    return AIR_OK;
}

/* ---- making one ---- */

static void destroy_shadow(air_record *record)
{
    air_shadow_tree_destroy(((air_shadow_record *)record)->tree);
}

static bool casts(const air_mesh *mesh)
{
    return (mesh->mask & AIR_MASK_SHADOW_OPAQUE) != 0 && mesh->triangle_count > 0;
}

/* ---- where shadows can lie ---- */

/* A region is cut to the prism that the box around the meshes sweeps along the light: two planes
 * across each of two axes, and one above. */
enum { PRISM_PLANES = 5 };

static void prism_planes(const air_snapshot *snapshot, const air_light *light, air_plane *out)
{
    const air_vec3 axes[3] = {light->frame.s, light->frame.t, vec3_neg(light->dir)};
    for (int a = 0; a < 3; ++a) {
        float low = INFINITY, high = -INFINITY;
        for (int corner = 0; corner < 8; ++corner) {
            const float *low3 = snapshot->bounds_min, *high3 = snapshot->bounds_max;
            const air_vec3 p =
                vec3((corner & 1) != 0 ? high3[0] : low3[0], (corner & 2) != 0 ? high3[1] : low3[1],
                     (corner & 4) != 0 ? high3[2] : low3[2]);
            low = fminf(low, vec3_dot(axes[a], p));
            high = fmaxf(high, vec3_dot(axes[a], p));
        }
        const float margin = 1e-3f * (high - low) + 1e-5f * (fabsf(high) + fabsf(low));
        out[2 * a] = (air_plane){axes[a], high + margin};
        if (a < 2)
            out[2 * a + 1] = (air_plane){vec3_neg(axes[a]), margin - low};
    }
}

/* The bounds of the part of a region that shadows can reach; false if there is none. */
static bool reach(const air_snapshot *snapshot, const air_region *region, const air_light *light,
                  float low[3], float high[3])
{
    air_plane planes[AIR_MAX_PLANES + 2 + PRISM_PLANES];
    const size_t count = region->plane_count;
    if (count + PRISM_PLANES > AIR_MAX_PLANES)
        return air_convex_bounds(region->planes, count, low, high);
    for (size_t i = 0; i < count; ++i)
        planes[i] = region->planes[i];
    prism_planes(snapshot, light, planes + count);
    return air_convex_bounds(planes, count + PRISM_PLANES, low, high);
}

/* The box around what shadows can reach in any medium; low > high if nothing. */
static void reach_all(const air_snapshot *snapshot, const air_light *light, double low[3],
                      double high[3])
{
    for (int k = 0; k < 3; ++k) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t r = 0; r < snapshot->media.region_count; ++r) {
        float from[3], to[3];
        if (!reach(snapshot, &snapshot->media.regions[r], light, from, to))
            continue;
        for (int k = 0; k < 3; ++k) {
            low[k] = fmin(low[k], (double)from[k]);
            high[k] = fmax(high[k], (double)to[k]);
        }
    }
}

bool air_shadows_end(const air_snapshot *snapshot, size_t light)
{
    double low[3], high[3];
    reach_all(snapshot, &snapshot->lights.entries[light], low, high);
    for (int k = 0; k < 3; ++k) {
        if (low[k] == -INFINITY || high[k] == INFINITY)
            return false;
    }
    return true;
}

static air_status build_tree(const air_snapshot *snapshot, const air_light *light,
                             air_shadow_record *record)
{
    air_context *context = snapshot->context;
    double corners[8][3];
    air_shadow_tree_params params;
    size_t count = 0;
    reach_all(snapshot, light, record->low, record->high);
    if (!(record->low[0] <= record->high[0]))
        return AIR_OK;
    for (int k = 0; k < 3; ++k) { /* the bounds are rounded, and so are the ends of rays */
        const double size = record->high[k] - record->low[k];
        const double margin = 1e-6 * (size + fabs(record->low[k]) + fabs(record->high[k]));
        record->low[k] -= margin;
        record->high[k] += margin;
    }
    air_shadow_mesh *meshes = air_allocate(context, snapshot->mesh_count, sizeof *meshes);
    if (meshes == NULL)
        return air_fail_memory(context, "shadows");
    for (size_t i = 0; i < snapshot->mesh_count; ++i) {
        const air_mesh *mesh = snapshot->meshes[i];
        if (casts(mesh))
            meshes[count++] = (air_shadow_mesh){mesh->positions, mesh->vertex_count, mesh->indices,
                                                mesh->triangle_count};
    }
    for (int corner = 0; corner < 8; ++corner) {
        for (int k = 0; k < 3; ++k)
            corners[corner][k] = (corner >> k & 1) != 0 ? record->high[k] : record->low[k];
    }
    air_shadow_tree_params_default(&params);
    for (int k = 0; k < 3; ++k)
        params.to_light[k] = record->to_light[k];
    params.hull = corners[0];
    params.hull_count = 8;
    const air_status status =
        count == 0 ? AIR_OK
                   : air_shadow_tree_create(context, &params, meshes, count, &record->tree);
    air_free(context, meshes);
    return status;
}

air_status air_snapshot_shadows(const air_snapshot *snapshot, size_t light, air_shadow_view *out)
{
    _Atomic(air_record *) *slot = &snapshot->shared->shadows[light];
    air_record *expected = NULL, *known = atomic_load(slot);
    if (known == NULL) {
        const air_light *entry = &snapshot->lights.entries[light];
        air_shadow_record *record =
            air_record_create(snapshot->context, sizeof *record, destroy_shadow, NULL);
        if (record == NULL)
            return AIR_ERROR_MEMORY;
        air_shadows_direction(entry, record->to_light);
        const air_status status = build_tree(snapshot, entry, record);
        if (status != AIR_OK) {
            air_record_release(&record->base);
            return status;
        }
        known = &record->base;
        if (!atomic_compare_exchange_strong(slot, &expected, known)) {
            air_record_release(known); /* another thread was first */
            known = expected;
        }
    }
    const air_shadow_record *record = (const air_shadow_record *)known;
    out->tree = record->tree;
    for (int k = 0; k < 3; ++k) {
        out->low[k] = record->low[k];
        out->high[k] = record->high[k];
    }
    return AIR_OK;
}
