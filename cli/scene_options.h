/* scene_options.h: the options that say what belongs to a scene, and loading it. */
#ifndef AIR_CLI_SCENE_OPTIONS_H
#define AIR_CLI_SCENE_OPTIONS_H

#include <airlight/scene.h>
#include <jansson.h>

#include "host.h"

typedef struct cli_scene_options {
    cli_list with, media, defines;
    const char *environment;
    cli_count light_units, emissive_units, scene_index, frame;
    bool lenient, files_anywhere;
} cli_scene_options;

/* A camera as the description of a scene lists it. The strings belong to that description. */
typedef struct cli_camera {
    air_handle handle;
    const char *name;
    double aspect; /* width / height */
    air_film_hint film;
} cli_camera;

cli_option_group cli_scene_group(cli_scene_options *options);
/* Without --frame, for a command that has frames of its own. */
cli_option_group cli_scene_group_of_frames(cli_scene_options *options);

/* Loads a scene at a frame; options->frame is not looked at. */
cli_exit cli_scene_load(cli_host *host, const char *path, const cli_scene_options *options,
                        int64_t frame, air_scene **out_scene);
/* Parses what air_snapshot_describe says. */
cli_exit cli_scene_describe(cli_host *host, const air_snapshot *snapshot, json_t **out_description);

/* Both, of a scene that is then frozen, at options->frame. On failure the
 * outputs stay as they are, and what is wrong has been printed. */
cli_exit cli_scene_open(cli_host *host, const char *path, const cli_scene_options *options,
                        air_snapshot **out_snapshot, json_t **out_description);

/* The camera of this name, or of this index as `airlight info` counts them; wanted NULL: the first.
 */
cli_exit cli_scene_camera(cli_host *host, const json_t *description, const char *wanted,
                          cli_camera *out_camera);

/* Fails, and says why, where no light is in the scene: `what` ("picture") would be black. */
cli_exit cli_scene_need_light(cli_host *host, const char *path, const air_snapshot *snapshot,
                              const char *what);

#endif
