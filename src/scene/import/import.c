#include "scene/import/import.h"

#include <stdio.h>
#include <string.h>

void air_import_geometry_finish(air_context *context, air_import_geometry *geometry)
{
    air_free(context, geometry->positions);
    air_free(context, geometry->indices);
    *geometry = (air_import_geometry){0};
}

air_status air_import_geometry_grow(air_context *context, size_t vertex_count,
                                    size_t triangle_count, air_import_geometry *geometry)
{
    const size_t vertices = geometry->vertex_count + vertex_count;
    const size_t triangles = geometry->triangle_count + triangle_count;
    if (vertices > UINT32_MAX)
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "medium boundary: %zu vertices, but it can have %u", vertices, UINT32_MAX);
    float *positions =
        air_reallocate(context, geometry->positions, vertices, 3 * sizeof *positions);
    if (positions == NULL)
        return air_fail_memory(context, "medium boundary");
    geometry->positions = positions;
    uint32_t *indices = air_reallocate(context, geometry->indices, triangles, 3 * sizeof *indices);
    if (indices == NULL)
        return air_fail_memory(context, "medium boundary");
    geometry->indices = indices;
    geometry->vertex_count = vertices;
    geometry->triangle_count = triangles;
    return AIR_OK;
}

void air_import_finish(air_import *import)
{
    for (size_t i = 0; i < import->sidecar_count; ++i) {
        air_free(import->context, import->sidecars[i].file);
        air_free(import->context, import->sidecars[i].prefix);
        air_free(import->context, import->sidecars[i].folder);
        json_decref(import->sidecars[i].json);
    }
    air_free(import->context, import->sidecars);
    air_free(import->context, import->objects);
}

air_import_object *air_import_add_object(air_import *import)
{
    if (import->object_count == import->object_capacity) {
        const size_t capacity = 2 * import->object_capacity + 64;
        air_import_object *objects =
            air_reallocate(import->context, import->objects, capacity, sizeof *objects);
        if (objects == NULL) {
            (void)air_fail_memory(import->context, "scene");
            return NULL;
        }
        import->objects = objects;
        import->object_capacity = capacity;
    }
    air_import_object *object = &import->objects[import->object_count++];
    *object = (air_import_object){.name = "",
                                  .data_name = "",
                                  .mesh = SIZE_MAX,
                                  .light = SIZE_MAX,
                                  .camera = SIZE_MAX,
                                  .camera_visible = true,
                                  .casts_shadow = true};
    air_camera_desc_default(&object->camera_rest);
    return object;
}

air_status air_import_warn(air_import *import, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return air_scene_add_warning(import->scene, text);
}

/* The next object from `start` on whose own name, or that of its data, is this one. */
static size_t find_by(const air_import *import, const char *name, bool by_data, size_t start)
{
    for (size_t i = start; i < import->object_count; ++i) {
        const air_import_object *object = &import->objects[i];
        if (strcmp(name, by_data ? object->data_name : object->name) == 0)
            return i;
    }
    return SIZE_MAX;
}

size_t air_import_find(const air_import *import, const char *name, size_t start)
{
    if (name[0] == '\0')
        return SIZE_MAX;
    return find_by(import, name, find_by(import, name, false, 0) == SIZE_MAX, start);
}

air_status air_import_unknown_name(const air_import *import, const air_json *at, const char *name)
{
    const char **names = air_allocate(import->context, import->object_count, sizeof *names);
    if (names == NULL)
        return air_fail_memory(import->context, "scene");
    for (size_t i = 0; i < import->object_count; ++i)
        names[i] = import->objects[i].name;
    const char *nearest = air_nearest_name(name, names, import->object_count);
    air_free(import->context, names);
    if (nearest != NULL && nearest[0] != '\0')
        return air_json_fail(at, AIR_ERROR_FORMAT,
                             "the scene has no object \"%.80s\"; did you mean \"%s\"?", name,
                             nearest);
    return air_json_fail(at, AIR_ERROR_FORMAT, "the scene has no object \"%.80s\"", name);
}
