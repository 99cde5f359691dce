#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/import.h"
#include "scene/import/resource.h"
#include "scene/light_record.h"
#include "scene/lights/light_build.h"

/* What a light's description points to while it is being made. */
typedef struct air_light_arrays {
    float *vertices; /* of the polygon, or of all windows one after the other */
    air_gobo_window *windows;
} air_light_arrays;

static air_status read_point(const air_sidecar_part *part, const char *key, float out[3])
{
    const air_json at = air_json_get(part->at, key);
    float local[3] = {0.0f, 0.0f, 0.0f};
    air_status status = air_json_require(&at, "a point");
    if (status == AIR_OK)
        status = air_json_floats(&at, AIR_JSON_ANY, 3, local);
    if (status == AIR_OK)
        vec3_store(out, affine_point(part->to_world, vec3_load(local)));
    return status;
}

static air_status read_world_direction(const air_sidecar_part *part, float out[3])
{
    const air_json at = air_json_get(part->at, "direction");
    float local[3] = {0.0f, 0.0f, 0.0f};
    const air_status status = air_sidecar_read_direction(&at, local);
    if (status != AIR_OK)
        return status;
    const air_vec3 dir = affine_vector(part->to_world, vec3_load(local));
    if (!(vec3_length(dir) > 0.0f))
        return air_json_fail(&at, AIR_ERROR_FORMAT, "the node is scaled to nothing along it");
    vec3_store(out, vec3_unit(dir));
    return AIR_OK;
}

/* The light's quantity, which it must have. */
static air_status read_quantity(const air_json *light, const char *key, air_light_desc *desc)
{
    const air_json at = air_json_get(light, key);
    const air_status status = air_json_require(&at, "a number >= 0, or an array of three");
    return status == AIR_OK ? air_json_color(&at, AIR_JSON_NON_NEGATIVE, desc->color) : status;
}

/* A polygon's vertices in world space; out has room for all of them. */
static air_status read_vertices(const air_sidecar_part *part, const air_json *at, float *out)
{
    for (size_t i = 0; i < air_json_count(at); ++i) {
        const air_json vertex_at = air_json_at(at, i);
        float vertex[3];
        const air_status status = air_json_floats(&vertex_at, AIR_JSON_ANY, 3, vertex);
        if (status != AIR_OK)
            return status;
        vec3_store(out + 3 * i, affine_point(part->to_world, vec3_load(vertex)));
    }
    return AIR_OK;
}

static air_status check_polygon(const air_json *at)
{
    if (air_json_count(at) >= 3)
        return AIR_OK;
    return air_json_expected(at, "an array of at least 3 points");
}

/* Swaps the order of vertices: a mirroring node would turn the polygon's front to its back. */
static void reverse_vertices(float *vertices, size_t count)
{
    for (size_t i = 0; i < count / 2; ++i) {
        const air_vec3 front = vec3_load(vertices + 3 * i);
        vec3_store(vertices + 3 * i, vec3_load(vertices + 3 * (count - 1 - i)));
        vec3_store(vertices + 3 * (count - 1 - i), front);
    }
}

static air_status read_polygon(const air_sidecar_part *part, air_light_desc *desc,
                               air_light_arrays *arrays)
{
    const air_json at = air_json_get(part->at, "vertices");
    const air_json one_sided = air_json_get(part->at, "one_sided");
    const size_t count = air_json_count(&at);
    air_status status = check_polygon(&at);
    if (status == AIR_OK)
        status = read_quantity(part->at, "radiance", desc);
    if (status == AIR_OK)
        status = air_json_bool(&one_sided, &desc->one_sided);
    if (status != AIR_OK)
        return status;
    arrays->vertices = air_allocate(part->import->context, count, 3 * sizeof(float));
    if (arrays->vertices == NULL)
        return air_fail_memory(part->import->context, "light");
    status = read_vertices(part, &at, arrays->vertices);
    if (affine_determinant(part->to_world) < 0.0)
        reverse_vertices(arrays->vertices, count);
    desc->vertices = arrays->vertices;
    desc->vertex_count = count;
    return status;
}

static air_status read_windows(const air_sidecar_part *part, const air_json *at,
                               air_light_desc *desc, air_light_arrays *arrays)
{
    const size_t count = air_json_count(at);
    size_t total = 0, first = 0;
    air_status status = air_json_check_array(at, true);
    for (size_t i = 0; i < count && status == AIR_OK; ++i) {
        const air_json window = air_json_at(at, i);
        status = check_polygon(&window);
        total += air_json_count(&window);
    }
    if (status == AIR_OK && count == 0)
        status = air_json_expected(at, "at least one polygon");
    if (status != AIR_OK)
        return status;
    arrays->vertices = air_allocate(part->import->context, total, 3 * sizeof(float));
    arrays->windows = air_allocate(part->import->context, count, sizeof *arrays->windows);
    if (arrays->vertices == NULL || arrays->windows == NULL)
        return air_fail_memory(part->import->context, "light");
    for (size_t i = 0; i < count && status == AIR_OK; ++i) {
        const air_json window = air_json_at(at, i);
        float *vertices = arrays->vertices + 3 * first;
        status = read_vertices(part, &window, vertices);
        arrays->windows[i] =
            (air_gobo_window){.vertices = vertices, .vertex_count = air_json_count(&window)};
        first += air_json_count(&window);
    }
    desc->windows = arrays->windows;
    desc->window_count = count;
    return status;
}

static air_status read_collimated(const air_sidecar_part *part, air_light_desc *desc,
                                  air_light_arrays *arrays)
{
    const air_json gobo = air_json_get(part->at, "gobo");
    air_status status = read_world_direction(part, desc->dir);
    if (status == AIR_OK)
        status = read_quantity(part->at, "irradiance", desc);
    if (status == AIR_OK && gobo.value != NULL)
        status = read_windows(part, &gobo, desc, arrays);
    return status;
}

static air_status read_spot(const air_sidecar_part *part, air_light_desc *desc)
{
    const air_json inner_at = air_json_get(part->at, "inner_cone_degrees");
    const air_json outer_at = air_json_get(part->at, "outer_cone_degrees");
    const air_json falloff_at = air_json_get(part->at, "falloff");
    static const char *const shapes[] = {"cosine", "angle"};
    size_t shape = 0;
    double inner = 0.0, outer = 45.0;
    air_status status = read_point(part, "position", desc->position);
    if (status == AIR_OK)
        status = read_world_direction(part, desc->dir);
    if (status == AIR_OK)
        status = read_quantity(part->at, "intensity", desc);
    if (status == AIR_OK)
        status = air_json_number(&outer_at, AIR_JSON_POSITIVE, &outer);
    if (status == AIR_OK && outer > 90.0)
        status = air_json_expected(&outer_at, "an angle of at most 90 degrees");
    if (status == AIR_OK)
        status = air_json_number(&inner_at, AIR_JSON_NON_NEGATIVE, &inner);
    if (status == AIR_OK && inner >= outer)
        status = air_json_expected(&inner_at, "an angle below the outer one (%g degrees)", outer);
    if (status == AIR_OK && falloff_at.value != NULL)
        status = air_json_choice(&falloff_at, shapes, sizeof shapes / sizeof shapes[0], &shape);
    desc->falloff = (air_spot_shape)shape;
    desc->inner_cone_rad = (float)(inner * AIR_PI / 180.0);
    desc->outer_cone_rad = (float)(outer * AIR_PI / 180.0);
    return status;
}

/* The rotation of a node whose scale is of no matter for what lies at infinity. */
static void rotation_of(const float to_world[12], float out[9])
{
    for (size_t column = 0; column < 3; ++column) {
        const air_vec3 axis = vec3(to_world[column], to_world[4 + column], to_world[8 + column]);
        const float length = vec3_length(axis);
        out[column] = axis.x / length;
        out[3 + column] = axis.y / length;
        out[6 + column] = axis.z / length;
    }
}

static air_status read_environment_rotation(const air_sidecar_part *part, float out[9])
{
    const air_json at = air_json_get(part->at, "rotation");
    const air_json about_y_at = air_json_get(part->at, "rotation_y_degrees");
    float own[9] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f}, node[9], inverse[12];
    double degrees = 0.0;
    air_status status = air_json_number(&about_y_at, AIR_JSON_ANY, &degrees);
    if (status == AIR_OK && at.value != NULL && about_y_at.value != NULL)
        status = air_json_fail(&about_y_at, AIR_ERROR_FORMAT,
                               "expected either rotation or rotation_y_degrees");
    if (status == AIR_OK && at.value != NULL)
        status = air_sidecar_read_rotation(&at, own);
    if (status == AIR_OK && !affine_invert(part->to_world, inverse))
        status = air_json_fail(part->at, AIR_ERROR_FORMAT, "the node is scaled to nothing");
    if (status != AIR_OK)
        return status;
    if (about_y_at.value != NULL) {
        const float c = (float)cos(degrees * AIR_PI / 180.0),
                    s = (float)sin(degrees * AIR_PI / 180.0);
        memcpy(own, (const float[9]){c, 0.0f, s, 0.0f, 1.0f, 0.0f, -s, 0.0f, c}, sizeof own);
    }
    rotation_of(part->to_world, node);
    for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 3; ++column)
            out[3 * row + column] = node[3 * row] * own[column] +
                                    node[3 * row + 1] * own[3 + column] +
                                    node[3 * row + 2] * own[6 + column];
    return AIR_OK;
}

/* The image, if there is one, and a factor on it, which may then be missing. */
static air_status read_image(const air_sidecar_part *part, const char *quantity,
                             air_light_desc *desc)
{
    const air_json image_at = air_json_get(part->at, "image");
    const air_json factor_at = air_json_get(part->at, quantity);
    const char *image = NULL;
    air_context *context = part->import->context;
    air_status status = air_json_string(&image_at, &image);
    if (status == AIR_OK && (image == NULL || factor_at.value != NULL))
        status = read_quantity(part->at, quantity, desc);
    else
        desc->color[0] = desc->color[1] = desc->color[2] = 1.0f;
    if (status != AIR_OK || image == NULL)
        return status;
    char *path = air_path_join(context, part->at->document->folder, image);
    status = path == NULL ? AIR_ERROR_MEMORY
                          : air_import_environment_texture(part->import, path, &desc->image);
    air_free(context, path);
    return status;
}

static air_status read_environment(const air_sidecar_part *part, air_light_desc *desc)
{
    const air_status status = read_environment_rotation(part, desc->to_world);
    return status == AIR_OK ? read_image(part, "radiance", desc) : status;
}

/* Along `direction`, with `up` upwards in the picture. */
static air_status read_projector_frame(const air_sidecar_part *part, air_light_desc *desc)
{
    const air_json up_at = air_json_get(part->at, "up");
    float local_up[3] = {0.0f, 1.0f, 0.0f}, dir[3];
    air_status status = read_world_direction(part, dir);
    if (status == AIR_OK && up_at.value != NULL)
        status = air_sidecar_read_direction(&up_at, local_up);
    if (status != AIR_OK)
        return status;
    const air_vec3 back = vec3_neg(vec3_load(dir));
    air_vec3 right = vec3_cross(affine_vector(part->to_world, vec3_load(local_up)), back);
    if (!(vec3_length(right) > 1e-4f) && up_at.value == NULL)
        right = vec3_cross(vec3(0.0f, 0.0f, -1.0f), back); /* straight down: north is -Z */
    if (!(vec3_length(right) > 1e-4f))
        return air_json_expected(&up_at, "a direction that is not that of the light");
    right = vec3_normalize(right);
    const air_vec3 columns[3] = {right, vec3_cross(back, right), back};
    for (size_t i = 0; i < 3; ++i) {
        desc->to_world[i] = columns[i].x;
        desc->to_world[3 + i] = columns[i].y;
        desc->to_world[6 + i] = columns[i].z;
    }
    return AIR_OK;
}

static air_status read_projector(const air_sidecar_part *part, air_light_desc *desc)
{
    const air_json fov_at = air_json_get(part->at, "fov_x_degrees");
    double fov = 45.0;
    air_status status = read_point(part, "position", desc->position);
    if (status == AIR_OK)
        status = read_projector_frame(part, desc);
    if (status == AIR_OK)
        status = air_json_number(&fov_at, AIR_JSON_POSITIVE, &fov);
    if (status == AIR_OK && fov >= 179.9)
        status = air_json_expected(&fov_at, "an angle below 179.9 degrees");
    desc->fov_x_rad = (float)(fov * AIR_PI / 180.0);
    return status == AIR_OK ? read_image(part, "intensity", desc) : status;
}

static air_status check_light_keys(const air_json *at, air_light_kind kind)
{
    static const char *const point[] = {"type", "name", "position", "intensity", "casts_shadow"};
    static const char *const spot[] = {
        "type",      "name",         "position",           "direction",
        "intensity", "casts_shadow", "inner_cone_degrees", "outer_cone_degrees",
        "falloff"};
    static const char *const collimated[] = {"type",       "name", "direction",
                                             "irradiance", "gobo", "casts_shadow"};
    static const char *const polygon[] = {"type",      "name",           "vertices",    "radiance",
                                          "one_sided", "camera_visible", "casts_shadow"};
    static const char *const environment[] = {"type",           "name",        "image",
                                              "radiance",       "rotation",    "rotation_y_degrees",
                                              "camera_visible", "casts_shadow"};
    static const char *const projector[] = {"type",      "name",      "position",
                                            "direction", "up",        "fov_x_degrees",
                                            "image",     "intensity", "casts_shadow"};
    switch (kind) {
    case AIR_LIGHT_POINT:
        return air_json_check_keys(at, point, sizeof point / sizeof point[0]);
    case AIR_LIGHT_SPOT:
        return air_json_check_keys(at, spot, sizeof spot / sizeof spot[0]);
    case AIR_LIGHT_COLLIMATED:
        return air_json_check_keys(at, collimated, sizeof collimated / sizeof collimated[0]);
    case AIR_LIGHT_POLYGON:
        return air_json_check_keys(at, polygon, sizeof polygon / sizeof polygon[0]);
    case AIR_LIGHT_PROJECTOR:
        return air_json_check_keys(at, projector, sizeof projector / sizeof projector[0]);
    case AIR_LIGHT_ENVIRONMENT:
        break;
    }
    return air_json_check_keys(at, environment, sizeof environment / sizeof environment[0]);
}

static air_status read_kind(const air_sidecar_part *part, air_light_desc *desc,
                            air_light_arrays *arrays)
{
    air_status status = AIR_OK;
    switch (desc->kind) {
    case AIR_LIGHT_POINT:
        status = read_point(part, "position", desc->position);
        return status == AIR_OK ? read_quantity(part->at, "intensity", desc) : status;
    case AIR_LIGHT_SPOT:
        return read_spot(part, desc);
    case AIR_LIGHT_COLLIMATED:
        return read_collimated(part, desc, arrays);
    case AIR_LIGHT_POLYGON:
        return read_polygon(part, desc, arrays);
    case AIR_LIGHT_PROJECTOR:
        return read_projector(part, desc);
    case AIR_LIGHT_ENVIRONMENT:
        break;
    }
    return read_environment(part, desc);
}

/* The scene's own check, with a name that also says where the light was described. */
static air_status check_with_place(const air_sidecar_part *part, const air_light_desc *desc)
{
    air_light_desc annotated = *desc;
    char *name = air_json_annotate(part->at, desc->name);
    if (name == NULL)
        return AIR_ERROR_MEMORY;
    annotated.name = name;
    const air_status status = air_light_check(part->import->context, &annotated);
    air_free(part->import->context, name);
    return status;
}

air_status air_sidecar_add_light(const air_sidecar_part *part)
{
    const air_json type_at = air_json_get(part->at, "type");
    const air_json name_at = air_json_get(part->at, "name");
    const air_json visible_at = air_json_get(part->at, "camera_visible");
    const air_json shadow_at = air_json_get(part->at, "casts_shadow");
    air_light_arrays arrays = {0};
    air_light_desc desc;
    air_light_desc_default(&desc);
    desc.name = part->fallback_name;
    size_t kind = AIR_LIGHT_POINT;
    air_handle handle = AIR_NONE;
    air_status status = air_json_check_object(part->at, true);
    if (status == AIR_OK)
        status = air_json_require(&type_at, "a light type");
    if (status == AIR_OK)
        status = air_json_choice(&type_at, air_light_kind_names, AIR_LIGHT_KINDS, &kind);
    desc.kind = (air_light_kind)kind;
    if (status == AIR_OK)
        status = check_light_keys(part->at, desc.kind);
    if (status == AIR_OK)
        status = air_json_string(&name_at, &desc.name);
    if (status == AIR_OK)
        status = air_json_bool(&visible_at, &desc.camera_visible);
    if (status == AIR_OK)
        status = air_json_bool(&shadow_at, &desc.casts_shadow);
    if (status == AIR_OK)
        status = read_kind(part, &desc, &arrays);
    if (status == AIR_OK)
        status = check_with_place(part, &desc);
    if (status == AIR_OK)
        status = air_scene_add_light(part->import->scene, &desc, &handle);
    air_free(part->import->context, arrays.windows);
    air_free(part->import->context, arrays.vertices);
    return status;
}
