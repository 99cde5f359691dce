/* The scenes that come with the project: complete, without warnings, and lit. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "airlight/render.h"

typedef struct shipped_scene {
    const char *path;
    size_t lights, media;
    bool background; /* an environment, so that no pixel is black */
} shipped_scene;

static const shipped_scene scenes[] = {
    {AIR_SOURCE_DIR "/scenes/roombeam/roombeam.gltf", 1, 1, false},
    {AIR_SOURCE_DIR "/scenes/sunroom/sunroom.gltf", 3, 1, true},
    {AIR_SOURCE_DIR "/scenes/smoke/smoke.gltf", 2, 1, true},
};

static void fail_on_trouble(void *user, air_message_level level, const char *text)
{
    (void)user;
    if (level != AIR_MESSAGE_INFO)
        fail_msg("%s", text);
}

static void check_picture(air_context *context, const air_snapshot *snapshot, bool background)
{
    air_render_params params;
    air_film *film;
    air_image *image;
    air_render_params_default(&params);
    params.width = 32;
    params.height = 18;
    params.sample_end = 64;
    params.max_depth = 8;
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
    assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
    for (size_t c = 0; c < 3; ++c) {
        const float *plane = air_image_plane_const(image, c);
        double sum = 0.0;
        for (size_t i = 0; i < params.width * params.height; ++i) {
            assert_true(isfinite(plane[i]) && plane[i] >= 0.0f);
            if (background && plane[i] == 0.0f)
                fail_msg("pixel %zu is black", i);
            sum += (double)plane[i];
        }
        assert_true(sum > 0.0);
    }
    air_image_destroy(image);
    air_film_destroy(film);
}

static void check_scene(const shipped_scene *shipped)
{
    air_context_params params;
    air_context *context;
    air_scene *scene;
    air_snapshot *snapshot;
    air_scene_info info;
    air_context_params_default(&params);
    params.message = fail_on_trouble;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_int_equal(air_scene_load(context, shipped->path, NULL, &scene), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_snapshot_info(snapshot, &info);
    assert_int_equal(info.light_count, shipped->lights);
    assert_int_equal(info.medium_count, shipped->media);
    assert_true(info.camera_in_file);
    check_picture(context, snapshot, shipped->background);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
}

static void shipped_scenes_load_without_warnings_and_are_lit(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i)
        check_scene(&scenes[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shipped_scenes_load_without_warnings_and_are_lit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
