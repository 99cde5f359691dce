/* load.c: air_scene_load: which reader a scene file goes to, and what all of them have in common.
 */
#include <string.h>

#include "scene/import/import.h"
#include "scene/import/resource.h"

void air_load_params_default(air_load_params *params)
{
    *params = (air_load_params){.light_units = AIR_UNITS_AUTO,
                                .emissive_units = AIR_UNITS_AUTO,
                                .scene_index = -1,
                                .frame = AIR_FRAME_NONE};
}

/* The sidecars that are not in the scene file: later ones have the last word. */
static air_status add_sidecars(air_import *import, const char *path)
{
    const air_load_params *params = import->params;
    char *beside = air_path_with_ending(import->context, path, ".airlight.json");
    if (beside == NULL)
        return AIR_ERROR_MEMORY;
    air_status status = air_sidecar_add_file(import, beside, true);
    air_free(import->context, beside);
    for (size_t i = 0; i < params->with_count && status == AIR_OK; ++i)
        status = air_sidecar_add_file(import, params->with[i], false);
    for (size_t i = 0; i < params->media_count && status == AIR_OK; ++i)
        status = air_sidecar_add_argument(import, params->media[i], i + 1);
    return status;
}

air_status air_import_fill(air_import *import, const char *path)
{
    air_status status = add_sidecars(import, path);
    if (status == AIR_OK)
        status = air_sidecars_mark(import);
    if (status == AIR_OK)
        status = air_sidecars_add_cameras(import);
    if (status == AIR_OK)
        status = import->add_objects(import->user);
    if (status == AIR_OK)
        status = air_sidecars_add(import);
    if (status == AIR_OK && import->params->environment != NULL)
        status = air_environment_argument_add(import, import->params->environment);
    return status;
}

static bool ends_with(const char *path, const char *ending)
{
    const size_t length = strlen(path), tail = strlen(ending);
    return length >= tail && strcmp(path + length - tail, ending) == 0;
}

air_status air_scene_load(air_context *context, const char *path, const air_load_params *params,
                          air_scene **out_scene)
{
    air_load_params defaults;
    air_load_params_default(&defaults);
    if (out_scene == NULL)
        return air_fail(context, AIR_ERROR_ARGUMENT, "air_scene_load: out_scene is NULL");
    *out_scene = NULL;
    if (path == NULL)
        return air_fail(context, AIR_ERROR_ARGUMENT, "air_scene_load: path is NULL");
    air_import import = {.context = context, .params = params != NULL ? params : &defaults};
    air_status status = air_scene_create(context, &import.scene);
    if (status == AIR_OK)
        status = air_scene_set_frame(import.scene, import.params->frame);
    if (status == AIR_OK)
        status = ends_with(path, ".xml") ? air_mitsuba_read(&import, path)
                                         : air_gltf_read(&import, path);
    air_import_finish(&import);
    if (status == AIR_OK)
        *out_scene = import.scene;
    else
        air_scene_destroy(import.scene);
    return status;
}
