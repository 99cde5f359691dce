#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/gltf.h"

static const float identity[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                   0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};

/* A node waiting to be visited, with its parent's map. */
typedef struct air_pending_node {
    size_t node;
    float parent_to_world[12];
} air_pending_node;

typedef struct air_walk {
    air_gltf *gltf;
    uint8_t *seen; /* one per node */
    air_pending_node *stack;
    size_t count, capacity;
} air_walk;

/* `at` is where the node is named. */
static air_status push(air_walk *walk, const air_json *at, size_t node,
                       const float parent_to_world[12])
{
    if (walk->seen[node])
        return air_json_fail(at, AIR_ERROR_FORMAT,
                             "node %zu is already in the hierarchy: a cycle, or two parents", node);
    walk->seen[node] = 1;
    if (walk->count == walk->capacity) {
        const size_t capacity = 2 * walk->capacity + 64;
        air_pending_node *stack =
            air_reallocate(walk->gltf->context, walk->stack, capacity, sizeof *walk->stack);
        if (stack == NULL)
            return air_fail_memory(walk->gltf->context, walk->gltf->path);
        walk->stack = stack;
        walk->capacity = capacity;
    }
    air_pending_node *pending = &walk->stack[walk->count++];
    pending->node = node;
    memcpy(pending->parent_to_world, parent_to_world, sizeof pending->parent_to_world);
    return AIR_OK;
}

/* Pushes a list of nodes so that the first is visited first. */
static air_status push_list(air_walk *walk, const air_json *list, const float parent_to_world[12])
{
    air_status status = air_json_check_array(list, false);
    for (size_t i = air_json_count(list); i > 0 && status == AIR_OK; --i) {
        const air_json at = air_json_at(list, i - 1);
        size_t node = 0;
        status = air_json_index(&at, air_json_count(&walk->gltf->nodes), "a node", &node);
        if (status == AIR_OK)
            status = push(walk, &at, node, parent_to_world);
    }
    return status;
}

/* Translation, rotation (a quaternion x, y, z, w, normalised here) and scale. */
static air_status read_parts(const air_json *node, float out[12])
{
    const air_json translation_at = air_json_get(node, "translation");
    const air_json rotation_at = air_json_get(node, "rotation");
    const air_json scale_at = air_json_get(node, "scale");
    float t[3] = {0.0f, 0.0f, 0.0f}, s[3] = {1.0f, 1.0f, 1.0f};
    float r[9] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f};
    air_status status = air_json_floats(&translation_at, AIR_JSON_ANY, 3, t);
    if (status == AIR_OK && rotation_at.value != NULL)
        status = air_sidecar_read_rotation(&rotation_at, r);
    if (status == AIR_OK)
        status = air_json_floats(&scale_at, AIR_JSON_ANY, 3, s);
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column)
            out[4 * row + column] = r[3 * row + column] * s[column];
        out[4 * row + 3] = t[row];
    }
    return status;
}

static air_status read_local_map(const air_json *node, float out[12])
{
    const air_json matrix_at = air_json_get(node, "matrix");
    if (matrix_at.value == NULL)
        return read_parts(node, out);
    float m[16]; /* column-major */
    const air_status status = air_json_floats(&matrix_at, AIR_JSON_ANY, 16, m);
    if (status != AIR_OK)
        return status;
    if (m[3] != 0.0f || m[7] != 0.0f || m[11] != 0.0f || m[15] != 1.0f)
        return air_json_fail(&matrix_at, AIR_ERROR_FORMAT,
                             "expected 0, 0, 0, 1 as the last row of the matrix");
    for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column)
            out[4 * row + column] = m[4 * column + row];
    return AIR_OK;
}

static const char *name_of(const air_json *at)
{
    const air_json name = air_json_get(at, "name");
    return json_is_string(name.value) ? json_string_value(name.value) : "";
}

/* Reads an index into out, SIZE_MAX if it is absent. */
static air_status read_reference(const air_json *at, const air_json *array, const char *what,
                                 size_t *out)
{
    *out = SIZE_MAX;
    return air_json_index(at, air_json_count(array), what, out);
}

/* What a node carries becomes an object; a node without anything is none. */
static air_status add_object(air_gltf *gltf, size_t node, const air_json *at,
                             const float to_world[12], size_t *out_object)
{
    const air_json mesh_at = air_json_get(at, "mesh");
    const air_json camera_at = air_json_get(at, "camera");
    const air_json extensions = air_json_get(at, "extensions");
    const air_json punctual = air_json_get(&extensions, "KHR_lights_punctual");
    const air_json light_at = air_json_get(&punctual, "light");
    const air_json skin = air_json_get(at, "skin");
    size_t mesh = 0, camera = 0, light = 0;
    air_status status = read_reference(&mesh_at, &gltf->meshes, "a mesh", &mesh);
    if (status == AIR_OK)
        status = read_reference(&camera_at, &gltf->cameras, "a camera", &camera);
    if (status == AIR_OK)
        status = read_reference(&light_at, &gltf->lights, "a light", &light);
    *out_object = SIZE_MAX;
    if (status != AIR_OK || (mesh == SIZE_MAX && camera == SIZE_MAX && light == SIZE_MAX))
        return status;
    gltf->tally.skins += skin.value != NULL;
    air_import_object *object = air_import_add_object(gltf->import);
    if (object == NULL)
        return AIR_ERROR_MEMORY;
    const air_json data = mesh != SIZE_MAX    ? air_json_at(&gltf->meshes, mesh)
                          : light != SIZE_MAX ? air_json_at(&gltf->lights, light)
                                              : air_json_at(&gltf->cameras, camera);
    object->name = name_of(at);
    object->data_name = name_of(&data);
    memcpy(object->to_world, to_world, sizeof object->to_world);
    object->node = node;
    object->mesh = mesh;
    object->camera = camera;
    object->light = light;
    *out_object = gltf->import->object_count - 1;
    return AIR_OK;
}

/* The airlight object in the extras of `at`, if it has one. */
static air_status add_extras(air_gltf *gltf, const air_json *at, const float to_world[12],
                             air_sidecar_place place, size_t object)
{
    const air_json extras = air_json_get(at, "extras");
    const air_json airlight = air_json_get(&extras, "airlight");
    if (airlight.value == NULL)
        return AIR_OK;
    return air_sidecar_add_value(gltf->import, &airlight, to_world, place, object);
}

static air_status visit(air_walk *walk, const air_pending_node *pending)
{
    air_gltf *gltf = walk->gltf;
    const air_json at = air_json_at(&gltf->nodes, pending->node);
    const air_json children = air_json_get(&at, "children");
    float local[12], to_world[12];
    size_t object = SIZE_MAX;
    air_status status = air_json_check_object(&at, true);
    if (status == AIR_OK)
        status = read_local_map(&at, local);
    if (status != AIR_OK)
        return status;
    affine_multiply(pending->parent_to_world, local, to_world);
    for (size_t i = 0; i < 12; ++i)
        if (!isfinite(to_world[i]))
            return air_json_fail(&at, AIR_ERROR_FORMAT, "the node's transformation is not finite");
    status = add_object(gltf, pending->node, &at, to_world, &object);
    if (status == AIR_OK)
        status = add_extras(gltf, &at, to_world, AIR_SIDECAR_NODE, object);
    return status == AIR_OK ? push_list(walk, &children, to_world) : status;
}

/* In a file without scenes: the nodes that are nobody's child. */
static air_status push_parentless(air_walk *walk)
{
    air_gltf *gltf = walk->gltf;
    const size_t node_count = air_json_count(&gltf->nodes);
    uint8_t *is_child = air_allocate(gltf->context, node_count, 1);
    if (is_child == NULL)
        return air_fail_memory(gltf->context, gltf->path);
    for (size_t i = 0; i < node_count; ++i) {
        const json_t *children = json_object_get(json_array_get(gltf->nodes.value, i), "children");
        for (size_t j = 0; j < json_array_size(children); ++j) {
            const json_int_t child = json_integer_value(json_array_get(children, j));
            if (child >= 0 && (size_t)child < node_count)
                is_child[child] = 1;
        }
    }
    air_status status = AIR_OK;
    for (size_t i = node_count; i > 0 && status == AIR_OK; --i) {
        const air_json at = air_json_at(&gltf->nodes, i - 1);
        if (!is_child[i - 1])
            status = push(walk, &at, i - 1, identity);
    }
    air_free(gltf->context, is_child);
    return status;
}

static air_status push_scene(air_walk *walk)
{
    air_gltf *gltf = walk->gltf;
    const size_t scene_count = air_json_count(&gltf->scenes);
    const int32_t asked = gltf->import->params->scene_index;
    const air_json scene_at = air_json_get(&gltf->root, "scene");
    size_t index = 0;
    if (asked >= 0 && (size_t)asked >= scene_count)
        return air_fail(gltf->context, AIR_ERROR_ARGUMENT,
                        "%s: there is no scene %d, the file has %zu", gltf->path, (int)asked,
                        scene_count);
    if (scene_count == 0)
        return push_parentless(walk);
    air_status status = air_json_index(&scene_at, scene_count, "a scene", &index);
    if (asked >= 0)
        index = (size_t)asked;
    const air_json scene = air_json_at(&gltf->scenes, index);
    const air_json roots = air_json_get(&scene, "nodes");
    if (status == AIR_OK)
        status = air_json_check_object(&scene, true);
    if (status == AIR_OK)
        status = add_extras(gltf, &scene, identity, AIR_SIDECAR_WORLD, SIZE_MAX);
    return status == AIR_OK ? push_list(walk, &roots, identity) : status;
}

air_status air_gltf_walk(air_gltf *gltf)
{
    air_walk walk = {.gltf = gltf};
    walk.seen = air_allocate(gltf->context, air_json_count(&gltf->nodes), 1);
    if (walk.seen == NULL)
        return air_fail_memory(gltf->context, gltf->path);
    air_status status = add_extras(gltf, &gltf->root, identity, AIR_SIDECAR_WORLD, SIZE_MAX);
    if (status == AIR_OK)
        status = push_scene(&walk);
    while (walk.count > 0 && status == AIR_OK) {
        const air_pending_node pending = walk.stack[--walk.count];
        status = visit(&walk, &pending);
    }
    air_free(gltf->context, walk.stack);
    air_free(gltf->context, walk.seen);
    return status;
}
