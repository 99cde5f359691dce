/* render_file.c: the shortest way from a glTF scene to a picture.
 *
 *     cc render_file.c $(pkg-config --cflags --libs airlight) -o render_file
 *     ./render_file room.gltf room.exr */
#include <airlight/airlight.h>
#include <stdio.h>

static void print_message(void *user, air_message_level level, const char *text)
{
    (void)user;
    (void)level;
    (void)fprintf(stderr, "%s\n", text);
}

int main(int argc, char **argv)
{
    air_context_params context_params;
    air_render_params render_params;
    air_context *context = NULL;
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    air_film *film = NULL;
    air_image *image = NULL;
    if (argc != 3) {
        (void)fprintf(stderr, "usage: %s SCENE PICTURE\n", argv[0]);
        return 2;
    }
    air_context_params_default(&context_params);
    context_params.message = print_message;
    air_render_params_default(&render_params);
    render_params.width = 320;
    render_params.height = 180;
    render_params.sample_end = 16;
    air_status status = air_context_create(&context_params, &context);
    if (status == AIR_OK) {
        status = air_scene_load(context, argv[1], NULL, &scene);
    }
    if (status == AIR_OK) {
        status = air_scene_commit(scene, &snapshot, NULL);
    }
    if (status == AIR_OK) {
        status = air_render(context, snapshot, &render_params, &film);
    }
    if (status == AIR_OK) {
        status = air_film_resolve(film, NULL, &image);
    }
    if (status == AIR_OK) {
        status = air_image_save(context, image, argv[2], NULL);
    }
    air_image_destroy(image);
    air_film_destroy(film);
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    air_context_destroy(context);
    return status == AIR_OK ? 0 : 1;
}
