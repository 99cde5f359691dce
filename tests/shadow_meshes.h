/* shadow_meshes.h: meshes for tests of shadows: each triangle has three vertices of its own. */
#ifndef AIR_TESTS_SHADOW_MESHES_H
#define AIR_TESTS_SHADOW_MESHES_H

#include "airlight/shadow.h"
#include "collimated_fixture.h"

enum { MOST_TRIANGLES = 8192 + 64 };

typedef struct loose_mesh {
    size_t count;
    float positions[9 * MOST_TRIANGLES];
    uint32_t indices[3 * MOST_TRIANGLES];
} loose_mesh;

static inline air_shadow_mesh borrow_mesh(loose_mesh *self)
{
    for (uint32_t i = 0; i < 3 * self->count; i++) {
        self->indices[i] = i;
    }
    return (air_shadow_mesh){self->positions, 3 * self->count, self->indices, self->count};
}

static inline void add_triangle(loose_mesh *self, const float a[3], const float b[3],
                                const float c[3])
{
    float *p = self->positions + 9 * self->count++;
    memcpy(p, a, 3 * sizeof *p);
    memcpy(p + 3, b, 3 * sizeof *p);
    memcpy(p + 6, c, 3 * sizeof *p);
}

/* The point of the octahedron's face (signs) with coordinates i, j, n - i - j, on the sphere. */
static inline void sphere_point(const double centre[3], double radius, const int signs[3], int n,
                                int i, int j, float out[3])
{
    const double p[3] = {i, j, n - i - j};
    const double scale = radius / sqrt(dot(p, p));
    for (int k = 0; k < 3; k++) {
        out[k] = (float)(centre[k] + signs[k] * scale * p[k]);
    }
}

/* An octahedron, each edge divided by n, blown up: 8 n^2 triangles, corners equal to the bit. */
static inline void make_sphere(loose_mesh *out, const double centre[3], double radius, int n)
{
    out->count = 0;
    for (int octant = 0; octant < 8; octant++) {
        const int signs[3] = {1 - 2 * (octant & 1), 1 - (octant & 2), 1 - (octant & 4) / 2};
        for (int i = 0; i < n; i++) {
            for (int j = 0; i + j < n; j++) {
                float a[3], b[3], c[3], d[3];
                sphere_point(centre, radius, signs, n, i, j, a);
                sphere_point(centre, radius, signs, n, i + 1, j, b);
                sphere_point(centre, radius, signs, n, i, j + 1, c);
                add_triangle(out, a, b, c);
                if (i + j < n - 1) {
                    sphere_point(centre, radius, signs, n, i + 1, j + 1, d);
                    add_triangle(out, b, d, c);
                }
            }
        }
    }
}

/* Triangles of all sizes and shapes about the middle of the cube [-1, 1]^3. */
static inline void make_soup(loose_mesh *out, size_t count, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, 77);
    out->count = 0;
    while (out->count < count) {
        const double size = exp(random_between(&rng, log(0.01), log(0.5)));
        float p[3][3];
        for (int i = 0; i < 3; i++) {
            const double at = random_between(&rng, -0.9, 0.9);
            for (int k = 0; k < 3; k++) {
                p[k][i] = (float)(at + size * random_between(&rng, -1.0, 1.0));
            }
        }
        add_triangle(out, p[0], p[1], p[2]);
    }
}

/* Moves every corner of every triangle by itself. */
static inline void tear(loose_mesh *mesh, double by)
{
    air_rng rng = air_rng_from_keys(3, 77);
    for (size_t i = 0; i < 9 * mesh->count; i++) {
        mesh->positions[i] += (float)random_between(&rng, -by, by);
    }
}

static inline void remove_share(loose_mesh *mesh, double share)
{
    air_rng rng = air_rng_from_keys(4, 77);
    const size_t count = mesh->count;
    mesh->count = 0;
    for (size_t i = 0; i < count; i++) {
        if (random_unit(&rng) >= share) {
            memmove(mesh->positions + 9 * mesh->count++, mesh->positions + 9 * i,
                    9 * sizeof *mesh->positions);
        }
    }
}

#endif
