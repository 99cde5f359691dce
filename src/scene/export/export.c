#include "scene/export/export.h"

#include <stdlib.h>
#include <string.h>

#include "airlight/version.h"

static const char ending[] = ".glb";
static const char beside[] = ".airlight.json";

/* Splits the path into the folder, "" or with its slash (a fresh string), and the stem. */
static air_status split_path(air_export *self, char **out_folder)
{
    const char *slash = strrchr(self->path, '/');
    const char *name = slash != NULL ? slash + 1 : self->path;
    const size_t length = strlen(name), end = sizeof ending - 1;
    if (length <= end || strcmp(name + length - end, ending) != 0)
        return air_fail(self->context, AIR_ERROR_UNSUPPORTED,
                        "%s: expected a name that ends in .glb", self->path);
    *out_folder = air_string_format(self->context, "%.*s", (int)(name - self->path), self->path);
    self->stem = air_string_format(self->context, "%.*s", (int)(length - end), name);
    return *out_folder != NULL && self->stem != NULL ? AIR_OK
                                                     : air_fail_memory(self->context, self->path);
}

/* A sidecar of this name is read with the file: what came from it would be there twice. */
static air_status refuse_sidecar(const air_export *self, const char *folder)
{
    void *data = NULL;
    size_t size = 0;
    char *path = air_string_format(self->context, "%s%s%s", folder, self->stem, beside);
    if (path == NULL)
        return air_fail_memory(self->context, self->path);
    air_status status = air_file_read_optional(self->context, path, &data, &size);
    if (status == AIR_OK && data != NULL)
        status =
            air_fail(self->context, AIR_ERROR_ARGUMENT,
                     "%s: %s is there and would be read with it, so that what it says would be "
                     "in the scene twice: choose another name",
                     self->path, path);
    air_free(self->context, data);
    air_free(self->context, path);
    return status;
}

/* {"asset": ..., "scene": 0, "scenes": [{"extras": {"airlight": {"version": 1}}}]} */
static void begin_json(air_export *self)
{
    char generator[64];
    (void)snprintf(generator, sizeof generator, "airlight %d.%d.%d", AIR_VERSION_MAJOR,
                   AIR_VERSION_MINOR, AIR_VERSION_PATCH);
    self->root = json_object();
    json_t *asset = air_export_object(self, self->root, "asset");
    air_export_put(self, asset, "version", json_string("2.0"));
    air_export_put(self, asset, "generator", json_string(generator));
    air_export_put(self, self->root, "scene", json_integer(0));
    json_t *scene = json_object();
    air_export_push(self, air_export_list(self, self->root, "scenes"), scene);
    self->airlight = air_export_node_object(self, scene);
    air_export_put(self, self->airlight, "version", json_integer(1));
}

static air_status fill_json(air_export *self)
{
    air_status status = air_export_materials(self);
    if (status == AIR_OK)
        status = air_export_meshes(self);
    if (status == AIR_OK)
        status = air_export_lights(self);
    air_export_cameras(self);
    return status == AIR_OK ? air_export_media(self) : status;
}

static air_status add_glb(air_export *self)
{
    if (self->binary.size > 0) {
        json_t *buffer = json_object();
        air_export_put(self, buffer, "byteLength", json_integer((json_int_t)self->binary.size));
        (void)air_export_append(self, "buffers", buffer);
    }
    /* Nine digits bring a float back exactly. */
    char *text =
        self->failed ? NULL : json_dumps(self->root, JSON_COMPACT | JSON_REAL_PRECISION(9));
    char *name = air_string_format(self->context, "%s%s", self->stem, ending);
    air_status status = AIR_OK;
    if (text == NULL || name == NULL)
        status = air_fail_memory(self->context, self->path);
    else
        status =
            air_staging_add_glb(&self->staging, name, text, self->binary.data, self->binary.size);
    air_free(self->context, name);
    free(text);
    return status;
}

static void export_finish(air_export *self)
{
    for (size_t i = 0; i < self->file_count; ++i)
        air_free(self->context, self->files[i].name);
    air_free(self->context, self->files);
    air_free(self->context, self->textures);
    air_free(self->context, self->blocks);
    air_free(self->context, self->binary.data);
    air_free(self->context, self->stem);
    json_decref(self->root);
}

/* The GLB goes last: where it is, the files that it names are there, too. */
static air_status write_files(air_export *self, const char *folder)
{
    air_status status = air_staging_begin(self->context, folder, &self->staging);
    begin_json(self);
    if (status == AIR_OK)
        status = fill_json(self);
    if (status == AIR_OK)
        status = add_glb(self);
    if (status == AIR_OK)
        status = air_staging_commit(&self->staging);
    for (size_t i = 0; i < self->file_count && status == AIR_OK; ++i)
        air_inform(self->context, "%s: refers to %s beside it", self->path, self->files[i].name);
    air_staging_finish(&self->staging);
    return status;
}

air_status air_scene_save(air_context *context, const air_scene *scene, const char *path)
{
    if (context == NULL)
        return AIR_ERROR_ARGUMENT;
    if (scene == NULL || path == NULL)
        return air_fail(context, AIR_ERROR_ARGUMENT, "air_scene_save: a pointer given is NULL");
    air_export self = {
        .context = context, .scene = scene, .path = path, .binary = {.context = context}};
    char *folder = NULL;
    air_status status = split_path(&self, &folder);
    if (status == AIR_OK)
        status = refuse_sidecar(&self, folder);
    if (status == AIR_OK)
        status = write_files(&self, folder);
    export_finish(&self);
    air_free(context, folder);
    return status;
}
