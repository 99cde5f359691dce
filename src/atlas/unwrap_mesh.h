/* unwrap_mesh.h: a mesh as unwrap.h's steps see it: normals and neighbours of triangles. */
#ifndef AIR_ATLAS_UNWRAP_MESH_H
#define AIR_ATLAS_UNWRAP_MESH_H

#include "core/host.h"

typedef struct air_unwrap_mesh {
    const float *positions;
    const uint32_t *indices;
    size_t vertex_count, triangle_count;
    double *normals; /* 3 per triangle: unit, 0 where it has no area */
    double *areas;
    uint32_t *first_neighbour; /* per triangle and one more */
    uint32_t *neighbours;      /* triangles over a shared side */
    double tolerance;          /* metres: what rounding of positions may do to a gap */
} air_unwrap_mesh;

/* Fails for want of memory only, without a message. */
air_status air_unwrap_mesh_init(air_context *context, const float *positions, size_t vertex_count,
                                const uint32_t *indices, size_t triangle_count,
                                air_unwrap_mesh *out_mesh);
void air_unwrap_mesh_finish(air_context *context, air_unwrap_mesh *mesh);

/* Corner `corner` of triangle t along two axes. */
static inline void air_unwrap_mesh_project(const air_unwrap_mesh *mesh, size_t t, size_t corner,
                                           const double s[3], const double u[3], double out[2])
{
    const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * t + corner];
    const double x = (double)p[0], y = (double)p[1], z = (double)p[2];
    out[0] = s[0] * x + s[1] * y + s[2] * z;
    out[1] = u[0] * x + u[1] * y + u[2] * z;
}

#endif
