/* surface.h: what a ray met: position, normals, texture coordinates, material, as a shading point.
 */
#ifndef AIR_SCENE_SURFACE_H
#define AIR_SCENE_SURFACE_H

#include "scene/bsdf.h"
#include "scene/snapshot.h"

typedef struct air_surface {
    air_vec3 position; /* from barycentrics, not from t */
    air_vec3
        normal;    /* unit geometric normal on the front side of the triangle (counter-clockwise) */
    air_bsdf bsdf; /* faces the incoming ray */
    air_vec3 emission; /* radiance towards -ray direction; 0 where not emitting on this side */
    uint32_t emitter;  /* light table entry of this triangle, UINT32_MAX if it is none */
    float alpha;       /* coverage, 1 = opaque (MASK already decided: 0 or 1) */
    float offset;      /* distance by which a new ray origin must leave the surface */
} air_surface;

/* Fills *out for a hit of a ray that travels along dir. */
void air_surface_make(const air_snapshot *snapshot, const air_hit *hit, air_vec3 dir,
                      air_surface *out);

/* In m^2. */
static inline double air_mesh_triangle_area(const air_mesh *mesh, size_t triangle)
{
    const uint32_t *at = mesh->indices + 3 * triangle;
    const air_vec3 p = vec3_load(mesh->positions + 3 * (size_t)at[0]);
    const air_vec3 a = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[1]), p);
    const air_vec3 b = vec3_sub(vec3_load(mesh->positions + 3 * (size_t)at[2]), p);
    return 0.5 * (double)vec3_length(vec3_cross(a, b));
}

/* A point of a mesh of triangles, seen from the front of its triangle, without its material:
 * weights are those of vertices 1 and 2. normal: the interpolated one, unit. False for a triangle
 * without area. */
typedef struct air_surface_place {
    air_vec3 position, normal, geometric;
    float offset;
} air_surface_place;
bool air_surface_place_make(const air_mesh *mesh, uint32_t triangle, float u, float v,
                            air_surface_place *out);

/* Only the coverage of a hit, for shadow rays. */
float air_surface_alpha(const air_snapshot *snapshot, const air_hit *hit);

/* The origin of a ray that leaves the surface towards dir. */
static inline air_vec3 air_surface_origin(const air_surface *surface, air_vec3 dir)
{
    const float side = vec3_dot(surface->normal, dir) >= 0.0f ? surface->offset : -surface->offset;
    return vec3_madd(surface->position, side, surface->normal);
}

#endif
