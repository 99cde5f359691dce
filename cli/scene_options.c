#include "scene_options.h"

#include <airlight/render.h>
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of a single frame, last in scene_options. */
enum { FRAME_OPTIONS = 1 };

static const char *const unit_names[] = {"auto", "radiometric", "photometric", NULL};

static const cli_option scene_options[] = {
    {.name = "with",
     .kind = CLI_LIST,
     .value = "FILE",
     .offset = offsetof(cli_scene_options, with),
     .help = "Add what this JSON file says (media, lights, a camera), as in NAME.airlight.json "
             "beside the scene, which is always read. Repeatable."},
    {.name = "medium",
     .kind = CLI_LIST,
     .value = "SPEC",
     .offset = offsetof(cli_scene_options, media),
     .help = "Add a medium, such as visibility=50m or box=-2,0,-2:2,3,2,sigma_s=0.2,g=0.3. "
             "Repeatable."},
    {.name = "environment",
     .kind = CLI_TEXT,
     .value = "FILE|constant=R,G,B",
     .offset = offsetof(cli_scene_options, environment),
     .help = "Light from all around: a lat-long .hdr or .exr, or one radiance."},
    {.name = "light-units",
     .kind = CLI_CHOICE,
     .value = "UNITS",
     .choices = unit_names,
     .offset = offsetof(cli_scene_options, light_units),
     .help = "What the file's punctual lights are given in: auto, radiometric or photometric; "
             "default auto, photometric as glTF says."},
    {.name = "emissive-units",
     .kind = CLI_CHOICE,
     .value = "UNITS",
     .choices = unit_names,
     .offset = offsetof(cli_scene_options, emissive_units),
     .help = "Likewise for emissive materials; auto is photometric, radiometric for files Blender "
             "exported."},
    {.name = "scene-index",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 0,
     .max = 1e6,
     .offset = offsetof(cli_scene_options, scene_index),
     .help = "Which scene of a glTF file that holds several; default: the one the file names."},
    {.name = "define",
     .letter = 'D',
     .kind = CLI_LIST,
     .value = "NAME=VALUE",
     .offset = offsetof(cli_scene_options, defines),
     .help = "Value of a $parameter of a Mitsuba scene. Repeatable."},
    {.name = "lenient",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_scene_options, lenient),
     .help = "Of a Mitsuba scene: replace what is not supported, with a warning that says by what, "
             "instead of refusing it."},
    {.name = "files-anywhere",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_scene_options, files_anywhere),
     .help = "A Mitsuba scene may name files outside its folder."},
    {.name = "frame",
     .kind = CLI_COUNT,
     .value = "N",
     .max = AIR_FRAME_MAX,
     .offset = offsetof(cli_scene_options, frame),
     .help = "Frame of grids that are a file each: # in their names stands for its number."},
};

cli_option_group cli_scene_group(cli_scene_options *options)
{
    return (cli_option_group){"Scene", scene_options,
                              sizeof scene_options / sizeof scene_options[0], options};
}

cli_option_group cli_scene_group_of_frames(cli_scene_options *options)
{
    const size_t count = sizeof scene_options / sizeof scene_options[0];
    return (cli_option_group){"Scene", scene_options, count - FRAME_OPTIONS, options};
}

cli_exit cli_scene_describe(cli_host *host, const air_snapshot *snapshot, json_t **out_description)
{
    size_t size = 0;
    json_error_t error;
    air_status status = air_snapshot_describe(snapshot, NULL, &size);
    if (status != AIR_OK) {
        return cli_host_exit(host, status, "describing the scene");
    }
    char *const text = malloc(size);
    if (text == NULL) {
        return cli_host_exit(host, AIR_ERROR_MEMORY, "describing the scene");
    }
    status = air_snapshot_describe(snapshot, text, &size);
    json_t *const description = status == AIR_OK ? json_loads(text, 0, &error) : NULL;
    free(text);
    if (description == NULL) {
        return cli_host_exit(host, status == AIR_OK ? AIR_ERROR_INTERNAL : status,
                             "describing the scene");
    }
    *out_description = description;
    return CLI_OK;
}

cli_exit cli_scene_load(cli_host *host, const char *path, const cli_scene_options *options,
                        int64_t frame, air_scene **out_scene)
{
    air_load_params params;
    air_load_params_default(&params);
    params.frame = frame;
    params.with = options->with.items;
    params.with_count = options->with.count;
    params.media = options->media.items;
    params.media_count = options->media.count;
    params.environment = options->environment;
    params.defines = options->defines.items;
    params.define_count = options->defines.count;
    params.lenient = options->lenient;
    params.files_anywhere = options->files_anywhere;
    params.light_units = (air_units)options->light_units.value;
    params.emissive_units = (air_units)options->emissive_units.value;
    if (options->scene_index.set) {
        params.scene_index = (int32_t)options->scene_index.value;
    }
    return cli_host_exit(host, air_scene_load(host->context, path, &params, out_scene), path);
}

cli_exit cli_scene_open(cli_host *host, const char *path, const cli_scene_options *options,
                        air_snapshot **out_snapshot, json_t **out_description)
{
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    const int64_t frame = options->frame.set ? (int64_t)options->frame.value : AIR_FRAME_NONE;
    cli_exit result = cli_scene_load(host, path, options, frame, &scene);
    if (result == CLI_OK) {
        result = cli_host_exit(host, air_scene_commit(scene, &snapshot, NULL), path);
    }
    air_scene_destroy(scene);
    if (result == CLI_OK) {
        result = cli_scene_describe(host, snapshot, out_description);
    }
    if (result != CLI_OK) {
        air_snapshot_release(snapshot);
        return result;
    }
    *out_snapshot = snapshot;
    return CLI_OK;
}

cli_exit cli_scene_need_light(cli_host *host, const char *path, const air_snapshot *snapshot,
                              const char *what)
{
    air_scene_info info;
    air_snapshot_info(snapshot, &info);
    if (info.light_present) {
        return CLI_OK;
    }
    cli_say(&host->progress, AIR_MESSAGE_ERROR,
            "%s: no light in the scene, the %s would be black: add one with --environment "
            "constant=1,1,1 or --environment FILE.hdr, or with --with FILE",
            path, what);
    return CLI_FAILED;
}

/* ---- cameras ---- */

static cli_camera read_camera(const json_t *entry)
{
    const json_t *const aspect = json_object_get(entry, "aspect");
    const char *const name = json_string_value(json_object_get(entry, "name"));
    return (cli_camera){
        .handle = (air_handle)json_integer_value(json_object_get(entry, "handle")),
        .name = name != NULL ? name : "",
        .aspect = json_number_value(aspect) > 0.0 ? json_number_value(aspect) : 4.0 / 3.0,
    };
}

/* Says which cameras there are. */
static cli_exit camera_unknown(cli_host *host, const json_t *cameras, const char *wanted)
{
    char list[512] = "";
    size_t index, used = 0;
    const json_t *entry;
    json_array_foreach(cameras, index, entry)
    {
        const cli_camera camera = read_camera(entry);
        if (used < sizeof list) {
            used += (size_t)snprintf(list + used, sizeof list - used, "%s%zu \"%s\"",
                                     index == 0 ? "" : ", ", index, camera.name);
        }
    }
    cli_say(&host->progress, AIR_MESSAGE_ERROR,
            "--camera: expected a name or an index of %s, got \"%s\"", list, wanted);
    return CLI_FAILED;
}

cli_exit cli_scene_camera(cli_host *host, const json_t *description, const char *wanted,
                          cli_camera *out_camera)
{
    const json_t *const cameras = json_object_get(description, "cameras");
    size_t index;
    const json_t *entry;
    json_array_foreach(cameras, index, entry)
    {
        const cli_camera camera = read_camera(entry);
        if (wanted == NULL || strcmp(camera.name, wanted) == 0) {
            *out_camera = camera;
            return CLI_OK;
        }
    }
    if (wanted != NULL && isdigit((unsigned char)wanted[0])) {
        char *end;
        const unsigned long long number = strtoull(wanted, &end, 10);
        entry = number < json_array_size(cameras) ? json_array_get(cameras, (size_t)number) : NULL;
        if (*end == '\0' && entry != NULL) {
            *out_camera = read_camera(entry);
            return CLI_OK;
        }
    }
    return camera_unknown(host, cameras, wanted != NULL ? wanted : "");
}
