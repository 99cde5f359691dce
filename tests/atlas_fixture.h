/* atlas_fixture.h: contexts and meshes for the tests of the atlas. */
#ifndef AIR_TESTS_ATLAS_FIXTURE_H
#define AIR_TESTS_ATLAS_FIXTURE_H

#include <math.h>
#include <stdlib.h>

#include "atlas/surface.h"
#include "cmocka_test.h"
#include "core/host.h"
#include "core/random.h"

static inline air_context *atlas_context(size_t threads)
{
    air_context_params params;
    air_context *context = NULL;
    air_context_params_default(&params);
    params.thread_count = threads;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

/* A mesh that owns its arrays. */
typedef struct atlas_mesh {
    float *positions, *uv;
    uint32_t *indices;
    size_t vertex_count, triangle_count;
} atlas_mesh;

static inline void *atlas_zeros(size_t count, size_t size)
{
    void *block = calloc(count + 1, size);
    assert_non_null(block);
    return block;
}

static inline atlas_mesh atlas_mesh_make(size_t vertex_count, size_t triangle_count)
{
    return (atlas_mesh){
        atlas_zeros(3 * vertex_count, sizeof(float)), atlas_zeros(2 * vertex_count, sizeof(float)),
        atlas_zeros(3 * triangle_count, sizeof(uint32_t)), vertex_count, triangle_count};
}

static inline void atlas_mesh_free(atlas_mesh *mesh)
{
    free(mesh->positions);
    free(mesh->uv);
    free(mesh->indices);
}

/* The mesh on a page from texel (x, y) on, with as many texels. */
static inline air_atlas_part atlas_part(const atlas_mesh *mesh, double x, double y, double width,
                                        double height)
{
    return (air_atlas_part){.positions = mesh->positions,
                            .uv = mesh->uv,
                            .indices = mesh->indices,
                            .vertex_count = mesh->vertex_count,
                            .triangle_count = mesh->triangle_count,
                            .offset = {x, y},
                            .size = {width, height}};
}

/* n x n cells of two triangles over the unit square of uv; positions are (u, v, 0). Inner vertices
 * are moved by up to `jitter` of a cell; up to 0.25 no triangle turns over. */
static inline atlas_mesh atlas_grid(size_t n, float jitter, uint32_t seed)
{
    atlas_mesh mesh = atlas_mesh_make((n + 1) * (n + 1), 2 * n * n);
    air_rng rng = air_rng_from_keys(seed, 1);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        const size_t cell[2] = {i % (n + 1), i / (n + 1)};
        for (size_t k = 0; k < 2; k++) {
            const float move = jitter * (2.0f * air_rng_float(&rng) - 1.0f);
            const bool inner = cell[k] > 0 && cell[k] < n;
            mesh.uv[2 * i + k] = ((float)cell[k] + (inner ? move : 0.0f)) / (float)n;
            mesh.positions[3 * i + k] = mesh.uv[2 * i + k];
        }
    }
    for (size_t c = 0; c < n * n; c++) {
        const uint32_t a = (uint32_t)(c / n * (n + 1) + c % n), b = a + (uint32_t)n + 1;
        const uint32_t corners[6] = {a, b, a + 1, a + 1, b, b + 1};
        for (size_t k = 0; k < 6; k++) {
            mesh.indices[6 * c + k] = corners[k];
        }
    }
    return mesh;
}

/* Triangles of their own three vertices each, anywhere in the unit square. */
static inline atlas_mesh atlas_random(size_t triangle_count, float size, uint32_t seed)
{
    atlas_mesh mesh = atlas_mesh_make(3 * triangle_count, triangle_count);
    air_rng rng = air_rng_from_keys(seed, 2);
    for (size_t t = 0; t < triangle_count; t++) {
        const float at[2] = {air_rng_float(&rng) * (1.0f - size),
                             air_rng_float(&rng) * (1.0f - size)};
        for (size_t v = 3 * t; v < 3 * t + 3; v++) {
            for (size_t k = 0; k < 2; k++) {
                mesh.uv[2 * v + k] = at[k] + size * air_rng_float(&rng);
                mesh.positions[3 * v + k] = mesh.uv[2 * v + k];
            }
            mesh.indices[v] = (uint32_t)v;
        }
    }
    return mesh;
}

#endif
