/* shadow.h: which stretches of a ray lie in shadow of a light from infinity, exactly.
 *
 * A point is in shadow iff something lies above it, seen along the unit vector to_light. Spheres
 * and convex polyhedra give one interval in closed form; triangle meshes go into a shadow tree: a
 * quadtree over the plane perpendicular to the light that knows between which heights each cell
 * decides by itself, with exact triangles where it does not. Nothing but time depends on its
 * resolution: results are exact to the rounding of floats, without cracks and without an epsilon.
 * Winding, sidedness and watertightness play no part. */
#ifndef AIRLIGHT_SHADOW_H
#define AIRLIGHT_SHADOW_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/context.h"
#include "airlight/interval.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- one convex occluder, in closed form, doubles ---- */

/* The stretch of origin + t dir, dir unit, t in [begin, end], that a ball shadows (the inside of
 * the ball counts as shadowed); false if none. The shadowed set, ball and half cylinder under it,
 * is convex. */
AIR_API bool air_shadow_sphere(const double center[3], double radius, const double to_light[3],
                               const double origin[3], const double dir[3], double begin,
                               double end, air_interval *out);

/* The same for a convex polyhedron, given by its planes n.x <= h: 4 doubles each, n of any length,
 * pointing out. Redundant planes are harmless; without an inside it throws no shadow. Takes time in
 * proportion to plane_count squared. */
AIR_API bool air_shadow_polyhedron(const double (*planes)[4], size_t plane_count,
                                   const double to_light[3], const double origin[3],
                                   const double dir[3], double begin, double end,
                                   air_interval *out);

/* ---- triangle meshes ---- */

/* World space, 3 floats per vertex, 3 indices per triangle; borrowed while the tree is made. */
typedef struct air_shadow_mesh {
    const float *positions;
    size_t vertex_count;
    const uint32_t *indices;
    size_t triangle_count;
} air_shadow_mesh;

typedef struct air_shadow_tree air_shadow_tree;

typedef struct air_shadow_tree_params {
    double to_light[3]; /* unit */
    /* Queries are about points in the convex hull of these (the corners of the medium): 3 doubles
     * each, at least one, finite. What lies below them throws no shadow on them. */
    const double *hull;
    size_t hull_count;
    uint32_t leaf_size; /* triangles below which a cell is not divided, [1, 64]; default 8. Below 4
                           a cell under an edge divides to the last level: memory explodes */
    uint32_t max_depth; /* [0, 16]; default 12 */
    bool covers;        /* let patches of triangles close cells; false only for tests */
} air_shadow_tree_params;

/* leaf_size 8, max_depth 12, covers, everything else 0. */
AIR_API void air_shadow_tree_params_default(air_shadow_tree_params *params);

/* Builds the tree over all meshes together, in parallel where the context has threads; the same
 * tree for any number of them. AIR_ERROR_ARGUMENT: to_light is not
 * unit within 1e-6, no hull, a number that is not finite, an index or parameter out of range;
 * AIR_ERROR_UNSUPPORTED: more than 2^28 triangles; AIR_ERROR_MEMORY. On failure *out_tree is NULL.
 * The tree copies what it needs. */
AIR_API air_status air_shadow_tree_create(air_context *context,
                                          const air_shadow_tree_params *params,
                                          const air_shadow_mesh *meshes, size_t mesh_count,
                                          air_shadow_tree **out_tree);
AIR_API void air_shadow_tree_destroy(air_shadow_tree *tree); /* NULL is legal */

/* Bytes the tree holds. */
AIR_API size_t air_shadow_tree_size(const air_shadow_tree *tree);

/* One ray and what is found along it. */
typedef struct air_shadow_query {
    double origin[3], dir[3]; /* dir unit; the ray must lie in the hull for t in [begin, end] */
    double begin, end;
    air_interval *out; /* the shadowed stretches: sorted, disjoint; has room for capacity of them */
    size_t capacity;
    size_t count; /* how many there are; when that is above capacity, out holds garbage: ask for
                     [begin, m] and [m, end] one by one, whose union is the answer */
} air_shadow_query;

/* Answers count queries. Each finds what it finds alone, to the bit; neighbouring rays next to each
 * other in the array go through the tree together and are faster for it. Thread-safe. */
AIR_API void air_shadow_tree_query_rays(const air_shadow_tree *tree, air_shadow_query *queries,
                                        size_t count);

/* The same for one ray; returns its count. */
AIR_API size_t air_shadow_tree_query(const air_shadow_tree *tree, const double origin[3],
                                     const double dir[3], double begin, double end,
                                     air_interval *out, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
