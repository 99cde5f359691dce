#include <stdio.h>
#include <string.h>

#include "scene/import/import.h"
#include "scene/import/resource.h"

static const float identity[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                   0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};

static air_json_document document_of(const air_import *import, const air_sidecar *sidecar)
{
    return (air_json_document){.context = import->context,
                               .file = sidecar->file,
                               .prefix = sidecar->prefix,
                               .folder = sidecar->folder,
                               .columns = sidecar->column_count > 0 ? sidecar->columns : NULL,
                               .column_count = sidecar->column_count};
}

/* Appends a sidecar with copies of three strings; NULL when memory is out, which is then reported.
 */
static air_sidecar *append_sidecar(air_import *import, const char *file, const char *prefix,
                                   const char *folder)
{
    air_context *context = import->context;
    if (import->sidecar_count == import->sidecar_capacity) {
        const size_t capacity = 2 * import->sidecar_capacity + 4;
        air_sidecar *sidecars =
            air_reallocate(context, import->sidecars, capacity, sizeof *sidecars);
        if (sidecars == NULL) {
            (void)air_fail_memory(context, file);
            return NULL;
        }
        import->sidecars = sidecars;
        import->sidecar_capacity = capacity;
    }
    air_sidecar *sidecar = &import->sidecars[import->sidecar_count++];
    *sidecar = (air_sidecar){.file = air_string_copy(context, file),
                             .prefix = air_string_copy(context, prefix),
                             .folder = air_string_copy(context, folder),
                             .object = SIZE_MAX};
    memcpy(sidecar->to_world, identity, sizeof identity);
    if (sidecar->file != NULL && sidecar->prefix != NULL && sidecar->folder != NULL)
        return sidecar;
    (void)air_fail_memory(context, file);
    return NULL;
}

air_status air_sidecar_add_value(air_import *import, const air_json *at, const float to_world[12],
                                 air_sidecar_place place, size_t object)
{
    char prefix[128];
    air_json_describe(at, prefix, sizeof prefix);
    air_sidecar *sidecar = append_sidecar(import, at->document->file, prefix, at->document->folder);
    if (sidecar == NULL)
        return AIR_ERROR_MEMORY;
    memcpy(sidecar->to_world, to_world, sizeof sidecar->to_world);
    sidecar->place = place;
    sidecar->object = object;
    if (!json_is_string(at->value)) {
        sidecar->json = json_incref(at->value);
        return AIR_OK;
    }
    const air_json_document document = document_of(import, sidecar);
    return air_json_parse(&document, json_string_value(at->value), json_string_length(at->value),
                          &sidecar->json);
}

air_status air_sidecar_add_file(air_import *import, const char *path, bool optional)
{
    air_context *context = import->context;
    void *data = NULL;
    size_t size = 0;
    air_status status = optional ? air_file_read_optional(context, path, &data, &size)
                                 : air_file_read(context, path, &data, &size);
    if (status != AIR_OK || data == NULL)
        return status;
    char *folder = air_path_folder(context, path);
    air_sidecar *sidecar = folder == NULL ? NULL : append_sidecar(import, path, "$", folder);
    status = AIR_ERROR_MEMORY;
    if (sidecar != NULL) {
        const air_json_document document = document_of(import, sidecar);
        status = air_json_parse(&document, data, size, &sidecar->json);
    }
    air_free(context, folder);
    air_free(context, data);
    return status;
}

/* How messages name an argument: a long one, as JSON with a table in it is, by its beginning. */
static char *name_argument(air_context *context, const char *argument)
{
    enum { SHOWN = 200 };
    int length = (int)strnlen(argument, SHOWN + 1);
    const bool cut = length > SHOWN;
    if (cut) {
        length = SHOWN;
        while (length > 0 &&
               ((unsigned char)argument[length] & 0xC0) == 0x80) /* not inside a UTF-8 sequence */
            --length;
    }
    return air_string_format(context, "--medium \"%.*s%s\"", length, argument, cut ? "..." : "");
}

air_status air_sidecar_add_argument(air_import *import, const char *argument, size_t number)
{
    char *file = name_argument(import->context, argument);
    if (file == NULL)
        return air_fail_memory(import->context, "--medium");
    air_sidecar *sidecar = append_sidecar(import, file, "$", "");
    air_free(import->context, file);
    if (sidecar == NULL)
        return AIR_ERROR_MEMORY;
    sidecar->place = AIR_SIDECAR_ARGUMENT;
    sidecar->number = number;
    return air_medium_argument_parse(import->context, sidecar->file, argument, &sidecar->json,
                                     sidecar->columns, &sidecar->column_count);
}

/* ---- marking ---- */

static air_status read_flags(const air_json *at, air_import_object *object)
{
    const air_json camera_visible = air_json_get(at, "camera_visible");
    const air_json casts_shadow = air_json_get(at, "casts_shadow");
    const air_status status = air_json_bool(&camera_visible, &object->camera_visible);
    return status == AIR_OK ? air_json_bool(&casts_shadow, &object->casts_shadow) : status;
}

/* "objects": {"NAME": {"camera_visible": false}} */
static air_status mark_objects(air_import *import, const air_json *objects)
{
    static const char *const keys[] = {"camera_visible", "casts_shadow"};
    air_status status = air_json_check_object(objects, false);
    const char *name;
    json_t *value;
    json_object_foreach(objects->value, name, value)
    {
        const air_json at = air_json_get(objects, name);
        if (status == AIR_OK)
            status = air_json_check_object(&at, true);
        if (status == AIR_OK)
            status = air_json_check_keys(&at, keys, 2);
        if (status == AIR_OK && air_import_find(import, name, 0) == SIZE_MAX)
            status = air_import_unknown_name(import, &at, name);
        for (size_t i = air_import_find(import, name, 0); i != SIZE_MAX && status == AIR_OK;
             i = air_import_find(import, name, i + 1))
            status = read_flags(&at, &import->objects[i]);
        if (status != AIR_OK)
            break;
    }
    return status;
}

static air_status check_version(const air_json *root)
{
    const air_json at = air_json_get(root, "version");
    size_t version = 1;
    const air_status status = air_json_size(&at, &version);
    if (status == AIR_OK && version != 1)
        return air_json_expected(&at, "version 1");
    return status;
}

static air_status check_shape(const air_sidecar *sidecar, const air_json *root)
{
    static const char *const node_keys[] = {
        "media",       "lights",         "camera",        "objects",  "version",
        "medium",      "camera_visible", "casts_shadow",  "shape",    "flip_normals",
        "lens_radius", "focus_distance", "near_distance", "mirrored", "film"};
    const size_t node_key_count = sizeof node_keys / sizeof node_keys[0];
    const air_json media = air_json_get(root, "media");
    const air_json lights = air_json_get(root, "lights");
    air_status status = air_json_check_object(root, true);
    /* but for the first five, keys are about the node that a sidecar stands on */
    if (status == AIR_OK)
        status = air_json_check_keys(root, node_keys,
                                     sidecar->place == AIR_SIDECAR_NODE ? node_key_count : 5);
    if (status == AIR_OK)
        status = check_version(root);
    if (status == AIR_OK)
        status = air_json_check_array(&media, false);
    return status == AIR_OK ? air_json_check_array(&lights, false) : status;
}

/* The object whose mesh bounds the medium of the node that a sidecar stands on, SIZE_MAX if it has
 * no mesh. */
static size_t bounding_object(const air_import *import, const air_sidecar *sidecar)
{
    const size_t object = sidecar->object;
    return object != SIZE_MAX && import->objects[object].mesh != SIZE_MAX ? object : SIZE_MAX;
}

static air_status mark_media(air_import *import, const air_sidecar *sidecar, const air_json *root)
{
    const air_json medium = air_json_get(root, "medium");
    const air_json media = air_json_get(root, "media");
    const air_json boundary = air_json_get(&medium, "boundary");
    const air_json density = air_json_get(&medium, "density");
    air_sidecar_part part = {.import = import,
                             .at = &medium,
                             .to_world = sidecar->to_world,
                             .object = bounding_object(import, sidecar)};
    air_status status = AIR_OK;
    if (json_is_object(medium.value) && part.object == SIZE_MAX && boundary.value == NULL &&
        density.value == NULL)
        status = air_json_expected(&boundary, "a boundary, as the node has no mesh");
    if (status == AIR_OK && medium.value != NULL)
        status = air_sidecar_mark_boundary(&part);
    part.object = SIZE_MAX;
    for (size_t i = 0; i < air_json_count(&media) && status == AIR_OK; ++i) {
        const air_json at = air_json_at(&media, i);
        part.at = &at;
        status = air_sidecar_mark_boundary(&part);
    }
    return status;
}

static air_status mark(air_import *import, const air_sidecar *sidecar)
{
    const air_json_document document = document_of(import, sidecar);
    const air_json root = air_json_root(&document, sidecar->json);
    if (sidecar->place == AIR_SIDECAR_ARGUMENT) {
        const air_sidecar_part part = {
            .import = import, .at = &root, .to_world = sidecar->to_world, .object = SIZE_MAX};
        return air_sidecar_mark_boundary(&part);
    }
    const air_json objects = air_json_get(&root, "objects");
    air_status status = check_shape(sidecar, &root);
    if (status == AIR_OK && sidecar->object != SIZE_MAX)
        status = read_flags(&root, &import->objects[sidecar->object]);
    if (status == AIR_OK && sidecar->object != SIZE_MAX)
        status = air_sidecar_read_node(&root, &import->objects[sidecar->object]);
    if (status == AIR_OK)
        status = mark_objects(import, &objects);
    return status == AIR_OK ? mark_media(import, sidecar, &root) : status;
}

air_status air_sidecars_mark(air_import *import)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < import->sidecar_count && status == AIR_OK; ++i)
        status = mark(import, &import->sidecars[i]);
    return status;
}

/* ---- adding ---- */

air_status air_sidecars_add_cameras(air_import *import)
{
    air_status status = AIR_OK;
    for (size_t i = import->sidecar_count; i > 0 && status == AIR_OK; --i) {
        const air_sidecar *sidecar = &import->sidecars[i - 1];
        const air_json_document document = document_of(import, sidecar);
        const air_json root = air_json_root(&document, sidecar->json);
        const air_json camera = air_json_get(&root, "camera");
        const air_sidecar_part part = {.import = import,
                                       .at = &camera,
                                       .to_world = sidecar->to_world,
                                       .object = SIZE_MAX,
                                       .fallback_name = "airlight"};
        if (sidecar->place != AIR_SIDECAR_ARGUMENT && camera.value != NULL)
            status = air_sidecar_add_camera(&part);
    }
    return status;
}

/* Adds each element of a list. */
static air_status add_list(air_import *import, const air_sidecar *sidecar, const air_json *list,
                           const char *what, air_status (*add)(const air_sidecar_part *part))
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < air_json_count(list) && status == AIR_OK; ++i) {
        const air_json at = air_json_at(list, i);
        char name[32];
        snprintf(name, sizeof name, "%s[%zu]", what, i);
        const air_sidecar_part part = {.import = import,
                                       .at = &at,
                                       .to_world = sidecar->to_world,
                                       .object = SIZE_MAX,
                                       .fallback_name = name};
        status = add(&part);
    }
    return status;
}

static air_status add(air_import *import, const air_sidecar *sidecar)
{
    const air_json_document document = document_of(import, sidecar);
    const air_json root = air_json_root(&document, sidecar->json);
    air_sidecar_part part = {
        .import = import, .at = &root, .to_world = sidecar->to_world, .object = SIZE_MAX};
    if (sidecar->place == AIR_SIDECAR_ARGUMENT) {
        char name[48];
        snprintf(name, sizeof name, "medium %zu", sidecar->number);
        part.fallback_name = name;
        return air_sidecar_add_medium(&part);
    }
    const air_json medium = air_json_get(&root, "medium");
    const air_json media = air_json_get(&root, "media");
    const air_json lights = air_json_get(&root, "lights");
    air_status status = AIR_OK;
    if (medium.value != NULL) {
        const air_import_object *object =
            sidecar->object != SIZE_MAX ? &import->objects[sidecar->object] : NULL;
        part.at = &medium;
        part.object = bounding_object(import, sidecar);
        part.fallback_name = object != NULL && object->name[0] != '\0' ? object->name : "medium";
        status = air_sidecar_add_medium(&part);
    }
    if (status == AIR_OK)
        status = add_list(import, sidecar, &media, "media", air_sidecar_add_medium);
    return status == AIR_OK ? add_list(import, sidecar, &lights, "lights", air_sidecar_add_light)
                            : status;
}

air_status air_sidecars_add(air_import *import)
{
    air_status status = AIR_OK;
    for (size_t i = 0; i < import->sidecar_count && status == AIR_OK; ++i)
        status = add(import, &import->sidecars[i]);
    return status;
}
