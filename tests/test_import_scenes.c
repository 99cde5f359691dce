/* Scenes made by other people, where they are at hand: what is in them is known. */
#include <stdio.h>
#include <unistd.h>

#include "import_fixture.h"

typedef struct known_scene {
    const char *path;
    size_t triangles, meshes, lights, cameras; /* cameras: in the file */
    const char *warning;                       /* part of one; NULL: none at all */
} known_scene;

/* Triangles: of the indices in the files, minus those without area (2 in classroom, 464 in
 * cornellBox). */
static const known_scene scenes[] = {
    {"bevy/CornellBox/CornellBox.glb", 36, 6, 0, 0, NULL},
    {"bevy/VolumetricFogExample/VolumetricFogExample.glb", 360, 1, 1, 0, NULL},
    {"geometry/classroom.glb", 103830, 1, 0, 0, NULL},
    {"geometry/sponza.glb", 66445, 1, 0, 0, NULL},
    {"gltf_blender_io/14_emission_strength/14_emission_strength.gltf", 17280, 18, 0, 0, NULL},
    {"gltf_blender_io/16_volume/16_volume.gltf", 296, 25, 0, 0, NULL},
    {"gltf_khronos/AttenuationTest/glTF/AttenuationTest.gltf", 292, 23, 0, 0, NULL},
    {"gltf_khronos/EmissiveStrengthTest/glTF/EmissiveStrengthTest.gltf", 90, 6, 0, 0, NULL},
    {"gltf_khronos/GlassHurricaneCandleHolder/glTF/GlassHurricaneCandleHolder.gltf", 4126, 2, 0, 0,
     NULL},
    {"gltf_khronos/LightsPunctualLamp/glTF/LightsPunctualLamp.gltf", 6000, 3, 5, 0, NULL},
    {"gltf_khronos/MultiUVTest/glTF/MultiUVTest.gltf", 12, 1, 0, 1, NULL},
    {"gltf_nvpro_cornell/cornellBox.gltf", 16268, 10, 0, 1, "emissiveFactor above 1"},
    {"gltf_playcanvas/Lights.glb", 12, 1, 4, 1, NULL},
    {"gltf_playcanvas/house.glb", 10497, 2, 0, 0, NULL},
};

static void keep_warning(void *user, air_message_level level, const char *text)
{
    char *warnings = user;
    const size_t used = strlen(warnings);
    if (level == AIR_MESSAGE_WARNING)
        snprintf(warnings + used, FIXTURE_TEXT - used, "%s\n", text);
}

static void check_scene(air_context *context, const known_scene *known, const char *warnings)
{
    char path[512];
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    snprintf(path, sizeof path, "%s/scenes/%s", AIR_SHARED_DIR, known->path);
    if (air_scene_load(context, path, NULL, &scene) != AIR_OK)
        fail_msg("%s: %s", path, air_context_last_error(context));
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    print_message("%s: %zu triangles, %zu meshes\n", known->path, snapshot->triangle_count,
                  snapshot->mesh_count);
    assert_int_equal(snapshot->triangle_count, known->triangles);
    assert_int_equal(snapshot->mesh_count, known->meshes);
    assert_int_equal(snapshot->lights.explicit_count, known->lights);
    assert_int_equal(snapshot->camera_in_file ? snapshot->camera_count : 0, known->cameras);
    if (known->warning == NULL)
        assert_string_equal(warnings, "");
    else
        assert_non_null(strstr(warnings, known->warning));
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
}

static void scenes_of_other_people_hold_what_is_known_of_them(void **state)
{
    (void)state;
    if (access(AIR_SHARED_DIR "/scenes", F_OK) != 0) {
        print_message("skipped: there is no " AIR_SHARED_DIR "/scenes\n");
        skip();
    }
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i) {
        char warnings[FIXTURE_TEXT] = "";
        air_context_params params;
        air_context *context = NULL;
        air_context_params_default(&params);
        params.message = keep_warning;
        params.message_user = warnings;
        assert_int_equal(air_context_create(&params, &context), AIR_OK);
        check_scene(context, &scenes[i], warnings);
        air_context_destroy(context);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_of_other_people_hold_what_is_known_of_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
