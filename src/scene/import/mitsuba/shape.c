#include <math.h>
#include <string.h>

#include "core/vec.h"
#include "scene/import/mitsuba/mitsuba.h"

static const float identity[12] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                   0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};

static const char *const types[] = {"obj",  "ply",      "serialized", "rectangle", "cube", "sphere",
                                    "disk", "cylinder", "shapegroup", "instance",  "merge"};
enum { TYPES = sizeof types / sizeof *types };
/* In the order of air_mesh_format. */
enum { MESH_FILES = 3 };

static size_t type_of(const air_xml *at)
{
    size_t i = 0;
    while (i < TYPES && !air_mitsuba_is(at, types[i]))
        ++i;
    return i;
}

/* ---- collecting ---- */

static air_status collect_one(air_mitsuba *mitsuba, air_xml *at, const air_xml *named,
                              const float instance_to_world[12])
{
    if (type_of(at) == TYPES) {
        at->used = true;
        return air_mitsuba_unknown_type(mitsuba, at, types, TYPES, "it is left out");
    }
    air_import_object *object = air_mitsuba_add_item(mitsuba, at, named, instance_to_world);
    if (object == NULL)
        return AIR_ERROR_MEMORY;
    object->mesh = mitsuba->item_count - 1;
    return AIR_OK;
}

/* The shapes within a group, which has no groups within. */
static air_status collect_parts(air_mitsuba *mitsuba, air_xml *group, const air_xml *instance,
                                const float instance_to_world[12])
{
    air_xml *from = group->child, *child = NULL, *part = NULL;
    air_status status = AIR_OK;
    group->asked = true;
    while (from != NULL && status == AIR_OK) {
        status = air_mitsuba_next(mitsuba, &from, "shape", &child, &part);
        if (status != AIR_OK || part == NULL)
            break;
        if (air_mitsuba_is(part, "shapegroup") || air_mitsuba_is(part, "instance") ||
            air_mitsuba_is(part, "merge"))
            return air_mitsuba_fail(mitsuba, child, AIR_ERROR_UNSUPPORTED,
                                    "within a group no %s is supported", air_mitsuba_type(part));
        status = collect_one(mitsuba, part, instance != NULL ? instance : part, instance_to_world);
    }
    return status;
}

static air_status collect_instance(air_mitsuba *mitsuba, air_xml *at)
{
    float to_world[12];
    air_xml *group = NULL;
    memcpy(to_world, identity, sizeof identity);
    at->used = at->asked = true;
    air_status status = air_mitsuba_transform(mitsuba, at, "to_world", to_world);
    if (status == AIR_OK)
        status = air_mitsuba_child(mitsuba, at, "shape", NULL, &group);
    if (status == AIR_OK && (group == NULL || !air_mitsuba_is(group, "shapegroup")))
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected a <ref> to a <shape type=\"shapegroup\">");
    return status == AIR_OK ? collect_parts(mitsuba, group, at, to_world) : status;
}

air_status air_mitsuba_collect_shape(air_mitsuba *mitsuba, air_xml *at)
{
    if (air_mitsuba_is(at, "shapegroup"))
        return AIR_OK; /* shown where instances are */
    if (air_mitsuba_is(at, "instance"))
        return collect_instance(mitsuba, at);
    if (air_mitsuba_is(at, "merge")) {
        at->used = true;
        return collect_parts(mitsuba, at, NULL, identity);
    }
    return collect_one(mitsuba, at, at, identity);
}

/* ---- quadrics ---- */

static void translate_scale(const float center[3], const float scale[3], float out[12])
{
    memcpy(out, identity, sizeof identity);
    for (size_t i = 0; i < 3; ++i) {
        out[5 * i] = scale[i];
        out[4 * i + 3] = center[i];
    }
}

static air_status read_radius(const air_mitsuba *mitsuba, const air_xml *at, float *radius)
{
    const air_status status = air_mitsuba_float(mitsuba, at, "radius", radius);
    if (status == AIR_OK && !(*radius > 0.0f))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                "expected a radius above 0, found %g", (double)*radius);
    return status;
}

static air_status read_sphere(const air_mitsuba *mitsuba, const air_xml *at, float local[12])
{
    float center[3] = {0.0f, 0.0f, 0.0f}, radius = 1.0f;
    air_status status = air_mitsuba_vector(mitsuba, at, "center", center);
    if (status == AIR_OK)
        status = read_radius(mitsuba, at, &radius);
    const float scale[3] = {radius, radius, radius};
    translate_scale(center, scale, local);
    return status;
}

/* The unit cylinder about Z onto the one from p0 to p1. */
static air_status read_cylinder(const air_mitsuba *mitsuba, const air_xml *at, float local[12])
{
    float p0[3] = {0.0f, 0.0f, 0.0f}, p1[3] = {0.0f, 0.0f, 1.0f}, radius = 1.0f;
    air_status status = air_mitsuba_vector(mitsuba, at, "p0", p0);
    if (status == AIR_OK)
        status = air_mitsuba_vector(mitsuba, at, "p1", p1);
    if (status == AIR_OK)
        status = read_radius(mitsuba, at, &radius);
    if (status != AIR_OK)
        return status;
    const air_vec3 axis = vec3_sub(vec3_load(p1), vec3_load(p0));
    const float length = vec3_length(axis);
    if (!(length > 0.0f))
        return air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT, "expected p1 not to be p0");
    const air_frame frame = frame_from_normal(vec3_scale(axis, 1.0f / length));
    const air_vec3 columns[4] = {vec3_scale(frame.s, radius), vec3_scale(frame.t, radius), axis,
                                 vec3_load(p0)};
    for (size_t i = 0; i < 4; ++i) {
        local[i] = columns[i].x;
        local[4 + i] = columns[i].y;
        local[8 + i] = columns[i].z;
    }
    return AIR_OK;
}

/* ---- meshes ---- */

static void turn_over(uint32_t corners[3])
{
    const uint32_t second = corners[1];
    corners[1] = corners[2];
    corners[2] = second;
}

/* Turns triangles and their normals over. */
static void flip_mesh(air_mesh_file *mesh)
{
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        turn_over(mesh->indices + 3 * t);
    for (size_t i = 0; mesh->normals != NULL && i < 3 * mesh->vertex_count; ++i)
        mesh->normals[i] = -mesh->normals[i];
}

/* The front of a surface is where its normals point; ours is where triangles run
 * counter-clockwise. */
static void orient_triangles(air_mesh_file *mesh)
{
    for (size_t t = 0; mesh->normals != NULL && t < mesh->triangle_count; ++t) {
        uint32_t *corners = mesh->indices + 3 * t;
        air_vec3 p[3], normal = vec3_set1(0.0f);
        for (size_t i = 0; i < 3; ++i) {
            p[i] = vec3_load(mesh->positions + 3 * (size_t)corners[i]);
            normal = vec3_add(normal, vec3_load(mesh->normals + 3 * (size_t)corners[i]));
        }
        if (vec3_dot(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])), normal) < 0.0f)
            turn_over(corners);
    }
}

void air_mitsuba_bytes_finish(air_context *context, air_mitsuba_bytes *bytes)
{
    air_free(context, bytes->path);
    air_free(context, bytes->data);
    *bytes = (air_mitsuba_bytes){0};
}

/* One of the shapes of a .serialized, which is read once for those that follow each other. */
static air_status read_serialized(air_mitsuba *mitsuba, const char *path, size_t index,
                                  air_mesh_file *mesh)
{
    air_mitsuba_bytes *bytes = &mitsuba->shapes;
    if (bytes->path == NULL || strcmp(bytes->path, path) != 0) {
        air_mitsuba_bytes_finish(mitsuba->context, bytes);
        const air_status status = air_file_read(mitsuba->context, path, &bytes->data, &bytes->size);
        if (status != AIR_OK)
            return status;
        bytes->path = air_string_copy(mitsuba->context, path);
        if (bytes->path == NULL)
            return air_fail_memory(mitsuba->context, path);
    }
    return air_mesh_file_decode(mitsuba->context, path, AIR_MESH_SERIALIZED, index, bytes->data,
                                bytes->size, mesh);
}

static air_status read_mesh_file(air_mitsuba *mitsuba, const air_xml *at, air_mesh_format format,
                                 air_mesh_file *mesh)
{
    static const char *const ignored[] = {"collapse", "shape_name", "srgb"};
    const char *name = NULL;
    char *path = NULL;
    bool face_normals = false, flip_v = format == AIR_MESH_OBJ;
    long index = 0;
    air_mitsuba_ignore(at, ignored, sizeof ignored / sizeof *ignored);
    air_status status = air_mitsuba_filename(mitsuba, at, &name);
    if (status == AIR_OK)
        status = air_mitsuba_boolean(mitsuba, at, "face_normals", &face_normals);
    if (status == AIR_OK)
        status = air_mitsuba_boolean(mitsuba, at, "flip_tex_coords", &flip_v);
    if (status == AIR_OK)
        status = air_mitsuba_integer(mitsuba, at, "shape_index", &index);
    if (status == AIR_OK && index < 0)
        status = air_mitsuba_fail(mitsuba, at, AIR_ERROR_FORMAT,
                                  "expected a shape_index that is not below 0");
    if (status == AIR_OK)
        status = air_mitsuba_file(mitsuba, at, name, &path);
    if (status == AIR_OK)
        status = air_xml_place_error(
            &mitsuba->document, at,
            format == AIR_MESH_SERIALIZED
                ? read_serialized(mitsuba, path, (size_t)index, mesh)
                : air_mesh_file_read(mitsuba->context, path, format, (size_t)index, mesh));
    air_free(mitsuba->context, path);
    if (status != AIR_OK)
        return status;
    for (size_t i = 0; flip_v && mesh->uv != NULL && i < mesh->vertex_count; ++i)
        mesh->uv[2 * i + 1] = 1.0f - mesh->uv[2 * i + 1];
    if (face_normals) {
        air_free(mitsuba->context, mesh->normals);
        mesh->normals = NULL;
        return AIR_OK;
    }
    return mesh->normals == NULL ? air_mesh_file_smooth(mitsuba->context, mesh) : AIR_OK;
}

void air_mitsuba_geometry_finish(air_context *context, air_mitsuba_geometry *geometry)
{
    air_mesh_file_finish(context, &geometry->mesh);
}

static air_status read_type(air_mitsuba *mitsuba, const air_xml *at, float local[12],
                            air_mitsuba_geometry *out)
{
    const size_t type = type_of(at);
    if (type < MESH_FILES)
        return read_mesh_file(mitsuba, at, (air_mesh_format)type, &out->mesh);
    if (air_mitsuba_is(at, "sphere")) {
        out->shape = AIR_SHAPE_SPHERE;
        return read_sphere(mitsuba, at, local);
    }
    if (air_mitsuba_is(at, "cylinder")) {
        out->shape = AIR_SHAPE_CYLINDER;
        return read_cylinder(mitsuba, at, local);
    }
    if (air_mitsuba_is(at, "disk")) {
        out->shape = AIR_SHAPE_DISK;
        return AIR_OK;
    }
    return air_mitsuba_solid(mitsuba->context, at, out);
}

air_status air_mitsuba_read_geometry(air_mitsuba *mitsuba, const air_mitsuba_item *item,
                                     air_mitsuba_geometry *out)
{
    float local[12];
    *out = (air_mitsuba_geometry){.shape = AIR_SHAPE_TRIANGLES};
    memcpy(out->to_world, identity, sizeof identity);
    memcpy(local, identity, sizeof identity);
    air_status status = air_mitsuba_transform(mitsuba, item->at, "to_world", out->to_world);
    if (status == AIR_OK)
        status = air_mitsuba_boolean(mitsuba, item->at, "flip_normals", &out->flip_normals);
    if (status == AIR_OK)
        status = read_type(mitsuba, item->at, local, out);
    if (status != AIR_OK)
        return status;
    affine_multiply(out->to_world, local, out->to_world);
    affine_multiply(item->instance_to_world, out->to_world, out->to_world);
    if (out->shape == AIR_SHAPE_TRIANGLES && out->flip_normals) {
        flip_mesh(&out->mesh);
        out->flip_normals = false;
    }
    return AIR_OK;
}

/* ---- adding ---- */

/* casts_shadow: beside what the object says. */
static air_status add_mesh(const air_mitsuba *mitsuba, const air_import_object *object,
                           const air_mitsuba_geometry *geometry, air_handle material,
                           bool casts_shadow)
{
    const air_xml *at = mitsuba->items[object->mesh].at;
    air_mesh_desc desc;
    air_handle handle = AIR_NONE;
    air_mesh_desc_default(&desc);
    desc.name = object->name[0] != '\0' ? object->name : air_mitsuba_type(at);
    desc.shape = geometry->shape;
    desc.flip_normals = geometry->flip_normals;
    desc.positions = geometry->mesh.positions;
    desc.normals = geometry->mesh.normals;
    desc.uv[0] = geometry->mesh.uv;
    desc.vertex_count = geometry->mesh.vertex_count;
    desc.indices = geometry->mesh.indices;
    desc.triangle_count = geometry->mesh.triangle_count;
    desc.material = material;
    desc.camera_visible = object->camera_visible;
    desc.casts_shadow = object->casts_shadow && casts_shadow;
    memcpy(desc.to_world, geometry->to_world, sizeof desc.to_world);
    const air_status status = air_scene_add_mesh(mitsuba->import->scene, &desc, &handle);
    return status == AIR_OK ? status : air_xml_place_error(&mitsuba->document, at, status);
}

static air_status check_shape(const air_mitsuba *mitsuba, air_xml *at)
{
    static const char *const ignored[] = {"silhouette_sampling_weight"};
    air_xml *subsurface = NULL;
    at->asked = true;
    air_mitsuba_ignore(at, ignored, 1);
    air_status status = air_mitsuba_child(mitsuba, at, "subsurface", NULL, &subsurface);
    if (status == AIR_OK && subsurface != NULL)
        status = air_mitsuba_replace(mitsuba, subsurface, "subsurface scattering is not supported",
                                     "the surface is shown without");
    return status;
}

/* Is the emitter of a shape a light of its own? */
static air_status find_collimated(const air_mitsuba *mitsuba, const air_xml *at, air_xml **out)
{
    static const char *const known[] = {"area", "directionalarea"};
    air_status status = air_mitsuba_child(mitsuba, at, "emitter", NULL, out);
    if (status != AIR_OK || *out == NULL)
        return status;
    if (air_mitsuba_is(*out, "directionalarea"))
        return AIR_OK;
    if (!air_mitsuba_is(*out, "area"))
        status = air_mitsuba_unknown_type(mitsuba, *out, known, 2, "the shape does not shine");
    *out = NULL;
    return status;
}

air_status air_mitsuba_add_shape(air_mitsuba *mitsuba, const air_import_object *object)
{
    const air_mitsuba_item *item = &mitsuba->items[object->mesh];
    air_mitsuba_geometry geometry = {0};
    air_handle material = AIR_NONE;
    air_xml *collimated = NULL;
    bool clear = false;
    float inverse[12];
    air_status status = check_shape(mitsuba, item->at);
    if (status == AIR_OK)
        status = air_mitsuba_read_geometry(mitsuba, item, &geometry);
    if (status == AIR_OK && !affine_invert(geometry.to_world, inverse))
        status = air_mitsuba_fail(mitsuba, item->at, AIR_ERROR_FORMAT,
                                  "to_world scales the shape to nothing");
    if (status == AIR_OK)
        status = air_mitsuba_material(mitsuba, item->at, &material, &clear);
    mitsuba->items[object->mesh].opaque = !clear;
    if (status == AIR_OK)
        status = find_collimated(mitsuba, item->at, &collimated);
    if (status == AIR_OK)
        status = air_mitsuba_note_region(mitsuba, item, &geometry, clear);
    if (status == AIR_OK)
        orient_triangles(&geometry.mesh);
    if (status == AIR_OK && material != AIR_NONE &&
        (geometry.shape != AIR_SHAPE_TRIANGLES || geometry.mesh.triangle_count > 0))
        status = add_mesh(mitsuba, object, &geometry, material, collimated == NULL);
    if (status == AIR_OK && collimated != NULL)
        status = air_mitsuba_add_collimated(mitsuba, collimated, item->at, &geometry, object->name);
    air_mitsuba_geometry_finish(mitsuba->context, &geometry);
    return status;
}

/* ---- boundaries ---- */

air_status air_mitsuba_append_triangles(air_context *context, const air_mitsuba_geometry *shape,
                                        air_import_geometry *geometry)
{
    const air_mesh_file *mesh = &shape->mesh;
    const size_t vertices = geometry->vertex_count, triangles = geometry->triangle_count;
    const air_status status =
        air_import_geometry_grow(context, mesh->vertex_count, mesh->triangle_count, geometry);
    if (status != AIR_OK)
        return status;
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        vec3_store(geometry->positions + 3 * (vertices + i),
                   affine_point(shape->to_world, vec3_load(mesh->positions + 3 * i)));
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        geometry->indices[3 * triangles + i] = (uint32_t)vertices + mesh->indices[i];
    return AIR_OK;
}

air_status air_mitsuba_append_geometry(void *user, const air_import_object *object,
                                       air_import_geometry *geometry)
{
    air_mitsuba *mitsuba = user;
    const air_mitsuba_item *item = &mitsuba->items[object->mesh];
    air_mitsuba_geometry shape = {0};
    air_status status = air_mitsuba_read_geometry(mitsuba, item, &shape);
    if (status == AIR_OK && shape.shape != AIR_SHAPE_TRIANGLES)
        status = air_mitsuba_fail(mitsuba, item->at, AIR_ERROR_UNSUPPORTED,
                                  "a %s has no triangles to bound a medium of a sidecar",
                                  air_mitsuba_type(item->at));
    if (status == AIR_OK)
        status = air_mitsuba_append_triangles(mitsuba->context, &shape, geometry);
    air_mitsuba_geometry_finish(mitsuba->context, &shape);
    return status;
}
