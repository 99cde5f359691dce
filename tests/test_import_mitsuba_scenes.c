/* Mitsuba scenes made by other people, where they are at hand: all of them load. */
#include <stdio.h>
#include <unistd.h>

#include "cmocka_test.h"
#include "scene/snapshot.h"

/* What is in them, counted in the files by hand; triangles SIZE_MAX: not counted. */
static const struct {
    const char *path;
    size_t triangles, media, lights;
} scenes[] = {
    {"bitterli_cornell-box/scene.xml", 36, 0, 0},
    {"bitterli_classroom/scene.xml", SIZE_MAX, 0, 2},
    {"lajolla_cbox/cbox.xml", 38, 0, 0},
    {"lajolla_sponza/sponza.xml", 66445, 0, 0},
    {"mitsuba_cbox/cbox.xml", 38, 0, 0},
    {"mitsuba_cbox/cbox-rgb.xml", 38, 0, 0},
    {"mitsuba_cbox/cbox-spectral.xml", 38, 0, 0},
    {"roombeam/roombeam-mitsuba3.xml", 2, 1, 1},
    {"lajolla_volpath/hetvol.xml", SIZE_MAX, 1, 0},
    {"lajolla_volpath/hetvol_colored.xml", SIZE_MAX, 1, 0},
    {"lajolla_volpath/vol_cbox.xml", 38, 1, 0},
    {"lajolla_volpath/vol_cbox_teapot.xml", SIZE_MAX, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test1.xml", 0, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test2.xml", 0, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test3.xml", 0, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test4.xml", 0, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test4_2.xml", 0, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test5.xml", 0, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test5_2.xml", 0, SIZE_MAX, 0},
    {"lajolla_volpath/volpath_test6.xml", 0, 2, 0},
};

static void is_or_unknown(const char *path, const char *what, size_t found, size_t expected)
{
    if (expected != SIZE_MAX && found != expected)
        fail_msg("%s: %zu %s, expected %zu", path, found, what, expected);
}

static void scenes_of_others_load(void **state)
{
    air_context *context = NULL;
    (void)state;
    if (access(AIR_SHARED_DIR "/scenes", R_OK) != 0) {
        print_message("skipped: there is no %s/scenes\n", AIR_SHARED_DIR);
        skip();
    }
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; ++i) {
        char path[512];
        air_scene *scene = NULL;
        air_snapshot *snapshot = NULL;
        snprintf(path, sizeof path, "%s/scenes/%s", AIR_SHARED_DIR, scenes[i].path);
        if (air_scene_load(context, path, NULL, &scene) != AIR_OK)
            fail_msg("%s", air_context_last_error(context));
        assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
        is_or_unknown(path, "triangles", snapshot->triangle_count, scenes[i].triangles);
        is_or_unknown(path, "media", snapshot->media.count, scenes[i].media);
        is_or_unknown(path, "lights", snapshot->lights.explicit_count, scenes[i].lights);
        assert_true(snapshot->camera_in_file);
        air_snapshot_release(snapshot);
        air_scene_destroy(scene);
    }
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(scenes_of_others_load)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
