/* context.h: the context, which owns what the library needs from its host.
 *
 * A context holds the allocator, the parallel-for, the clock, the file reader, the message and
 * progress callbacks and the ray backend. Every other object is made from a context and must be
 * destroyed before it. There are no globals: two contexts share nothing. A context may be used from
 * several threads at once; each thread has its own last error. */
#ifndef AIRLIGHT_CONTEXT_H
#define AIRLIGHT_CONTEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct air_context air_context;

typedef enum air_message_level {
    AIR_MESSAGE_ERROR = 0,
    AIR_MESSAGE_WARNING = 1,
    AIR_MESSAGE_INFO = 2
} air_message_level;

/* The instruction sets kernels are built for. AIR_CPU_AUTO takes the best the machine has. */
typedef enum air_cpu {
    AIR_CPU_AUTO = 0,
    AIR_CPU_C = 1,
    AIR_CPU_SSE42 = 2,
    AIR_CPU_AVX2 = 3,
    AIR_CPU_AVX512 = 4
} air_cpu;

/* Rays as the backend sees them. Directions need not have unit length; distances are in units of
 * the direction's length. A mesh is met only if (mesh mask & ray mask) != 0. Hits lie in the open
 * interval (tmin, tmax). */
typedef struct air_ray {
    float origin[3];
    float tmin;
    float dir[3];
    float tmax;
    uint32_t mask;
} air_ray;

/* A hit. mesh is the index of the mesh in the order given to build, AIR_NO_HIT if nothing was met.
 * (u, v) are barycentrics of vertices 1 and 2; normal is the unnormalised (p1-p0) x (p2-p0). Of a
 * quadric: its texture coordinates, which spheres may leave 0, its normal of any length (where a
 * sphere was met is found from it), and triangle 0. */
typedef struct air_hit {
    float t;
    float u, v;
    float normal[3];
    uint32_t mesh;
    uint32_t triangle;
} air_hit;

enum { AIR_NO_HIT = -1 }; /* compare as (uint32_t)AIR_NO_HIT */

/* What a mesh handed to the backend is made of; the quadrics as in air_shape (scene.h). */
typedef enum air_ray_shape {
    AIR_RAY_TRIANGLES = 0,
    AIR_RAY_SPHERE = 1,
    AIR_RAY_CYLINDER = 2,
    AIR_RAY_DISK = 3
} air_ray_shape;

/* A mesh handed to the backend: borrowed, must outlive the accelerator. positions: 3 floats per
 * vertex, with one more float of padding readable behind the last. indices: 3 per triangle. A
 * quadric has neither, but to_world, 3 rows of 4. */
typedef struct air_ray_mesh {
    const float *positions;
    size_t vertex_count;
    const uint32_t *indices;
    size_t triangle_count;
    uint32_t mask;
    air_ray_shape shape;
    const float *to_world;
} air_ray_mesh;

/* The ray backend: Embree by default. All queries are thread-safe on a built accelerator and
 * deterministic. */
typedef struct air_ray_backend {
    void *user;
    air_status (*build)(void *user, air_context *context, const air_ray_mesh *meshes,
                        size_t mesh_count, void **out_accelerator);
    void (*destroy)(void *accelerator);
    /* Nearest hit of each ray. */
    void (*intersect)(const void *accelerator, const air_ray *rays, size_t ray_count,
                      air_hit *hits);
    /* occluded[i] = 1 if anything is met, else 0. */
    void (*occluded)(const void *accelerator, const air_ray *rays, size_t ray_count,
                     uint8_t *occluded);
    /* All hits of one ray sorted by t, at most capacity of them (the nearest); returns how many
     * were stored. */
    size_t (*intersect_all)(const void *accelerator, const air_ray *ray, air_hit *hits,
                            size_t capacity);
} air_ray_backend;

typedef struct air_context_params {
    /* realloc-like: pointer may be NULL; size 0 frees and returns NULL. NULL: the C library's. */
    void *(*reallocate)(void *user, void *pointer, size_t size);
    void *allocate_user;

    /* Calls body(body_user, index, worker) once for each index in [0, count), worker in [0,
     * thread_count); returns when all are done. Indices may run in any order and concurrently.
     * NULL: OpenMP with thread_count threads. */
    void (*parallel_for)(void *user, size_t count,
                         void (*body)(void *body_user, size_t index, size_t worker),
                         void *body_user);
    void *parallel_user;
    size_t thread_count; /* >= 1; default: the number of processors of this process */

    double (*clock)(void *user); /* seconds, monotonic; NULL: CLOCK_MONOTONIC */
    void *clock_user;

    /* Reads a whole file: *out_data is allocated with reallocate above and taken by the library.
     * NULL: the file system. */
    air_status (*read_file)(void *user, air_context *context, const char *path, void **out_data,
                            size_t *out_size);
    void *read_user;

    /* One whole sentence without newline. May be called from any thread, never concurrently. NULL:
     * nothing. */
    void (*message)(void *user, air_message_level level, const char *text);
    void *message_user;

    /* Fraction done in [0, 1] and what is being done. Return false to stop: the running call then
     * ends with AIR_ERROR_INTERRUPTED, or early with what it has where its documentation says so.
     * NULL: nothing. */
    bool (*progress)(void *user, double fraction, const char *what);
    void *progress_user;

    const air_ray_backend *ray_backend; /* borrowed; NULL: Embree */
    air_cpu cpu;                        /* default AIR_CPU_AUTO */
} air_context_params;

/* The defaults named above. */
AIR_API void air_context_params_default(air_context_params *params);

/* Creates a context. params NULL means the defaults. On failure *out_context is NULL.
 * AIR_ERROR_ARGUMENT: thread_count is 0; AIR_ERROR_UNSUPPORTED: cpu is above what the machine has.
 */
AIR_API air_status air_context_create(const air_context_params *params, air_context **out_context);
AIR_API void air_context_destroy(air_context *context); /* NULL is legal */

/* The last error of the calling thread in this context, "" if none. Valid until the thread's next
 * failing call. */
AIR_API const char *air_context_last_error(const air_context *context);

/* How many workers parallel_for uses, and the instruction set in use. */
AIR_API size_t air_context_thread_count(const air_context *context);
AIR_API air_cpu air_context_cpu(const air_context *context);

#ifdef __cplusplus
}
#endif
#endif
