/* atlas_scene.h: meshes of real files for the tests of the atlas. */
#ifndef AIR_TESTS_ATLAS_SCENE_H
#define AIR_TESTS_ATLAS_SCENE_H

#include <stdio.h>
#include <unistd.h>

#include "airlight/scene.h"
#include "atlas_fixture.h"
#include "scene/snapshot.h"

/* NULL, and a line that says so, where the file is absent. Release it with air_snapshot_release. */
static inline air_snapshot *atlas_snapshot(air_context *context, const char *file)
{
    char path[512];
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    (void)snprintf(path, sizeof path, "%s/scenes/%s", AIR_SHARED_DIR, file);
    if (access(path, R_OK) != 0) {
        (void)printf("skipped: no %s\n", path);
        return NULL;
    }
    air_load_params params;
    air_load_params_default(&params);
    assert_int_equal(air_scene_load(context, path, &params, &scene), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_scene_destroy(scene);
    return snapshot;
}

/* A mesh with its set of uv over a whole page. */
static inline air_atlas_part atlas_scene_part(const air_mesh *mesh, int set, double size)
{
    return (air_atlas_part){.positions = mesh->positions,
                            .uv = mesh->uv[set],
                            .indices = mesh->indices,
                            .vertex_count = mesh->vertex_count,
                            .triangle_count = mesh->triangle_count,
                            .offset = {0.0, 0.0},
                            .size = {size, size}};
}

#endif
