#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/gltf.h"

/* Squares of coordinates have to stay finite floats. */
static const float farthest = 1e18f;

/* A triangle primitive in the space of its node. */
typedef struct air_primitive {
    float *positions, *normals, *tangents, *uv[2], *colors;
    size_t vertex_count;
    uint32_t *indices;
    size_t triangle_count;
} air_primitive;

static void primitive_finish(air_context *context, air_primitive *primitive)
{
    air_free(context, primitive->positions);
    air_free(context, primitive->normals);
    air_free(context, primitive->tangents);
    air_free(context, primitive->uv[0]);
    air_free(context, primitive->uv[1]);
    air_free(context, primitive->colors);
    air_free(context, primitive->indices);
}

/* An attribute, which must have as many elements as there are vertices. */
static air_status read_attribute(air_gltf *gltf, const air_json *attributes, const char *key,
                                 size_t width, size_t narrow, size_t vertex_count, float **out)
{
    const air_json at = air_json_get(attributes, key);
    size_t count = 0;
    const air_status status = air_gltf_read_floats(gltf, &at, width, narrow, out, &count);
    if (status == AIR_OK && *out != NULL && count != vertex_count)
        return air_json_fail(&at, AIR_ERROR_FORMAT,
                             "expected an accessor of %zu elements like POSITION, found %zu",
                             vertex_count, count);
    return status;
}

static air_status read_attributes(air_gltf *gltf, const air_json *attributes, bool positions_only,
                                  air_primitive *out)
{
    const air_json position = air_json_get(attributes, "POSITION");
    air_status status = air_json_check_object(attributes, true);
    if (status == AIR_OK)
        status = air_json_require(&position, "the index of an accessor");
    if (status == AIR_OK)
        status = air_gltf_read_floats(gltf, &position, 3, 0, &out->positions, &out->vertex_count);
    if (status != AIR_OK || positions_only)
        return status;
    const size_t count = out->vertex_count;
    status = read_attribute(gltf, attributes, "NORMAL", 3, 0, count, &out->normals);
    if (status == AIR_OK)
        status = read_attribute(gltf, attributes, "TANGENT", 4, 0, count, &out->tangents);
    if (status == AIR_OK)
        status = read_attribute(gltf, attributes, "TEXCOORD_0", 2, 0, count, &out->uv[0]);
    if (status == AIR_OK)
        status = read_attribute(gltf, attributes, "TEXCOORD_1", 2, 0, count, &out->uv[1]);
    if (status == AIR_OK)
        status = read_attribute(gltf, attributes, "COLOR_0", 4, 3, count, &out->colors);
    return status;
}

/* [glTF2, section 3.7.2.1] */
enum { AIR_MODE_TRIANGLES = 4, AIR_MODE_STRIP = 5, AIR_MODE_FAN = 6 };

/* Corners a, b, c of triangle t in the order of the primitive's vertices. */
static void corners(size_t mode, size_t t, size_t out[3])
{
    switch (mode) {
    case AIR_MODE_STRIP:
        out[0] = t;
        out[1] = t + 1 + t % 2;
        out[2] = t + 2 - t % 2;
        break;
    case AIR_MODE_FAN:
        out[0] = t + 1;
        out[1] = t + 2;
        out[2] = 0;
        break;
    default:
        out[0] = 3 * t;
        out[1] = 3 * t + 1;
        out[2] = 3 * t + 2;
        break;
    }
}

static air_status read_triangles(air_gltf *gltf, const air_json *primitive, size_t mode,
                                 air_primitive *out)
{
    const air_json at = air_json_get(primitive, "indices");
    uint32_t *list = NULL;
    size_t count = out->vertex_count;
    if (at.value != NULL) {
        const air_status status =
            air_gltf_read_indices(gltf, &at, out->vertex_count, &list, &count);
        if (status != AIR_OK)
            return status;
    }
    size_t triangle_count = count < 3 ? 0 : count - 2;
    if (mode == AIR_MODE_TRIANGLES) {
        triangle_count = count / 3;
        gltf->tally.partial_triangles += count % 3 != 0;
    }
    out->indices = air_allocate(gltf->context, triangle_count, 3 * sizeof *out->indices);
    if (out->indices == NULL) {
        air_free(gltf->context, list);
        return air_fail_memory(gltf->context, gltf->path);
    }
    for (size_t t = 0; t < triangle_count; ++t) {
        size_t corner[3];
        corners(mode, t, corner);
        for (size_t c = 0; c < 3; ++c)
            out->indices[3 * t + c] = list != NULL ? list[corner[c]] : (uint32_t)corner[c];
    }
    out->triangle_count = triangle_count;
    air_free(gltf->context, list);
    return AIR_OK;
}

/* Reads a primitive; one of points or lines gives no triangles. The caller finishes *out, also
 * after a failure. */
static air_status read_primitive(air_gltf *gltf, const air_json *at, bool positions_only,
                                 air_primitive *out)
{
    const air_json mode_at = air_json_get(at, "mode");
    const air_json attributes = air_json_get(at, "attributes");
    size_t mode = AIR_MODE_TRIANGLES;
    air_status status = air_json_check_object(at, true);
    if (status == AIR_OK)
        status = air_json_index(&mode_at, 7, "a primitive mode", &mode);
    if (status == AIR_OK && mode < AIR_MODE_TRIANGLES) {
        gltf->tally.lines_and_points += !positions_only;
        return AIR_OK;
    }
    if (status == AIR_OK)
        status = read_attributes(gltf, &attributes, positions_only, out);
    if (status == AIR_OK && out->vertex_count > UINT32_MAX)
        status = air_json_fail(&attributes, AIR_ERROR_UNSUPPORTED, "more than 2^32 vertices");
    return status == AIR_OK ? read_triangles(gltf, at, mode, out) : status;
}

static air_vec3 world_vertex(const air_primitive *primitive, const float to_world[12],
                             size_t vertex)
{
    return affine_point(to_world, vec3_load(primitive->positions + 3 * vertex));
}

static air_status check_reach(const air_json *at, const air_primitive *primitive,
                              const float to_world[12])
{
    for (size_t i = 0; i < primitive->vertex_count; ++i) {
        const air_vec3 p = world_vertex(primitive, to_world, i);
        if (!(fabsf(p.x) <= farthest && fabsf(p.y) <= farthest && fabsf(p.z) <= farthest))
            return air_json_fail(at, AIR_ERROR_FORMAT,
                                 "vertex %zu lies at (%g, %g, %g), farther out than %g m", i,
                                 (double)p.x, (double)p.y, (double)p.z, (double)farthest);
    }
    return AIR_OK;
}

/* The square of twice the area, of the vertices as they are rounded in world space. */
static double area_measure(air_vec3 a, air_vec3 b, air_vec3 c)
{
    const double u[3] = {(double)b.x - (double)a.x, (double)b.y - (double)a.y,
                         (double)b.z - (double)a.z};
    const double v[3] = {(double)c.x - (double)a.x, (double)c.y - (double)a.y,
                         (double)c.z - (double)a.z};
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    return n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
}

/* Takes out triangles without area; returns how many. */
static size_t drop_degenerate(air_primitive *primitive, const float to_world[12])
{
    size_t kept = 0;
    for (size_t t = 0; t < primitive->triangle_count; ++t) {
        const uint32_t *index = primitive->indices + 3 * t;
        if (!(area_measure(world_vertex(primitive, to_world, index[0]),
                           world_vertex(primitive, to_world, index[1]),
                           world_vertex(primitive, to_world, index[2])) > 0.0))
            continue;
        memmove(primitive->indices + 3 * kept, index, 3 * sizeof *index);
        ++kept;
    }
    const size_t dropped = primitive->triangle_count - kept;
    primitive->triangle_count = kept;
    return dropped;
}

/* Normals of length zero become those of the triangles around them; returns how many there were. */
static size_t mend_normals(air_primitive *primitive)
{
    size_t count = 0;
    for (size_t i = 0; i < primitive->vertex_count; ++i)
        count += !(vec3_length(vec3_load(primitive->normals + 3 * i)) > 1e-12f);
    for (size_t t = 0; count > 0 && t < primitive->triangle_count; ++t) {
        const uint32_t *index = primitive->indices + 3 * t;
        const air_vec3 a = vec3_load(primitive->positions + 3 * (size_t)index[0]);
        const air_vec3 b = vec3_load(primitive->positions + 3 * (size_t)index[1]);
        const air_vec3 c = vec3_load(primitive->positions + 3 * (size_t)index[2]);
        const air_vec3 n = vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
        const float length = vec3_length(n);
        for (size_t corner = 0; corner < 3 && length > 0.0f && isfinite(length); ++corner) {
            float *normal = primitive->normals + 3 * (size_t)index[corner];
            if (!(vec3_length(vec3_load(normal)) > 1e-12f))
                vec3_store(normal, vec3_scale(n, 1.0f / length));
        }
    }
    for (size_t i = 0; count > 0 && i < primitive->vertex_count; ++i) {
        float *normal = primitive->normals + 3 * i;
        if (!(vec3_length(vec3_load(normal)) > 1e-12f))
            vec3_store(normal, vec3(0.0f, 1.0f, 0.0f));
    }
    return count;
}

/* Adds a primitive's triangles in world space. */
static air_status append_primitive(air_context *context, const air_primitive *primitive,
                                   const float to_world[12], air_import_geometry *geometry)
{
    const size_t vertices = geometry->vertex_count, triangles = geometry->triangle_count;
    const air_status status = air_import_geometry_grow(context, primitive->vertex_count,
                                                       primitive->triangle_count, geometry);
    if (status != AIR_OK)
        return status;
    for (size_t i = 0; i < primitive->vertex_count; ++i)
        vec3_store(geometry->positions + 3 * (vertices + i), world_vertex(primitive, to_world, i));
    for (size_t i = 0; i < 3 * primitive->triangle_count; ++i)
        geometry->indices[3 * triangles + i] = (uint32_t)vertices + primitive->indices[i];
    return AIR_OK;
}

/* What a primitive of some material encloses. */
static air_status add_volume(air_gltf *gltf, const air_import_object *object, size_t material,
                             const air_primitive *primitive)
{
    air_import_geometry geometry = {0};
    if (!gltf->volume_store[material].absorbs)
        return AIR_OK;
    air_status status = append_primitive(gltf->context, primitive, object->to_world, &geometry);
    const air_boundary boundary = {.kind = AIR_BOUNDARY_MESH,
                                   .positions = geometry.positions,
                                   .vertex_count = geometry.vertex_count,
                                   .indices = geometry.indices,
                                   .triangle_count = geometry.triangle_count};
    if (status == AIR_OK)
        status = air_gltf_add_volume(gltf, air_gltf_name(object), &gltf->volume_store[material],
                                     &boundary);
    air_import_geometry_finish(gltf->context, &geometry);
    return status;
}

static air_status add_primitive(air_gltf *gltf, const air_import_object *object, size_t index,
                                const air_json *at)
{
    const air_json material_at = air_json_get(at, "material");
    const air_json targets = air_json_get(at, "targets");
    air_primitive primitive = {0};
    size_t material = 0;
    air_handle mesh_handle = AIR_NONE;
    air_mesh_desc desc;
    air_mesh_desc_default(&desc);
    air_status status = read_primitive(gltf, at, false, &primitive);
    if (status == AIR_OK)
        status =
            air_json_index(&material_at, air_json_count(&gltf->materials), "a material", &material);
    if (status == AIR_OK)
        status = check_reach(at, &primitive, object->to_world);
    if (status != AIR_OK)
        goto done;
    gltf->tally.morphs += targets.value != NULL;
    gltf->tally.degenerate_triangles += drop_degenerate(&primitive, object->to_world);
    if (primitive.triangle_count == 0)
        goto done;
    if (primitive.normals != NULL)
        gltf->tally.zero_normals += mend_normals(&primitive);
    if (material_at.value != NULL)
        status = air_gltf_material(gltf, material, &desc.material);
    if (status != AIR_OK)
        goto done;
    desc.name = air_gltf_name(object);
    desc.positions = primitive.positions;
    desc.normals = primitive.normals;
    desc.tangents =
        primitive.normals != NULL ? primitive.tangents : NULL; /* [glTF2, section 3.7.2.1] */
    desc.uv[0] = primitive.uv[0];
    desc.uv[1] = primitive.uv[1];
    desc.colors = primitive.colors;
    desc.vertex_count = primitive.vertex_count;
    desc.indices = primitive.indices;
    desc.triangle_count = primitive.triangle_count;
    memcpy(desc.to_world, object->to_world, sizeof desc.to_world);
    desc.camera_visible = object->camera_visible;
    desc.casts_shadow = object->casts_shadow;
    desc.node = (int32_t)object->node;
    desc.primitive = (int32_t)index;
    status = air_scene_add_mesh(gltf->import->scene, &desc, &mesh_handle);
    if (status == AIR_OK && material_at.value != NULL)
        status = add_volume(gltf, object, material, &primitive);
    if (status != AIR_OK)
        status = air_json_place_error(at, status);
done:
    primitive_finish(gltf->context, &primitive);
    return status;
}

/* The shape that the node's airlight object names, with the material of the first primitive. */
static air_status add_shape(air_gltf *gltf, const air_import_object *object, const air_json *at)
{
    const air_json material_at = air_json_get(at, "material");
    size_t material = 0;
    air_handle handle = AIR_NONE;
    air_mesh_desc desc;
    air_mesh_desc_default(&desc);
    air_status status =
        air_json_index(&material_at, air_json_count(&gltf->materials), "a material", &material);
    if (status == AIR_OK && material_at.value != NULL)
        status = air_gltf_material(gltf, material, &desc.material);
    if (status != AIR_OK)
        return status;
    desc.name = air_gltf_name(object);
    desc.shape = object->shape;
    desc.flip_normals = object->flip_normals;
    memcpy(desc.to_world, object->to_world, sizeof desc.to_world);
    desc.camera_visible = object->camera_visible;
    desc.casts_shadow = object->casts_shadow;
    desc.node = (int32_t)object->node;
    desc.primitive = 0;
    status = air_scene_add_mesh(gltf->import->scene, &desc, &handle);
    if (status == AIR_OK && material_at.value != NULL && gltf->volume_store[material].absorbs) {
        /* of the shapes, spheres alone enclose anything */
        air_boundary boundary = {.kind = object->shape == AIR_SHAPE_SPHERE
                                             ? AIR_BOUNDARY_ELLIPSOID
                                             : AIR_BOUNDARY_UNBOUNDED};
        memcpy(boundary.box_to_world, object->to_world, sizeof object->to_world);
        status = air_gltf_add_volume(gltf, desc.name, &gltf->volume_store[material], &boundary);
    }
    return status == AIR_OK ? AIR_OK : air_json_place_error(at, status);
}

air_status air_gltf_add_mesh(air_gltf *gltf, const air_import_object *object)
{
    const air_json mesh = air_json_at(&gltf->meshes, object->mesh);
    const air_json primitives = air_json_get(&mesh, "primitives");
    float inverse[12];
    air_status status = air_json_check_object(&mesh, true);
    if (status == AIR_OK)
        status = air_json_check_array(&primitives, true);
    if (status == AIR_OK && !affine_invert(object->to_world, inverse)) {
        gltf->tally.flattened_nodes++;
        return AIR_OK;
    }
    if (status == AIR_OK && object->shape != AIR_SHAPE_TRIANGLES) {
        const air_json first = air_json_at(&primitives, 0);
        return add_shape(gltf, object, &first);
    }
    for (size_t i = 0; i < air_json_count(&primitives) && status == AIR_OK; ++i) {
        const air_json at = air_json_at(&primitives, i);
        status = add_primitive(gltf, object, i, &at);
    }
    return status;
}

air_status air_gltf_append_geometry(void *user, const air_import_object *object,
                                    air_import_geometry *geometry)
{
    air_gltf *gltf = user;
    const air_json mesh = air_json_at(&gltf->meshes, object->mesh);
    const air_json primitives = air_json_get(&mesh, "primitives");
    air_status status = air_json_check_array(&primitives, true);
    for (size_t i = 0; i < air_json_count(&primitives) && status == AIR_OK; ++i) {
        const air_json at = air_json_at(&primitives, i);
        air_primitive primitive = {0};
        status = read_primitive(gltf, &at, true, &primitive);
        if (status == AIR_OK)
            status = check_reach(&at, &primitive, object->to_world);
        if (status == AIR_OK && primitive.triangle_count > 0)
            status = append_primitive(gltf->context, &primitive, object->to_world, geometry);
        primitive_finish(gltf->context, &primitive);
    }
    return status;
}
