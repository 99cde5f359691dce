/* export_light.c: lights: as KHR_lights_punctual where that knows them, else in the airlight
 * object.
 *
 * The extension is what other programs understand, so that it goes first. It is photometric, by the
 * same efficacy the reader divides by. */
#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/export/export.h"

/* ---- KHR_lights_punctual ---- */

/* Equal or nearly equal cone angles the reader pulls apart. */
static bool has_soft_edge(const air_light_desc *desc)
{
    return desc->inner_cone_rad <= 0.999f * desc->outer_cone_rad;
}

static bool is_punctual(const air_light_desc *desc)
{
    switch (desc->kind) {
    case AIR_LIGHT_POINT:
        return true;
    case AIR_LIGHT_SPOT:
        return desc->falloff == AIR_SPOT_COSINE && has_soft_edge(desc);
    case AIR_LIGHT_COLLIMATED:
        return desc->window_count == 0;
    default:
        return false;
    }
}

/* As the reader multiplies. */
static float light_product(float factor, float strength)
{
    return factor * strength * (1.0f / 683.0f);
}

/* Light leaves along the node's -Z. */
static void put_place(air_export *self, const air_light_desc *desc, json_t *node)
{
    const bool placed = desc->kind != AIR_LIGHT_COLLIMATED;
    float map[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
    if (desc->kind != AIR_LIGHT_POINT) {
        const air_vec3 back = vec3_sub(vec3_set1(0.0f), vec3_unit(vec3_load(desc->dir)));
        const air_frame frame = frame_from_normal(back);
        const air_vec3 columns[3] = {frame.s, frame.t, back};
        for (size_t i = 0; i < 3; ++i) {
            map[i] = columns[i].x;
            map[4 + i] = columns[i].y;
            map[8 + i] = columns[i].z;
        }
    }
    for (size_t i = 0; i < 3 && placed; ++i)
        map[4 * i + 3] = desc->position[i];
    air_export_matrix(self, node, map);
}

static void add_punctual(air_export *self, const air_light_desc *desc)
{
    static const char *const types[] = {"point", "spot", "directional"};
    float factors[3], strength = 0.0f;
    json_t *light = json_object(), *node = json_object();
    air_export_split(desc->color, light_product, factors, &strength);
    air_export_name(self, light, desc->name);
    air_export_put(self, light, "type", json_string(types[desc->kind]));
    air_export_put(self, light, "color", air_export_floats(self, factors, 3));
    air_export_put(self, light, "intensity", json_real((double)strength));
    if (desc->kind == AIR_LIGHT_SPOT) {
        json_t *spot = air_export_object(self, light, "spot");
        air_export_put(self, spot, "innerConeAngle", json_real((double)desc->inner_cone_rad));
        air_export_put(self, spot, "outerConeAngle", json_real((double)desc->outer_cone_rad));
    }
    json_t *lights = air_export_list(
        self, air_export_extension(self, self->root, "KHR_lights_punctual"), "lights");
    const size_t index = json_array_size(lights);
    air_export_push(self, lights, light);
    air_export_name(self, node, desc->name);
    put_place(self, desc, node);
    air_export_put(self, air_export_extension(self, node, "KHR_lights_punctual"), "light",
                   json_integer((json_int_t)index));
    if (!desc->casts_shadow)
        air_export_put(self, air_export_node_object(self, node), "casts_shadow", json_false());
    air_export_node(self, node);
}

/* ---- the airlight object ---- */

static json_t *points(air_export *self, const float *vertices, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; ++i)
        air_export_push(self, array, air_export_floats(self, vertices + 3 * i, 3));
    return array;
}

static void put_spot(air_export *self, const air_light_desc *desc, json_t *light)
{
    const double degrees = 180.0 / AIR_PI;
    air_export_put(self, light, "position", air_export_floats(self, desc->position, 3));
    air_export_put(self, light, "direction", air_export_floats(self, desc->dir, 3));
    air_export_put(self, light, "intensity", air_export_color(self, desc->color));
    air_export_put(self, light, "inner_cone_degrees",
                   json_real((double)desc->inner_cone_rad * degrees));
    air_export_put(self, light, "outer_cone_degrees",
                   json_real((double)desc->outer_cone_rad * degrees));
    if (desc->falloff == AIR_SPOT_ANGLE)
        air_export_put(self, light, "falloff", json_string("angle"));
}

static void put_collimated(air_export *self, const air_light_desc *desc, json_t *light)
{
    json_t *windows = json_array();
    for (size_t i = 0; i < desc->window_count; ++i)
        air_export_push(self, windows,
                        points(self, desc->windows[i].vertices, desc->windows[i].vertex_count));
    air_export_put(self, light, "direction", air_export_floats(self, desc->dir, 3));
    air_export_put(self, light, "irradiance", air_export_color(self, desc->color));
    air_export_put(self, light, "gobo", windows);
}

static void put_polygon(air_export *self, const air_light_desc *desc, json_t *light)
{
    air_export_put(self, light, "vertices", points(self, desc->vertices, desc->vertex_count));
    air_export_put(self, light, "radiance", air_export_color(self, desc->color));
    if (!desc->one_sided)
        air_export_put(self, light, "one_sided", json_false());
}

/* The quaternion of a rotation: the eigenvector that the largest of its four squares names. */
static void quaternion_of(const float m[9], float out[4])
{
    const double trace = (double)m[0] + (double)m[4] + (double)m[8];
    double square[4], q[4];
    size_t k = 3;
    for (size_t i = 0; i < 3; ++i)
        square[i] = 1.0 + 2.0 * (double)m[4 * i] - trace;
    square[3] = 1.0 + trace;
    for (size_t i = 0; i < 3; ++i)
        k = square[i] > square[k] ? i : k;
    const double odd[3] = {(double)m[7] - (double)m[5], (double)m[2] - (double)m[6],
                           (double)m[3] - (double)m[1]};
    for (size_t i = 0; i < 4; ++i) {
        if (i == k)
            q[i] = square[k];
        else if (k == 3)
            q[i] = odd[i];
        else
            q[i] = i == 3 ? odd[k] : (double)m[3 * i + k] + (double)m[3 * k + i];
    }
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (size_t i = 0; i < 4; ++i)
        out[i] = (float)(q[i] / length);
}

static air_status put_image(air_export *self, const air_light_desc *desc, json_t *light)
{
    const char *file = NULL;
    if (desc->image == AIR_NONE)
        return AIR_OK;
    const air_status status = air_export_image(self, desc->image, desc->name, &file);
    if (status == AIR_OK)
        air_export_put(self, light, "image", air_export_string(self, file));
    return status;
}

static air_status put_environment(air_export *self, const air_light_desc *desc, json_t *light)
{
    static const float unturned[9] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f};
    float quaternion[4];
    air_export_put(self, light, "radiance", air_export_color(self, desc->color));
    if (memcmp(desc->to_world, unturned, sizeof unturned) != 0) {
        quaternion_of(desc->to_world, quaternion);
        air_export_put(self, light, "rotation", air_export_floats(self, quaternion, 4));
    }
    return put_image(self, desc, light);
}

/* The picture's axes are the columns: right, up, and back along the light. */
static air_status put_projector(air_export *self, const air_light_desc *desc, json_t *light)
{
    const float *m = desc->to_world;
    const float dir[3] = {-m[2], -m[5], -m[8]}, up[3] = {m[1], m[4], m[7]};
    air_export_put(self, light, "position", air_export_floats(self, desc->position, 3));
    air_export_put(self, light, "direction", air_export_floats(self, dir, 3));
    air_export_put(self, light, "up", air_export_floats(self, up, 3));
    air_export_put(self, light, "fov_x_degrees",
                   json_real((double)desc->fov_x_rad * 180.0 / AIR_PI));
    air_export_put(self, light, "intensity", air_export_color(self, desc->color));
    return put_image(self, desc, light);
}

static air_status put_kind(air_export *self, const air_light_desc *desc, json_t *light)
{
    switch (desc->kind) {
    case AIR_LIGHT_SPOT:
        put_spot(self, desc, light);
        return AIR_OK;
    case AIR_LIGHT_COLLIMATED:
        put_collimated(self, desc, light);
        return AIR_OK;
    case AIR_LIGHT_POLYGON:
        put_polygon(self, desc, light);
        return AIR_OK;
    case AIR_LIGHT_ENVIRONMENT:
        return put_environment(self, desc, light);
    case AIR_LIGHT_PROJECTOR:
        return put_projector(self, desc, light);
    case AIR_LIGHT_POINT:
        break;
    }
    return air_fail(self->context, AIR_ERROR_INTERNAL, "%s: light \"%s\" is glTF's", self->path,
                    desc->name);
}

static air_status add_other(air_export *self, const air_light_desc *desc)
{
    json_t *light = json_object();
    air_export_push(self, air_export_list(self, self->airlight, "lights"), light);
    air_export_put(self, light, "type", json_string(air_light_kind_names[desc->kind]));
    air_export_name(self, light, desc->name);
    if (!desc->casts_shadow)
        air_export_put(self, light, "casts_shadow", json_false());
    if (!desc->camera_visible &&
        (desc->kind == AIR_LIGHT_POLYGON || desc->kind == AIR_LIGHT_ENVIRONMENT))
        air_export_put(self, light, "camera_visible", json_false());
    return put_kind(self, desc, light);
}

air_status air_export_lights(air_export *self)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_LIGHT];
    air_status status = AIR_OK;
    for (size_t i = 0; i < list->count && status == AIR_OK; ++i) {
        const air_light_desc *desc = &((const air_light_record *)list->slots[i].record)->desc;
        if (is_punctual(desc))
            add_punctual(self, desc);
        else
            status = add_other(self, desc);
    }
    return status;
}
