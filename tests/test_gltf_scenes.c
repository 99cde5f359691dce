/* Small pictures of scenes made by other people, with media and lights put in as a command would:
 * finite, not negative, lit, and with light in the fog. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "airlight/render.h"
#include "cmocka_test.h"

typedef struct pictured_scene {
    const char *path; /* "/..." below ../shared, else below the project */
    const char *medium, *environment;
    /* Shares of the pixels that must have any light and any light from the media: what the camera
     * sees of them, with room for the noise of 16 samples. */
    double lit, foggy;
} pictured_scene;

static const pictured_scene scenes[] = {
    /* A hut in the sun; fog in and around it, in front of two fifths of the picture. */
    {"/scenes/bevy/VolumetricFogExample/VolumetricFogExample.glb",
     "box=-8,0,-9:8,8,9,sigma_s=0.1,sigma_a=0.01,g=0.5", NULL, 0.4, 0.4},
    {"/scenes/gltf_playcanvas/house.glb", "box=-0.4,0,-0.4:0.4,0.3,0.4,sigma_s=2,g=0.3",
     "constant=0.8,0.9,1", 1.0, 0.3},
    /* Point lights everywhere in reach of the camera's rays. */
    {"/scenes/gltf_khronos/LightsPunctualLamp/glTF/LightsPunctualLamp.gltf",
     "unbounded,visibility=20m", NULL, 0.99, 0.99},
    {"scenes/smoke/smoke.gltf", NULL, AIR_SHARED_DIR "/scenes/hdr/vestibule_1k.hdr", 1.0, 0.1},
};

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT, TEXT = 4096 };

static void path_of(const char *path, char out[512])
{
    const char *root = path[0] == '/' ? AIR_SHARED_DIR : AIR_SOURCE_DIR "/";
    snprintf(out, 512, "%s%s", root, path);
}

static void keep_warnings(void *user, air_message_level level, const char *text)
{
    char *kept = user;
    const size_t used = strlen(kept);
    if (level != AIR_MESSAGE_INFO)
        snprintf(kept + used, TEXT - used, "%s\n", text);
}

static air_context *listening_context(char messages[TEXT])
{
    air_context_params params;
    air_context *context = NULL;
    air_context_params_default(&params);
    params.message = keep_warnings;
    params.message_user = messages;
    messages[0] = '\0';
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

/* Share of the pixels in which some channel of a layer ("" for beauty) is positive. */
static double lit_share(const air_image *image, const char *layer)
{
    size_t lit = 0;
    const float *planes[3];
    for (int c = 0; c < 3; ++c) {
        char name[32];
        snprintf(name, sizeof name, "%s%c", layer, "RGB"[c]);
        const ptrdiff_t channel = air_image_find_channel(image, name);
        assert_true(channel >= 0);
        planes[c] = air_image_plane_const(image, (size_t)channel);
    }
    for (size_t i = 0; i < PIXELS; ++i)
        lit += planes[0][i] > 0.0f || planes[1][i] > 0.0f || planes[2][i] > 0.0f;
    return (double)lit / PIXELS;
}

static void assert_sound(const air_image *image)
{
    for (size_t c = 0; c < air_image_channel_count(image); ++c)
        for (size_t i = 0; i < PIXELS; ++i) {
            const float value = air_image_plane_const(image, c)[i];
            if (!isfinite(value) || value < 0.0f)
                fail_msg("channel %s, pixel %zu: %g", air_image_channel_name(image, c), i,
                         (double)value);
        }
}

static air_image *picture(air_context *context, const pictured_scene *pictured)
{
    char path[512];
    air_load_params load;
    air_render_params params;
    air_scene *scene;
    air_snapshot *snapshot;
    air_film *film;
    air_image *image;
    path_of(pictured->path, path);
    air_load_params_default(&load);
    load.media = &pictured->medium;
    load.media_count = pictured->medium != NULL ? 1 : 0;
    load.environment = pictured->environment;
    assert_int_equal(air_scene_load(context, path, &load, &scene), AIR_OK);
    assert_int_equal(air_scene_commit(scene, &snapshot, NULL), AIR_OK);
    air_render_params_default(&params);
    params.width = WIDTH;
    params.height = HEIGHT;
    params.sample_end = 16;
    params.max_depth = 8;
    params.layers = true;
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
    assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
    air_film_destroy(film);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    return image;
}

static void need_shared_scenes(void)
{
    if (access(AIR_SHARED_DIR "/scenes", F_OK) != 0) {
        print_message("skipped: there is no " AIR_SHARED_DIR "/scenes\n");
        skip();
    }
}

static void pictures_of_scenes_in_fog_are_sound(void **state)
{
    (void)state;
    need_shared_scenes();
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i) {
        char messages[TEXT];
        air_context *context = listening_context(messages);
        air_image *image = picture(context, &scenes[i]);
        const double lit = lit_share(image, ""), foggy = lit_share(image, "M1.");
        print_message("%s: %.1f %% lit, %.1f %% with light in the fog\n", scenes[i].path,
                      100.0 * lit, 100.0 * foggy);
        assert_sound(image);
        assert_true(lit >= scenes[i].lit && foggy >= scenes[i].foggy);
        if (messages[0] != '\0')
            fail_msg("%s: messages: %s", scenes[i].path, messages);
        air_image_destroy(image);
        air_context_destroy(context);
    }
}

static void assert_says(const char *messages, const char *part)
{
    if (strstr(messages, part) == NULL)
        fail_msg("\"%s\" does not say \"%s\"", messages, part);
}

/* The file is invalid in four places; what can be shown is, with a warning. */
static void an_invalid_gltf_is_warned_of(void **state)
{
    (void)state;
    static const pictured_scene cornell = {"/scenes/gltf_nvpro_cornell/cornellBox.gltf", NULL, NULL,
                                           0.0, 0.0};
    char messages[TEXT];
    need_shared_scenes();
    air_context *context = listening_context(messages);
    air_image *image = picture(context, &cornell);
    assert_sound(image);
    assert_says(messages, "cornellBox.gltf");
    assert_says(messages, "emissiveFactor above 1");
    air_image_destroy(image);
    air_context_destroy(context);
}

static void another_format_is_refused_by_name(void **state)
{
    (void)state;
    char messages[TEXT], path[512];
    air_scene *scene = NULL;
    need_shared_scenes();
    air_context *context = listening_context(messages);
    path_of("/scenes/obj_cornell/CornellBox-Original-Merged.obj", path);
    assert_int_equal(air_scene_load(context, path, NULL, &scene), AIR_ERROR_FORMAT);
    assert_null(scene);
    assert_says(messages, "CornellBox-Original-Merged.obj");
    assert_says(messages, "expected a glTF file");
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_of_scenes_in_fog_are_sound),
        cmocka_unit_test(an_invalid_gltf_is_warned_of),
        cmocka_unit_test(another_format_is_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
