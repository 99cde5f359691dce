/* The ray backend: single rays against batches, rays of one pixel against rays scattered in a room.
 *
 * Both sides of each ratio run in turn; printed are medians over the rounds and the range of the
 * ratio. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/host.h"
#include "core/random.h"
#include "core/vec.h"
#include "core/warp.h"

enum { RINGS = 160, SPOKES = 320, RAYS = 1 << 16, ROUNDS = 15, BATCH = 64 };
enum { SPHERE_VERTICES = (RINGS + 1) * SPOKES, SPHERE_TRIANGLES = 2 * RINGS * SPOKES };

typedef struct room {
    float sphere[3 * SPHERE_VERTICES + 1], walls[3 * 8 + 1];
    uint32_t sphere_indices[3 * SPHERE_TRIANGLES], wall_indices[36];
    air_ray rays[RAYS];
    air_hit hits[RAYS];
    uint8_t occluded[RAYS];
} room;

/* A finely tessellated sphere of radius 0.5 in a box of side 4. */
static void make_meshes(room *self, air_ray_mesh meshes[2])
{
    static const uint32_t walls[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                       2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    uint32_t *index = self->sphere_indices;
    for (int ring = 0; ring <= RINGS; ++ring) {
        for (int spoke = 0; spoke < SPOKES; ++spoke) {
            const double theta = AIR_PI * ring / RINGS, phi = 2.0 * AIR_PI * spoke / SPOKES;
            float *p = self->sphere + 3 * (ring * SPOKES + spoke);
            p[0] = (float)(0.5 * sin(theta) * cos(phi));
            p[1] = (float)(0.5 * cos(theta));
            p[2] = (float)(0.5 * sin(theta) * sin(phi));
            if (ring < RINGS) {
                const uint32_t a = (uint32_t)(ring * SPOKES + spoke);
                const uint32_t b = (uint32_t)(ring * SPOKES + (spoke + 1) % SPOKES);
                const uint32_t corners[6] = {a, b, a + SPOKES, b, b + SPOKES, a + SPOKES};
                memcpy(index, corners, sizeof corners);
                index += 6;
            }
        }
    }
    for (int i = 0; i < 8; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            self->walls[3 * i + axis] = (i >> axis & 1) != 0 ? 2.0f : -2.0f;
        }
    }
    memcpy(self->wall_indices, walls, sizeof walls);
    meshes[0] = (air_ray_mesh){.positions = self->sphere,
                               .vertex_count = SPHERE_VERTICES,
                               .indices = self->sphere_indices,
                               .triangle_count = SPHERE_TRIANGLES,
                               .mask = 1};
    meshes[1] = (air_ray_mesh){.positions = self->walls,
                               .vertex_count = 8,
                               .indices = self->wall_indices,
                               .triangle_count = 12,
                               .mask = 1};
}

/* Scattered rays start and go anywhere; else each batch is a bundle as wide as a pixel of a
 * picture. */
static void make_rays(room *self, bool scattered)
{
    air_rng rng = air_rng_from_keys(1, scattered);
    air_vec3 axis = vec3(0.0f, 0.0f, -1.0f);
    for (size_t i = 0; i < RAYS; ++i) {
        air_vec3 origin = vec3(0.0f, 0.0f, 1.9f);
        air_vec3 dir = sample_sphere(air_rng_float(&rng), air_rng_float(&rng));
        if (scattered) {
            origin = vec3_madd(vec3_set1(-1.9f), 3.8f,
                               vec3(air_rng_float(&rng), air_rng_float(&rng), air_rng_float(&rng)));
        } else {
            if (i % BATCH == 0) {
                axis = vec3(0.6f * air_rng_float(&rng) - 0.3f, 0.6f * air_rng_float(&rng) - 0.3f,
                            -1.0f);
            }
            dir = vec3_madd(axis, 0.001f, dir);
        }
        self->rays[i] = (air_ray){.tmax = INFINITY, .mask = 1};
        vec3_store(self->rays[i].origin, origin);
        vec3_store(self->rays[i].dir, dir);
    }
}

/* ns per ray. */
static double time_rays(air_context *context, const void *accelerator, room *self, size_t batch,
                        bool occlusion)
{
    const air_ray_backend *backend = air_context_ray_backend(context);
    const double start = air_clock(context);
    for (size_t i = 0; i < RAYS; i += batch) {
        if (occlusion) {
            backend->occluded(accelerator, self->rays + i, batch, self->occluded + i);
        } else {
            backend->intersect(accelerator, self->rays + i, batch, self->hits + i);
        }
    }
    return 1e9 * (air_clock(context) - start) / RAYS;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(air_context *context, const void *accelerator, room *self, bool scattered,
                    bool occlusion)
{
    double single[ROUNDS], batch[ROUNDS], ratio[ROUNDS];
    make_rays(self, scattered);
    for (int i = 0; i < ROUNDS; ++i) {
        single[i] = time_rays(context, accelerator, self, 1, occlusion);
        batch[i] = time_rays(context, accelerator, self, BATCH, occlusion);
        ratio[i] = single[i] / batch[i];
    }
    qsort(single, ROUNDS, sizeof *single, compare_doubles);
    qsort(batch, ROUNDS, sizeof *batch, compare_doubles);
    qsort(ratio, ROUNDS, sizeof *ratio, compare_doubles);
    printf("%-9s %-10s %7.1f %7.1f   %5.2f (%.2f to %.2f)\n", occlusion ? "occluded" : "intersect",
           scattered ? "scattered" : "pixel", single[ROUNDS / 2], batch[ROUNDS / 2],
           ratio[ROUNDS / 2], ratio[0], ratio[ROUNDS - 1]);
}

static bool run(air_cpu cpu, room *self)
{
    static const char *const names[] = {"auto", "C", "SSE4.2", "AVX2", "AVX-512"};
    air_context *context = NULL;
    air_context_params params;
    air_ray_mesh meshes[2];
    void *accelerator = NULL;
    air_context_params_default(&params);
    params.cpu = cpu;
    if (air_context_create(&params, &context) != AIR_OK) {
        printf("%s: not on this machine\n", names[cpu]);
        return true;
    }
    make_meshes(self, meshes);
    const air_ray_backend *backend = air_context_ray_backend(context);
    const bool built = backend->build(backend->user, context, meshes, 2, &accelerator) == AIR_OK;
    if (built) {
        printf("%s, %d triangles: ns per ray, one at a time and by %d; ratio\n", names[cpu],
               SPHERE_TRIANGLES + 12, BATCH);
        for (int i = 0; i < 4; ++i) {
            measure(context, accelerator, self, i % 2 != 0, i / 2 != 0);
        }
    }
    backend->destroy(accelerator);
    air_context_destroy(context);
    return built;
}

int main(void)
{
    room *self = calloc(1, sizeof *self);
    bool good = self != NULL;
    for (air_cpu cpu = AIR_CPU_SSE42; good && cpu <= AIR_CPU_AVX512; ++cpu) {
        good = run(cpu, self);
    }
    free(self);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
