#include "scene/import/gltf.h"

#include <string.h>

#include "scene/import/resource.h"

static void gltf_finish(air_gltf *gltf)
{
    for (size_t i = 0; gltf->buffer_store != NULL && i < air_json_count(&gltf->buffers); ++i)
        if (gltf->buffer_store[i].owned)
            air_free(gltf->context, gltf->buffer_store[i].data);
    air_free(gltf->context, gltf->buffer_store);
    air_free(gltf->context, gltf->volume_store);
    air_free(gltf->context, gltf->material_store);
    air_free(gltf->context, gltf->texture_store);
    air_free(gltf->context, gltf->folder);
    air_free(gltf->context, gltf->file);
    json_decref(gltf->json);
}

/* One of the file's lists of things, which may be absent. */
static air_status open_list(const air_json *parent, const char *key, air_json *out)
{
    *out = air_json_get(parent, key);
    return air_json_check_array(out, false);
}

static air_status open_lists(air_gltf *gltf)
{
    const struct {
        const char *key;
        air_json *list;
    } lists[] = {
        {"accessors", &gltf->accessors}, {"bufferViews", &gltf->buffer_views},
        {"buffers", &gltf->buffers},     {"materials", &gltf->materials},
        {"meshes", &gltf->meshes},       {"nodes", &gltf->nodes},
        {"images", &gltf->images},       {"textures", &gltf->textures},
        {"samplers", &gltf->samplers},   {"cameras", &gltf->cameras},
        {"scenes", &gltf->scenes},       {"animations", &gltf->animations},
    };
    air_status status = air_json_check_object(&gltf->root, true);
    for (size_t i = 0; i < sizeof lists / sizeof lists[0] && status == AIR_OK; ++i)
        status = open_list(&gltf->root, lists[i].key, lists[i].list);
    if (status != AIR_OK)
        return status;
    gltf->extensions = air_json_get(&gltf->root, "extensions");
    gltf->punctual = air_json_get(&gltf->extensions, "KHR_lights_punctual");
    return open_list(&gltf->punctual, "lights", &gltf->lights);
}

/* Reads the file and checks its frame: container, JSON, lists, version, extensions. */
static air_status open_file(air_gltf *gltf)
{
    const char *text = NULL;
    size_t size = 0, text_size = 0;
    gltf->folder = air_path_folder(gltf->context, gltf->path);
    if (gltf->folder == NULL)
        return AIR_ERROR_MEMORY;
    gltf->document = (air_json_document){
        .context = gltf->context, .file = gltf->path, .prefix = "$", .folder = gltf->folder};
    air_status status = air_file_read(gltf->context, gltf->path, &gltf->file, &size);
    if (status == AIR_OK)
        status = air_gltf_split(gltf->context, gltf->path, gltf->file, size, &text, &text_size,
                                &gltf->chunk, &gltf->chunk_size);
    if (status == AIR_OK)
        status = air_json_parse(&gltf->document, text, text_size, &gltf->json);
    if (status != AIR_OK)
        return status;
    gltf->root = air_json_root(&gltf->document, gltf->json);
    status = open_lists(gltf);
    if (status == AIR_OK)
        status = air_gltf_check_asset(gltf);
    if (status != AIR_OK)
        return status;
    gltf->buffer_store =
        air_allocate(gltf->context, air_json_count(&gltf->buffers), sizeof *gltf->buffer_store);
    gltf->material_store =
        air_allocate(gltf->context, air_json_count(&gltf->materials), sizeof *gltf->material_store);
    gltf->volume_store =
        air_allocate(gltf->context, air_json_count(&gltf->materials), sizeof *gltf->volume_store);
    if (gltf->buffer_store == NULL || gltf->material_store == NULL || gltf->volume_store == NULL)
        return air_fail_memory(gltf->context, gltf->path);
    return AIR_OK;
}

/* Photometric quantities become radiometric ones by the luminous efficacy of 683 lm/W, the same for
 * every channel. */
static float scale_of(air_units units)
{
    return units == AIR_UNITS_PHOTOMETRIC ? 1.0f / 683.0f : 1.0f;
}

static air_status choose_units(air_gltf *gltf)
{
    air_units lights = gltf->import->params->light_units,
              emission = gltf->import->params->emissive_units;
    if (lights == AIR_UNITS_AUTO)
        lights = AIR_UNITS_PHOTOMETRIC;
    if (emission == AIR_UNITS_AUTO)
        emission = air_gltf_from_blender(gltf) ? AIR_UNITS_RADIOMETRIC : AIR_UNITS_PHOTOMETRIC;
    gltf->light_scale = scale_of(lights);
    gltf->emission_scale = scale_of(emission);
    return air_scene_set_source(gltf->import->scene, gltf->path, lights, emission);
}

static air_status add_objects(void *user)
{
    air_gltf *gltf = user;
    air_import *import = gltf->import;
    air_status status = AIR_OK;
    for (size_t i = 0; i < import->object_count && status == AIR_OK; ++i) {
        const air_import_object *object = &import->objects[i];
        if (object->mesh != SIZE_MAX && !object->bounds_medium)
            status = air_gltf_add_mesh(gltf, object);
        if (status == AIR_OK && object->light != SIZE_MAX)
            status = air_gltf_add_light(gltf, object);
        if (status == AIR_OK && object->camera != SIZE_MAX)
            status = air_gltf_add_camera(gltf, object);
    }
    return status;
}

/* Says once what was left out, and how often. */
static air_status report(air_gltf *gltf)
{
    const air_gltf_tally *tally = &gltf->tally;
    const struct {
        size_t count;
        bool warn;
        const char *text;
    } lines[] = {
        {tally->lines_and_points, true, "primitives of points or lines left out"},
        {tally->partial_triangles, true, "triangle lists that do not divide by three, cut short"},
        {tally->flattened_nodes, true, "nodes with a mesh scaled to nothing and left out"},
        {tally->skins, true, "skinned meshes shown in their rest pose"},
        {tally->morphs, true, "primitives with morph targets shown in their rest pose"},
        {air_json_count(&gltf->animations), true,
         "animations left out, the scene is in its rest pose"},
        {tally->strong_emission, true, "materials with an emissiveFactor above 1, taken as it is"},
        {tally->texture_sets, true, "textures with a coordinate set above TEXCOORD_1 left out"},
        {tally->missing_sources, true, "textures without a PNG or JPEG source left out"},
        {tally->specular_textures, true,
         "materials whose reflectance is tinted or textured, taken without"},
        {tally->open_volumes, true,
         "meshes that are not closed, whose glass is left without absorption"},
        {tally->crowded_volumes, true,
         "meshes whose glass is left without absorption, for there are too many"},
        {tally->ranges, false, "lights whose range is ignored: they fall off by distance alone"},
        {tally->degenerate_triangles, false, "triangles without area left out"},
        {tally->zero_normals, false, "vertex normals of length 0 replaced"},
    };
    air_status status = AIR_OK;
    for (size_t i = 0; i < sizeof lines / sizeof lines[0] && status == AIR_OK; ++i) {
        if (lines[i].count > 0 && lines[i].warn)
            status = air_import_warn(gltf->import, "%s: %s: %zu", gltf->path, lines[i].text,
                                     lines[i].count);
        else if (lines[i].count > 0)
            air_inform(gltf->context, "%s: %s: %zu", gltf->path, lines[i].text, lines[i].count);
    }
    return status;
}

static air_status read_scene(air_gltf *gltf)
{
    air_status status = open_file(gltf);
    if (status == AIR_OK)
        status = choose_units(gltf);
    if (status == AIR_OK)
        status = air_gltf_walk(gltf);
    if (status == AIR_OK)
        status = air_import_fill(gltf->import, gltf->path);
    return status == AIR_OK ? report(gltf) : status;
}

air_status air_gltf_read(air_import *import, const char *path)
{
    air_gltf gltf = {.context = import->context, .import = import, .path = path};
    import->append_geometry = air_gltf_append_geometry;
    import->add_objects = add_objects;
    import->user = &gltf;
    const air_status status = read_scene(&gltf);
    gltf_finish(&gltf);
    return status;
}
