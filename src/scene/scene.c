/* Editing: handles, references between objects, adding, replacing, removing. */
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

#include "scene/camera.h"
#include "scene/grid_record.h"
#include "scene/light_record.h"
#include "scene/material.h"
#include "scene/medium_record.h"
#include "scene/mesh.h"
#include "scene/subject.h"
#include "scene/texture.h"

/* A handle is the kind of its object, counted from 1, above a number counted from 1 among that
 * kind. */
enum { HANDLE_NUMBER_BITS = 28 };

/* ---- handles ---- */

static air_handle make_handle(air_object_kind kind, uint32_t number)
{
    return (((uint32_t)kind + 1) << HANDLE_NUMBER_BITS) | number;
}

static uint32_t handle_kind_bits(air_handle handle) { return handle >> HANDLE_NUMBER_BITS; }

static bool handle_has_kind(air_handle handle, air_object_kind kind)
{
    return handle_kind_bits(handle) == (uint32_t)kind + 1;
}

static air_slot *find_slot(air_scene *scene, air_handle handle)
{
    const uint32_t kind_bits = handle_kind_bits(handle);
    if (kind_bits < 1 || kind_bits > AIR_OBJECT_KIND_COUNT)
        return NULL;
    air_slot_list *list = &scene->lists[kind_bits - 1];
    const size_t index = air_slot_find(list, handle);
    return index == SIZE_MAX ? NULL : &list->slots[index];
}

/* What is wrong with a handle that names no object of the kind wanted. */
static const char *describe_handle(air_scene *scene, air_handle handle, char *text, size_t size)
{
    const air_slot *slot = find_slot(scene, handle);
    if (slot != NULL)
        snprintf(text, size, "names the %s \"%s\"",
                 air_object_kind_name((air_object_kind)(handle_kind_bits(handle) - 1)),
                 slot->record->name);
    else
        snprintf(text, size, handle == AIR_NONE ? "is AIR_NONE" : "names nothing in this scene");
    return text;
}

/* ---- references between objects ---- */

static size_t list_links(air_object_kind kind, const air_record *record,
                         air_link links[AIR_MAX_LINKS])
{
    switch (kind) {
    case AIR_OBJECT_MATERIAL:
        air_material_links(&((const air_material_record *)record)->desc, links);
        return AIR_MAX_LINKS;
    case AIR_OBJECT_MESH:
        links[0] = (air_link){((const air_mesh_record *)record)->material, AIR_OBJECT_MATERIAL,
                              "material", false};
        return 1;
    case AIR_OBJECT_MEDIUM:
        return air_medium_links(&((const air_medium_record *)record)->desc, links);
    case AIR_OBJECT_LIGHT:
        return air_light_links(&((const air_light_record *)record)->desc, links);
    default:
        return 0;
    }
}

static air_status check_links(air_scene *scene, air_object_kind kind, const air_record *record)
{
    air_link links[AIR_MAX_LINKS];
    const size_t count = list_links(kind, record, links);
    for (size_t i = 0; i < count; ++i) {
        const bool found = handle_has_kind(links[i].handle, links[i].kind) &&
                           find_slot(scene, links[i].handle) != NULL;
        if (found || (links[i].handle == AIR_NONE && !links[i].required))
            continue;
        const air_subject subject = {scene->context, air_object_kind_name(kind), record->name};
        char text[300];
        return air_subject_fail(&subject, "%s has to be a handle of a %s, but it %s",
                                links[i].field, air_object_kind_name(links[i].kind),
                                describe_handle(scene, links[i].handle, text, sizeof text));
    }
    return AIR_OK;
}

/* Counts (or no longer counts) the object as a user of what it refers to. */
static void count_links(air_scene *scene, air_object_kind kind, const air_record *record, bool add)
{
    air_link links[AIR_MAX_LINKS];
    const size_t count = list_links(kind, record, links);
    for (size_t i = 0; i < count; ++i) {
        air_slot *slot = find_slot(scene, links[i].handle);
        if (slot != NULL)
            slot->users = add ? slot->users + 1 : slot->users - 1;
    }
}

/* ---- adding, replacing, removing ---- */

static air_status append_slot(air_scene *scene, air_object_kind kind, air_record *record,
                              air_handle *out_handle)
{
    air_slot_list *list = &scene->lists[kind];
    if (kind == AIR_OBJECT_MEDIUM && list->count >= AIR_MAX_MEDIA)
        return air_fail(scene->context, AIR_ERROR_ARGUMENT,
                        "medium \"%s\": a scene can have at most %d media", record->name,
                        AIR_MAX_MEDIA);
    if (list->last_number + 1 >= (uint32_t)1 << HANDLE_NUMBER_BITS)
        return air_fail(scene->context, AIR_ERROR_ARGUMENT, "%s \"%s\": there are no handles left",
                        air_object_kind_name(kind), record->name);
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity == 0 ? 8 : 2 * list->capacity;
        air_slot *grown = air_reallocate(scene->context, list->slots, capacity, sizeof *grown);
        if (grown == NULL)
            return air_fail_memory(scene->context, "scene");
        list->slots = grown;
        list->capacity = capacity;
    }
    const air_handle handle = make_handle(kind, ++list->last_number);
    list->slots[list->count++] = (air_slot){.handle = handle, .record = record};
    *out_handle = handle;
    return AIR_OK;
}

/* Checks and copies a description of that kind. previous: what it will replace, or NULL. */
static air_status create_record(air_context *context, air_object_kind kind, const void *desc,
                                const air_record *previous, air_record **out_record)
{
    switch (kind) {
    case AIR_OBJECT_TEXTURE:
        return air_texture_record_create(context, desc, out_record);
    case AIR_OBJECT_MATERIAL:
        return air_material_record_create(context, desc, out_record);
    case AIR_OBJECT_MESH:
        return air_mesh_record_create(context, desc, (const air_mesh_record *)previous, out_record);
    case AIR_OBJECT_MEDIUM:
        return air_medium_record_create(context, desc, out_record);
    case AIR_OBJECT_LIGHT:
        return air_light_record_create(context, desc, out_record);
    case AIR_OBJECT_CAMERA:
        return air_camera_record_create(context, desc, out_record);
    case AIR_OBJECT_GRID:
        return air_grid_record_create(context, desc, out_record);
    case AIR_OBJECT_KIND_COUNT:
        break;
    }
    return air_fail(context, AIR_ERROR_INTERNAL, "no description makes a %s",
                    air_object_kind_name(kind));
}

/* Adds a record, which is taken. */
static air_status add_record(air_scene *scene, air_object_kind kind, air_record *record,
                             air_handle *out_handle)
{
    air_status status = check_links(scene, kind, record);
    if (status == AIR_OK)
        status = append_slot(scene, kind, record, out_handle);
    if (status == AIR_OK)
        count_links(scene, kind, record, true);
    else
        air_record_release(record);
    return status;
}

static air_status check_arguments(air_scene *scene, air_object_kind kind, const void *in,
                                  const void *out)
{
    if (scene == NULL)
        return AIR_ERROR_ARGUMENT;
    if (in == NULL || out == NULL)
        return air_fail(scene->context, AIR_ERROR_ARGUMENT, "%s: a pointer given is NULL",
                        air_object_kind_name(kind));
    return AIR_OK;
}

static air_status add_object(air_scene *scene, air_object_kind kind, const void *desc,
                             air_handle *out_handle)
{
    air_record *record = NULL;
    air_status status = check_arguments(scene, kind, desc, out_handle);
    if (status == AIR_OK)
        status = create_record(scene->context, kind, desc, NULL, &record);
    return status == AIR_OK ? add_record(scene, kind, record, out_handle) : status;
}

static air_status set_object(air_scene *scene, air_object_kind kind, air_handle handle,
                             const void *desc)
{
    air_status status = check_arguments(scene, kind, desc, desc);
    if (status != AIR_OK)
        return status;
    air_record *record = NULL;
    air_slot *slot = handle_has_kind(handle, kind) ? find_slot(scene, handle) : NULL;
    char text[300];
    if (slot == NULL)
        return air_fail(scene->context, AIR_ERROR_ARGUMENT,
                        "the handle of the %s to be replaced %s", air_object_kind_name(kind),
                        describe_handle(scene, handle, text, sizeof text));
    status = create_record(scene->context, kind, desc, slot->record, &record);
    if (status == AIR_OK)
        status = check_links(scene, kind, record);
    if (status != AIR_OK) {
        air_record_release(record);
        return status;
    }
    count_links(scene, kind, record, true);
    count_links(scene, kind, slot->record, false);
    air_record_release(slot->record);
    slot->record = record;
    return AIR_OK;
}

air_status air_scene_remove(air_scene *scene, air_handle handle)
{
    if (scene == NULL)
        return AIR_ERROR_ARGUMENT;
    air_slot *slot = find_slot(scene, handle);
    char text[300];
    if (slot == NULL)
        return air_fail(scene->context, AIR_ERROR_ARGUMENT, "the handle to be removed %s",
                        describe_handle(scene, handle, text, sizeof text));
    const air_object_kind kind = (air_object_kind)(handle_kind_bits(handle) - 1);
    if (slot->users > 0) {
        const air_subject subject = {scene->context, air_object_kind_name(kind),
                                     slot->record->name};
        return air_subject_fail(&subject, "cannot be removed: other objects refer to it %zu time%s",
                                slot->users, slot->users == 1 ? "" : "s");
    }
    air_slot_list *list = &scene->lists[kind];
    count_links(scene, kind, slot->record, false);
    air_record_release(slot->record);
    for (size_t i = (size_t)(slot - list->slots); i + 1 < list->count; ++i)
        list->slots[i] = list->slots[i + 1];
    --list->count;
    return AIR_OK;
}

/* ---- the scene itself ---- */

air_status air_scene_create(air_context *context, air_scene **out_scene)
{
    if (out_scene != NULL)
        *out_scene = NULL;
    if (context == NULL || out_scene == NULL)
        return AIR_ERROR_ARGUMENT;
    air_scene *scene = air_allocate(context, 1, sizeof *scene);
    if (scene == NULL)
        return air_fail_memory(context, "scene");
    scene->context = context;
    scene->light_units = AIR_UNITS_RADIOMETRIC;
    scene->emissive_units = AIR_UNITS_RADIOMETRIC;
    scene->frame = AIR_FRAME_NONE;
    *out_scene = scene;
    return AIR_OK;
}

void air_scene_destroy(air_scene *scene)
{
    if (scene == NULL)
        return;
    air_context *context = scene->context;
    for (size_t kind = 0; kind < AIR_OBJECT_KIND_COUNT; ++kind) {
        for (size_t i = 0; i < scene->lists[kind].count; ++i)
            air_record_release(scene->lists[kind].slots[i].record);
        air_free(context, scene->lists[kind].slots);
    }
    for (size_t i = 0; i < scene->warning_count; ++i)
        air_free(context, scene->warnings[i]);
    air_free(context, scene->warnings);
    air_free(context, scene->source);
    air_snapshot_release(scene->last);
    air_free(context, scene);
}

air_status air_scene_set_source(air_scene *scene, const char *path, air_units light_units,
                                air_units emissive_units)
{
    if (scene == NULL)
        return AIR_ERROR_ARGUMENT;
    if ((light_units != AIR_UNITS_RADIOMETRIC && light_units != AIR_UNITS_PHOTOMETRIC) ||
        (emissive_units != AIR_UNITS_RADIOMETRIC && emissive_units != AIR_UNITS_PHOTOMETRIC))
        return air_fail(
            scene->context, AIR_ERROR_ARGUMENT,
            "scene source: units are %d and %d, but must be radiometric (%d) or photometric (%d)",
            (int)light_units, (int)emissive_units, AIR_UNITS_RADIOMETRIC, AIR_UNITS_PHOTOMETRIC);
    char *copy = air_string_copy(scene->context, path);
    if (copy == NULL)
        return air_fail_memory(scene->context, "scene source");
    air_free(scene->context, scene->source);
    scene->source = copy;
    scene->light_units = light_units;
    scene->emissive_units = emissive_units;
    return AIR_OK;
}

air_status air_scene_add_warning(air_scene *scene, const char *text)
{
    if (scene == NULL || text == NULL)
        return AIR_ERROR_ARGUMENT;
    air_warn(scene->context, "%s", text);
    char **grown =
        air_reallocate(scene->context, scene->warnings, scene->warning_count + 1, sizeof *grown);
    if (grown == NULL)
        return air_fail_memory(scene->context, "warning");
    scene->warnings = grown;
    char *copy = air_string_copy(scene->context, text);
    if (copy == NULL)
        return air_fail_memory(scene->context, "warning");
    grown[scene->warning_count++] = copy;
    return AIR_OK;
}

/* ---- one pair of functions per kind ---- */

air_status air_scene_add_texture(air_scene *scene, const air_texture_desc *desc,
                                 air_handle *out_handle)
{
    return add_object(scene, AIR_OBJECT_TEXTURE, desc, out_handle);
}

air_status air_scene_add_grid(air_scene *scene, const air_grid_desc *desc, air_handle *out_handle)
{
    return add_object(scene, AIR_OBJECT_GRID, desc, out_handle);
}

air_status air_scene_set_grid(air_scene *scene, air_handle handle, const air_grid_desc *desc)
{
    return set_object(scene, AIR_OBJECT_GRID, handle, desc);
}

static air_status load_grid(air_scene *scene, const air_grid_file *file, air_handle *out_handle)
{
    air_record *record = NULL;
    const air_status status = air_grid_record_load(scene->context, file, scene->frame, &record);
    return status == AIR_OK ? add_record(scene, AIR_OBJECT_GRID, record, out_handle) : status;
}

air_status air_scene_load_grid(air_scene *scene, const char *path, const char *grid_name,
                               air_handle *out_handle)
{
    const air_status status = check_arguments(scene, AIR_OBJECT_GRID, path, out_handle);
    const air_grid_file file = {.path = path, .name = grid_name};
    return status == AIR_OK ? load_grid(scene, &file, out_handle) : status;
}

air_status air_scene_load_raw_grid(air_scene *scene, const char *path, const size_t size[3],
                                   size_t channels, air_handle *out_handle)
{
    air_status status = check_arguments(scene, AIR_OBJECT_GRID, path, out_handle);
    if (status == AIR_OK)
        status = check_arguments(scene, AIR_OBJECT_GRID, size, out_handle);
    if (status != AIR_OK)
        return status;
    const air_grid_file file = {
        .path = path, .raw = true, .size = {size[0], size[1], size[2]}, .channels = channels};
    return load_grid(scene, &file, out_handle);
}

air_status air_scene_add_material(air_scene *scene, const air_material_desc *desc,
                                  air_handle *out_handle)
{
    return add_object(scene, AIR_OBJECT_MATERIAL, desc, out_handle);
}

air_status air_scene_set_material(air_scene *scene, air_handle handle,
                                  const air_material_desc *desc)
{
    return set_object(scene, AIR_OBJECT_MATERIAL, handle, desc);
}

air_status air_scene_add_mesh(air_scene *scene, const air_mesh_desc *desc, air_handle *out_handle)
{
    return add_object(scene, AIR_OBJECT_MESH, desc, out_handle);
}

air_status air_scene_set_mesh(air_scene *scene, air_handle handle, const air_mesh_desc *desc)
{
    return set_object(scene, AIR_OBJECT_MESH, handle, desc);
}

air_status air_scene_add_medium(air_scene *scene, const air_medium_desc *desc,
                                air_handle *out_handle)
{
    return add_object(scene, AIR_OBJECT_MEDIUM, desc, out_handle);
}

air_status air_scene_set_medium(air_scene *scene, air_handle handle, const air_medium_desc *desc)
{
    return set_object(scene, AIR_OBJECT_MEDIUM, handle, desc);
}

air_status air_scene_add_light(air_scene *scene, const air_light_desc *desc, air_handle *out_handle)
{
    return add_object(scene, AIR_OBJECT_LIGHT, desc, out_handle);
}

air_status air_scene_set_light(air_scene *scene, air_handle handle, const air_light_desc *desc)
{
    return set_object(scene, AIR_OBJECT_LIGHT, handle, desc);
}

air_status air_scene_add_camera(air_scene *scene, const air_camera_desc *desc,
                                air_handle *out_handle)
{
    return add_object(scene, AIR_OBJECT_CAMERA, desc, out_handle);
}

air_status air_scene_set_camera(air_scene *scene, air_handle handle, const air_camera_desc *desc)
{
    return set_object(scene, AIR_OBJECT_CAMERA, handle, desc);
}
