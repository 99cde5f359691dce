/* fuzz_scene.h: what the harnesses of the scene loader share: files in memory, a bound on memory,
 * no rays. */
#ifndef AIR_TESTS_FUZZ_SCENE_H
#define AIR_TESTS_FUZZ_SCENE_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/scene.h"

/* One allocation may have this much: enough for the files of a corpus, and no reason to run out of
 * memory. */
enum { FUZZ_MAX_ALLOCATION = 1 << 26, FUZZ_MAX_FILES = 5 };

typedef struct fuzz_file {
    const char *ending; /* of the paths that give this file */
    const void *data;
    size_t size;
} fuzz_file;

typedef struct fuzz_files {
    fuzz_file files[FUZZ_MAX_FILES];
    size_t count;
} fuzz_files;

static inline void *fuzz_reallocate(void *user, void *pointer, size_t size)
{
    (void)user;
    if (size == 0) {
        free(pointer);
        return NULL;
    }
    return size <= FUZZ_MAX_ALLOCATION ? realloc(pointer, size) : NULL;
}

static inline air_status fuzz_read(void *user, air_context *context, const char *path,
                                   void **out_data, size_t *out_size)
{
    const fuzz_files *self = user;
    const size_t length = strlen(path);
    (void)context;
    for (size_t i = 0; i < self->count; ++i) {
        const fuzz_file *file = &self->files[i];
        const size_t ending = strlen(file->ending);
        if (length < ending || strcmp(path + length - ending, file->ending) != 0)
            continue;
        void *copy = malloc(file->size + 1);
        if (copy == NULL)
            return AIR_ERROR_MEMORY;
        if (file->size > 0)
            memcpy(copy, file->data, file->size);
        *out_data = copy;
        *out_size = file->size;
        return AIR_OK;
    }
    return AIR_ERROR_IO;
}

/* ---- a ray backend that knows no rays: Embree is not what is tried here ---- */

static inline air_status fuzz_build(void *user, air_context *context, const air_ray_mesh *meshes,
                                    size_t mesh_count, void **out_accelerator)
{
    (void)user;
    (void)context;
    size_t broken = 0;
    for (size_t m = 0; m < mesh_count; ++m)
        for (size_t i = 0; i < 3 * meshes[m].triangle_count; ++i)
            broken += meshes[m].indices[i] >= meshes[m].vertex_count;
    if (broken > 0)
        abort();
    *out_accelerator = malloc(1);
    return *out_accelerator != NULL ? AIR_OK : AIR_ERROR_MEMORY;
}

static inline void fuzz_destroy(void *accelerator) { free(accelerator); }

static inline void fuzz_intersect(const void *accelerator, const air_ray *rays, size_t ray_count,
                                  air_hit *hits)
{
    (void)accelerator;
    (void)rays;
    for (size_t i = 0; i < ray_count; ++i)
        hits[i].mesh = (uint32_t)AIR_NO_HIT;
}

static inline void fuzz_occluded(const void *accelerator, const air_ray *rays, size_t ray_count,
                                 uint8_t *occluded)
{
    (void)accelerator;
    (void)rays;
    memset(occluded, 0, ray_count);
}

static inline size_t fuzz_intersect_all(const void *accelerator, const air_ray *ray, air_hit *hits,
                                        size_t capacity)
{
    (void)accelerator;
    (void)ray;
    (void)hits;
    (void)capacity;
    return 0;
}

/* Loads "input.gltf" of these files and freezes what came of it. */
static inline void fuzz_load_scene(fuzz_files *files, const air_load_params *load)
{
    const air_ray_backend backend = {.build = fuzz_build,
                                     .destroy = fuzz_destroy,
                                     .intersect = fuzz_intersect,
                                     .occluded = fuzz_occluded,
                                     .intersect_all = fuzz_intersect_all};
    air_context_params params;
    air_context *context = NULL;
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    air_context_params_default(&params);
    params.thread_count = 1;
    params.reallocate = fuzz_reallocate;
    params.read_file = fuzz_read;
    params.read_user = files;
    params.ray_backend = &backend;
    if (air_context_create(&params, &context) != AIR_OK)
        return;
    const air_status status = air_scene_load(context, "input.gltf", load, &scene);
    /* a failure says what failed */
    if ((status == AIR_OK) != (scene != NULL) ||
        (status != AIR_OK && air_context_last_error(context)[0] == '\0'))
        abort();
    if (scene != NULL)
        (void)air_scene_commit(scene, &snapshot, NULL);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

#endif
