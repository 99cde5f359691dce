/* fuzz_scene.h: what the harnesses of the scene loader share: no rays, and what is done with a
 * scene. */
#ifndef AIR_TESTS_FUZZ_SCENE_H
#define AIR_TESTS_FUZZ_SCENE_H

#include "airlight/scene.h"
#include "fuzz_host.h"

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

/* Loads a scene of these files and freezes what came of it. */
static inline void fuzz_load_scene(fuzz_files *files, const char *path, const air_load_params *load)
{
    const air_ray_backend backend = {.build = fuzz_build,
                                     .destroy = fuzz_destroy,
                                     .intersect = fuzz_intersect,
                                     .occluded = fuzz_occluded,
                                     .intersect_all = fuzz_intersect_all};
    air_context *context = fuzz_context(files, &backend);
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    if (context == NULL)
        return;
    const air_status status = air_scene_load(context, path, load, &scene);
    fuzz_check_outcome(context, status, scene);
    if (scene != NULL)
        (void)air_scene_commit(scene, &snapshot, NULL);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

#endif
