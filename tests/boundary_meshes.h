/* boundary_meshes.h: closed meshes for tests of medium boundaries. */
#ifndef AIR_TESTS_BOUNDARY_MESHES_H
#define AIR_TESTS_BOUNDARY_MESHES_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "core/vec.h"

enum { MESH_MAX_VERTICES = 4096, MESH_MAX_TRIANGLES = 8192 };

typedef struct test_mesh {
    float positions[3 * MESH_MAX_VERTICES];
    size_t vertex_count;
    uint32_t indices[3 * MESH_MAX_TRIANGLES];
    size_t triangle_count;
} test_mesh;

static inline uint32_t mesh_vertex(test_mesh *mesh, float x, float y, float z)
{
    vec3_store(mesh->positions + 3 * mesh->vertex_count, vec3(x, y, z));
    return (uint32_t)mesh->vertex_count++;
}

static inline void mesh_triangle(test_mesh *mesh, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *out = mesh->indices + 3 * mesh->triangle_count++;
    out[0] = a;
    out[1] = b;
    out[2] = c;
}

/* The cube [-1,1]^3, outwards, each face with vertices of its own as exporters write it. */
static inline void mesh_add_cube(test_mesh *mesh)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int side = -1; side <= 1; side += 2) {
            uint32_t v[4];
            for (int n = 0; n < 4; n++) {
                float p[3];
                p[axis] = (float)side;
                p[(axis + 1) % 3] = n == 1 || n == 2 ? 1.0f : -1.0f;
                p[(axis + 2) % 3] = n >= 2 ? 1.0f : -1.0f;
                v[n] = mesh_vertex(mesh, p[0], p[1], p[2]);
            }
            mesh_triangle(mesh, v[0], v[side > 0 ? 1 : 2], v[side > 0 ? 2 : 1]);
            mesh_triangle(mesh, v[0], v[side > 0 ? 2 : 3], v[side > 0 ? 3 : 2]);
        }
    }
}

/* A torus around z, outwards. */
static inline void mesh_add_torus(test_mesh *mesh, float ring, float tube, uint32_t nu, uint32_t nv)
{
    const uint32_t base = (uint32_t)mesh->vertex_count;
    for (uint32_t i = 0; i < nu; i++) {
        for (uint32_t j = 0; j < nv; j++) {
            const float u = 2.0f * AIR_PI_F * (float)i / (float)nu,
                        v = 2.0f * AIR_PI_F * (float)j / (float)nv;
            const float r = ring + tube * cosf(v);
            mesh_vertex(mesh, r * cosf(u), r * sinf(u), tube * sinf(v));
        }
    }
    for (uint32_t i = 0; i < nu; i++) {
        for (uint32_t j = 0; j < nv; j++) {
            const uint32_t a = base + i * nv + j, b = base + (i + 1) % nu * nv + j;
            const uint32_t c = base + (i + 1) % nu * nv + (j + 1) % nv,
                           d = base + i * nv + (j + 1) % nv;
            mesh_triangle(mesh, a, b, c);
            mesh_triangle(mesh, a, c, d);
        }
    }
}

/* The icosahedron in the unit sphere, outwards, each triangle split into four `levels` times. */
static inline void mesh_add_icosphere(test_mesh *mesh, int levels)
{
    static const uint32_t faces[20][3] = {
        {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    const float g = 1.6180339887f, s = 1.0f / sqrtf(1.0f + g * g);
    const float corners[12][3] = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                  {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                  {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    test_mesh from = {.vertex_count = 0}, to;
    for (int n = 0; n < 12; n++) {
        mesh_vertex(&from, s * corners[n][0], s * corners[n][1], s * corners[n][2]);
    }
    for (int n = 0; n < 20; n++) {
        mesh_triangle(&from, faces[n][0], faces[n][1], faces[n][2]);
    }
    for (int level = 0; level < levels; level++, from = to) {
        to.vertex_count = to.triangle_count = 0;
        for (size_t t = 0; t < from.triangle_count; t++) {
            uint32_t v[6]; /* corners, then midpoints; equal midpoints come out equal to the bit */
            for (int n = 0; n < 3; n++) {
                const air_vec3 a = vec3_load(from.positions + 3 * from.indices[3 * t + (size_t)n]);
                const air_vec3 b =
                    vec3_load(from.positions + 3 * from.indices[3 * t + (size_t)(n + 1) % 3]);
                const air_vec3 m = vec3_normalize(vec3_add(a, b));
                v[n] = mesh_vertex(&to, a.x, a.y, a.z);
                v[n + 3] = mesh_vertex(&to, m.x, m.y, m.z);
            }
            mesh_triangle(&to, v[0], v[3], v[5]);
            mesh_triangle(&to, v[3], v[1], v[4]);
            mesh_triangle(&to, v[5], v[4], v[2]);
            mesh_triangle(&to, v[3], v[4], v[5]);
        }
    }
    const uint32_t base = (uint32_t)mesh->vertex_count;
    for (size_t n = 0; n < from.vertex_count; n++) {
        mesh_vertex(mesh, from.positions[3 * n], from.positions[3 * n + 1],
                    from.positions[3 * n + 2]);
    }
    for (size_t t = 0; t < from.triangle_count; t++) {
        mesh_triangle(mesh, base + from.indices[3 * t], base + from.indices[3 * t + 1],
                      base + from.indices[3 * t + 2]);
    }
}

/* Maps the vertices from `first` on. */
static inline void mesh_transform(test_mesh *mesh, size_t first, const float map[12])
{
    for (size_t v = first; v < mesh->vertex_count; v++) {
        vec3_store(mesh->positions + 3 * v, affine_point(map, vec3_load(mesh->positions + 3 * v)));
    }
}

/* Turns the triangles from `first` to `end` around. */
static inline void mesh_flip(test_mesh *mesh, size_t first, size_t end)
{
    for (size_t t = first; t < end; t++) {
        const uint32_t b = mesh->indices[3 * t + 1];
        mesh->indices[3 * t + 1] = mesh->indices[3 * t + 2];
        mesh->indices[3 * t + 2] = b;
    }
}

#endif
