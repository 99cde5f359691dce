/* export_mesh.c: meshes as nodes: arrays of their own space and a matrix, so that what is read is
 * placed as it was. */
#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/export/export.h"

/* ---- primitives ---- */

static air_status put_attribute(air_export *self, json_t *attributes, const char *key,
                                const float *values, size_t count, size_t components)
{
    size_t accessor = 0;
    if (values == NULL)
        return AIR_OK;
    const air_export_array array = {.data = values,
                                    .count = count,
                                    .components = components,
                                    .bounds = strcmp(key, "POSITION") == 0};
    const air_status status = air_export_accessor(self, &array, &accessor);
    if (status == AIR_OK)
        air_export_put(self, attributes, key, json_integer((json_int_t)accessor));
    return status;
}

/* Sets of coordinates are counted from 0: a second one without a first is both. */
static air_status put_attributes(air_export *self, const air_export_primitive *primitive,
                                 json_t *attributes)
{
    const size_t count = primitive->vertex_count;
    const float *first = primitive->uv[0] != NULL ? primitive->uv[0] : primitive->uv[1];
    const float *tangents = primitive->normals != NULL ? primitive->tangents : NULL;
    air_status status = put_attribute(self, attributes, "POSITION", primitive->positions, count, 3);
    if (status == AIR_OK)
        status = put_attribute(self, attributes, "NORMAL", primitive->normals, count, 3);
    if (status == AIR_OK)
        status = put_attribute(self, attributes, "TANGENT", tangents, count, 4);
    if (status == AIR_OK)
        status = put_attribute(self, attributes, "TEXCOORD_0", first, count, 2);
    if (status == AIR_OK)
        status = put_attribute(self, attributes, "TEXCOORD_1", primitive->uv[1], count, 2);
    if (status == AIR_OK)
        status = put_attribute(self, attributes, "COLOR_0", primitive->colors, count, 4);
    return status;
}

/* material SIZE_MAX: none. */
static air_status add_primitive(air_export *self, const air_export_primitive *primitive,
                                size_t material, json_t *primitives)
{
    const air_export_array indices = {.data = primitive->indices,
                                      .count = 3 * primitive->triangle_count,
                                      .components = 1,
                                      .indices = true};
    size_t accessor = 0;
    json_t *entry = json_object();
    air_status status =
        put_attributes(self, primitive, air_export_object(self, entry, "attributes"));
    if (status == AIR_OK)
        status = air_export_accessor(self, &indices, &accessor);
    air_export_put(self, entry, "indices", json_integer((json_int_t)accessor));
    if (material != SIZE_MAX)
        air_export_put(self, entry, "material", json_integer((json_int_t)material));
    air_export_push(self, primitives, entry);
    return status;
}

/* ---- meshes of the scene ---- */

/* glTF's nodes move, turn and scale, but do not shear: are the columns perpendicular? */
static bool has_shear(const float map[12])
{
    for (size_t i = 0; i < 3; ++i) {
        const size_t j = (i + 1) % 3;
        double product = 0.0, square_i = 0.0, square_j = 0.0;
        for (size_t row = 0; row < 3; ++row) {
            const double a = (double)map[4 * row + i], b = (double)map[4 * row + j];
            product += a * b;
            square_i += a * a;
            square_j += b * b;
        }
        if (fabs(product) > 1e-5 * sqrt(square_i * square_j))
            return true;
    }
    return false;
}

static air_status add_mesh_primitive(air_export *self, air_mesh_record *record, bool in_world,
                                     json_t *primitives)
{
    const air_slot_list *materials = &self->scene->lists[AIR_OBJECT_MATERIAL];
    air_export_primitive primitive;
    air_status status = air_export_primitive_make(self, record, in_world, &primitive);
    if (status == AIR_OK)
        status =
            add_primitive(self, &primitive, air_slot_find(materials, record->material), primitives);
    air_export_primitive_finish(self, &primitive);
    return status;
}

/* Were both primitives of one node of the file they came from? */
static bool is_same_node(const air_mesh_record *a, const air_mesh_record *b)
{
    return a->node >= 0 && a->node == b->node && a->primitive < b->primitive &&
           strcmp(a->base.name, b->base.name) == 0 && air_mesh_place_equal(a, b) &&
           a->camera_visible == b->camera_visible && a->casts_shadow == b->casts_shadow &&
           a->geometry->shape == AIR_SHAPE_TRIANGLES && b->geometry->shape == AIR_SHAPE_TRIANGLES;
}

/* Other programs see triangles; the reader takes the shape instead, if the node's matrix places it.
 */
static void put_shape(air_export *self, const air_mesh_record *record, bool in_world, json_t *node)
{
    const air_shape shape = record->geometry->shape;
    if (shape == AIR_SHAPE_TRIANGLES)
        return;
    if (in_world) {
        air_warn(self->context, "%s: %s \"%s\" is sheared and became triangles, %d to a turn",
                 self->path, air_shape_names[shape], record->base.name, AIR_EXPORT_TURN);
        return;
    }
    json_t *object = air_export_node_object(self, node);
    air_export_put(self, object, "shape", json_string(air_shape_names[shape]));
    if (record->flip_normals)
        air_export_put(self, object, "flip_normals", json_true());
}

static void put_flags(air_export *self, const air_mesh_record *record, json_t *node)
{
    if (!record->camera_visible)
        air_export_put(self, air_export_node_object(self, node), "camera_visible", json_false());
    if (!record->casts_shadow)
        air_export_put(self, air_export_node_object(self, node), "casts_shadow", json_false());
}

/* A node with a mesh of the list's records [first, end). */
static air_status add_node(air_export *self, size_t first, size_t end)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_MESH];
    const air_mesh_record *record = (const air_mesh_record *)list->slots[first].record;
    const bool in_world = has_shear(record->to_world);
    json_t *node = json_object(), *mesh = json_object();
    json_t *primitives = air_export_list(self, mesh, "primitives");
    air_status status = AIR_OK;
    for (size_t i = first; i < end && status == AIR_OK; ++i)
        status = add_mesh_primitive(self, (air_mesh_record *)list->slots[i].record, in_world,
                                    primitives);
    air_export_name(self, node, record->base.name);
    if (!in_world)
        air_export_matrix(self, node, record->to_world);
    put_flags(self, record, node);
    put_shape(self, record, in_world, node);
    air_export_put(self, node, "mesh",
                   json_integer((json_int_t)air_export_append(self, "meshes", mesh)));
    air_export_node(self, node);
    return status;
}

air_status air_export_meshes(air_export *self)
{
    const air_slot_list *list = &self->scene->lists[AIR_OBJECT_MESH];
    air_status status = AIR_OK;
    for (size_t first = 0, end; first < list->count && status == AIR_OK; first = end) {
        for (end = first + 1; end < list->count; ++end)
            if (!is_same_node((const air_mesh_record *)list->slots[end - 1].record,
                              (const air_mesh_record *)list->slots[end].record))
                break;
        status = add_node(self, first, end);
    }
    return status;
}

/* ---- boundaries of media ---- */

static bool is_node_name(const air_export *self, const char *name)
{
    const json_t *nodes = json_object_get(self->root, "nodes");
    for (size_t i = 0; i < json_array_size(nodes); ++i) {
        const char *known = json_string_value(json_object_get(json_array_get(nodes, i), "name"));
        if (known != NULL && strcmp(known, name) == 0)
            return true;
    }
    return false;
}

/* "NAME boundary", with a number where that is taken. */
static json_t *boundary_name(air_export *self, const char *medium)
{
    json_t *name = NULL;
    for (size_t number = 1; name == NULL; ++number) {
        char *text = number == 1
                         ? air_string_format(self->context, "%s boundary", medium)
                         : air_string_format(self->context, "%s boundary %zu", medium, number);
        name = text != NULL ? air_export_string(self, text) : NULL;
        air_free(self->context, text);
        if (name == NULL)
            return NULL;
        if (is_node_name(self, json_string_value(name))) {
            json_decref(name);
            name = NULL;
        }
    }
    return name;
}

/* The reader does not render boundaries; this keeps other programs from showing them as walls. */
static size_t add_unseen_material(air_export *self)
{
    static const float clear[4] = {1.0f, 1.0f, 1.0f, 0.0f};
    json_t *material = json_object();
    air_export_put(self, material, "name", json_string("boundary"));
    air_export_put(self, material, "alphaMode", json_string("BLEND"));
    air_export_put(self, air_export_object(self, material, "pbrMetallicRoughness"),
                   "baseColorFactor", air_export_floats(self, clear, 4));
    return air_export_append(self, "materials", material);
}

air_status air_export_boundary(air_export *self, const air_medium_desc *medium,
                               const char **out_name)
{
    const air_boundary *boundary = &medium->boundary;
    const air_export_primitive primitive = {.positions = boundary->positions,
                                            .vertex_count = boundary->vertex_count,
                                            .indices = boundary->indices,
                                            .triangle_count = boundary->triangle_count};
    json_t *name = boundary_name(self, medium->name);
    json_t *node = json_object(), *mesh = json_object();
    const air_status status = add_primitive(self, &primitive, add_unseen_material(self),
                                            air_export_list(self, mesh, "primitives"));
    *out_name = json_string_value(name);
    air_export_put(self, node, "name", name);
    air_export_put(self, node, "mesh",
                   json_integer((json_int_t)air_export_append(self, "meshes", mesh)));
    air_export_node(self, node);
    return status;
}
