/* scene_fixture.h: small scenes for tests, and a context that keeps its last message. */
#ifndef AIR_TESTS_SCENE_FIXTURE_H
#define AIR_TESTS_SCENE_FIXTURE_H

#include <string.h>

#include "airlight/scene.h"
#include "cmocka_test.h"

static inline air_context *fixture_context(void)
{
    air_context_params params;
    air_context *context = NULL;
    air_context_params_default(&params);
    params.thread_count = 1;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

static inline air_scene *fixture_scene(air_context *context)
{
    air_scene *scene = NULL;
    assert_int_equal(air_scene_create(context, &scene), AIR_OK);
    return scene;
}

static inline air_snapshot *fixture_commit(air_scene *scene, uint32_t *dirty)
{
    air_snapshot *snapshot = NULL;
    assert_int_equal(air_scene_commit(scene, &snapshot, dirty), AIR_OK);
    return snapshot;
}

/* Two triangles, the square [-1,1]^2 in the plane z = 0, front towards +Z, uv from the top left. */
static const float fixture_square_positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const float fixture_square_uv[8] = {0, 1, 1, 1, 1, 0, 0, 0};
static const uint32_t fixture_square_indices[6] = {0, 1, 2, 0, 2, 3};

static inline air_mesh_desc fixture_square(const char *name)
{
    air_mesh_desc desc;
    air_mesh_desc_default(&desc);
    desc.name = name;
    desc.positions = fixture_square_positions;
    desc.uv[0] = fixture_square_uv;
    desc.vertex_count = 4;
    desc.indices = fixture_square_indices;
    desc.triangle_count = 2;
    return desc;
}

static inline void fixture_expect_message(const air_context *context, const char *part)
{
    const char *message = air_context_last_error(context);
    if (strstr(message, part) == NULL)
        fail_msg("\"%s\" does not say \"%s\"", message, part);
}

/* A commit whose snapshot is not needed; returns what it says is dirty. */
static inline uint32_t fixture_dirty(air_scene *scene)
{
    uint32_t dirty = 0;
    air_snapshot_release(fixture_commit(scene, &dirty));
    return dirty;
}

#endif
