/* save_gltf.c: a copy of a glTF scene that shows its lightmap (docs/lightmap-engines.md). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/staging.h"
#include "lightmap/check.h"
#include "lightmap/files.h"
#include "lightmap/gltf_mesh.h"
#include "lightmap/uri.h"

void air_lightmap_gltf_params_default(air_lightmap_gltf_params *params)
{
    *params = (air_lightmap_gltf_params){.show = AIR_SHOW_EMISSIVE, .scale = 1.0f};
}

/* Where the copy goes. */
typedef struct target {
    char *folder, *stem; /* "rooms/", "room" */
    bool binary;         /* .glb */
} target;

static air_status parse_path(air_context *context, const char *path, target *out)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash != NULL ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    out->binary = dot != NULL && strcmp(dot, ".glb") == 0;
    if (dot == NULL || dot == name || (!out->binary && strcmp(dot, ".gltf") != 0)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: expected a name that ends in .glb or .gltf", path);
    }
    out->folder = air_uri_folder(context, path);
    out->stem = air_string_format(context, "%.*s", (int)(dot - name), name);
    return out->folder != NULL && out->stem != NULL ? AIR_OK : air_fail_memory(context, path);
}

/* Lights that are baked shine no more. */
static void remove_lights(air_gltf_copy *copy)
{
    const air_place root = air_gltf_copy_root(copy);
    const air_place nodes = air_place_get(&root, "nodes");
    for (size_t i = 0; i < air_place_count(&nodes); i++) {
        const air_place node = air_place_at(&nodes, i);
        json_t *extensions = json_object_get(node.value, "extensions");
        if (json_object_del(extensions, "KHR_lights_punctual") == 0 &&
            json_object_size(extensions) == 0) {
            json_object_del(node.value, "extensions");
        }
    }
}

/* States the one buffer. uri: NULL for the chunk of a GLB file. */
static air_status state_buffer(air_gltf_copy *copy, const char *uri)
{
    if (copy->binary.size == 0) {
        return AIR_OK;
    }
    json_t *list = air_gltf_copy_list(copy, "buffers");
    if (json_array_size(list) == 0) {
        size_t index;
        const air_status status = air_gltf_copy_append(copy, "buffers", json_object(), &index);
        if (status != AIR_OK) {
            return status;
        }
        list = air_gltf_copy_list(copy, "buffers");
    }
    json_t *buffer = json_array_get(list, 0);
    json_object_set_new(buffer, "byteLength", json_integer((json_int_t)copy->binary.size));
    if (uri != NULL) {
        json_object_set_new(buffer, "uri", json_string(uri));
    }
    return AIR_OK;
}

static air_status write_glb(air_gltf_copy *copy, air_staging *staging, const char *name)
{
    air_status status = state_buffer(copy, NULL);
    char *text = status == AIR_OK ? json_dumps(copy->json, JSON_COMPACT) : NULL;
    if (status == AIR_OK) {
        status = text == NULL ? air_fail_memory(copy->context, name)
                              : air_staging_add_glb(staging, name, text, copy->binary.data,
                                                    copy->binary.size);
    }
    free(text);
    return status;
}

/* NAME.bin, the pages, and NAME.gltf last. */
static air_status write_gltf(air_gltf_show *show, air_staging *staging, const char *stem)
{
    air_gltf_copy *copy = show->copy;
    air_context *context = copy->context;
    char *encoded = air_uri_encode(context, stem);
    char *uri = encoded != NULL ? air_string_format(context, "%s.bin", encoded) : NULL;
    char *name = air_string_format(context, "%s.bin", stem);
    char *index = air_string_format(context, "%s.gltf", stem);
    air_status status = AIR_OK;
    if (uri == NULL || name == NULL || index == NULL) {
        status = air_fail_memory(context, stem);
    }
    if (status == AIR_OK && copy->binary.size > 0) {
        status = air_staging_add(staging, name, copy->binary.data, copy->binary.size);
    }
    for (size_t i = 0; i < show->lightmap->page_count && status == AIR_OK; i++) {
        const air_sink *png = &show->pages[i].png;
        if (png->size == 0) {
            continue; /* pages are not shown */
        }
        char *page = air_string_format(context, "%s-lightmap-%zu.png", stem, i);
        status = page == NULL ? air_fail_memory(context, stem)
                              : air_staging_add(staging, page, png->data, png->size);
        air_free(context, page);
    }
    if (status == AIR_OK) {
        status = state_buffer(copy, uri);
    }
    if (status == AIR_OK) {
        char *text = json_dumps(copy->json, JSON_INDENT(1));
        status = text == NULL ? air_fail_memory(context, stem)
                              : air_staging_add(staging, index, text, strlen(text));
        free(text);
    }
    air_free(context, index);
    air_free(context, name);
    air_free(context, uri);
    air_free(context, encoded);
    return status;
}

static air_status write_copy(air_gltf_show *show, const target *to)
{
    air_context *context = show->copy->context;
    air_staging staging;
    air_status status = air_staging_begin(context, to->folder, &staging);
    if (status == AIR_OK && to->binary) {
        char *name = air_string_format(context, "%s.glb", to->stem);
        status = name == NULL ? air_fail_memory(context, to->stem)
                              : write_glb(show->copy, &staging, name);
        air_free(context, name);
    } else if (status == AIR_OK) {
        status = write_gltf(show, &staging, to->stem);
    }
    if (status == AIR_OK) {
        status = air_staging_commit(&staging);
    }
    air_staging_finish(&staging);
    return status;
}

static air_status change(air_gltf_show *show, const target *to)
{
    air_status status = air_gltf_show_begin(show, to->binary ? NULL : to->stem);
    if (status == AIR_OK) {
        status = air_gltf_mesh_light_all(show);
    }
    if (status == AIR_OK && show->params.show == AIR_SHOW_LIGHTMAP && !show->params.keep_lights) {
        remove_lights(show->copy);
    }
    if (status == AIR_OK && show->guessed) {
        air_warn(show->copy->context,
                 "%s: surfaces with a texture are shown in one colour: the lightmap has no albedo",
                 show->copy->path);
    }
    return status == AIR_OK ? write_copy(show, to) : status;
}

air_status air_lightmap_save_gltf(air_context *context, const air_lightmap *lightmap,
                                  const char *scene_path, const char *path,
                                  const air_lightmap_gltf_params *params)
{
    air_gltf_copy copy = {.context = context};
    air_gltf_show show = {.copy = &copy, .lightmap = lightmap};
    target to = {0};
    air_lightmap_gltf_params_default(&show.params);
    if (params != NULL) {
        show.params = *params;
    }
    if (!(show.params.scale > 0.0f && show.params.scale < INFINITY)) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "%s: the scale is %g, must be positive", path,
                        (double)show.params.scale);
    }
    air_status status = parse_path(context, path, &to);
    if (status == AIR_OK) {
        status = air_lightmap_check(context, lightmap, path, AIR_ERROR_ARGUMENT);
    }
    if (status == AIR_OK) {
        status = air_gltf_copy_read(context, scene_path, &copy);
    }
    if (status == AIR_OK) {
        status = change(&show, &to);
    }
    air_gltf_show_finish(&show);
    air_gltf_copy_finish(&copy);
    air_free(context, to.folder);
    air_free(context, to.stem);
    return status;
}
