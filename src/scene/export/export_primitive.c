/* export_primitive.c: the arrays of a mesh as glTF has them: quadrics as triangles, fronts by the
 * order of corners. */
#include <string.h>

#include "core/vec.h"
#include "scene/export/export.h"

/* A fresh array that the primitive owns, NULL when memory is out. */
static void *own(air_export *self, air_export_primitive *primitive, size_t count, size_t size)
{
    void *array = air_allocate(self->context, count, size);
    if (array == NULL)
        (void)air_fail_memory(self->context, self->path);
    else
        primitive->owned[primitive->owned_count++] = array;
    return array;
}

void air_export_primitive_finish(air_export *self, air_export_primitive *primitive)
{
    for (size_t i = 0; i < primitive->owned_count; ++i)
        air_free(self->context, primitive->owned[i]);
    primitive->owned_count = 0;
}

/* ---- quadrics ---- */

/* How many cells along u and v. */
static void lattice_of(air_shape shape, size_t out[2])
{
    const size_t round = AIR_EXPORT_TURN;
    out[0] = shape == AIR_SHAPE_DISK ? 1 : round;
    out[1] = shape == AIR_SHAPE_SPHERE ? round / 2 : shape == AIR_SHAPE_DISK ? round : 1;
}

/* Corners of the lattice of texture coordinates. */
static void place_corners(const air_quadric *quadric, const size_t cells[2], bool in_world,
                          float *positions, float *normals, float *uv)
{
    for (size_t i = 0; i < (cells[0] + 1) * (cells[1] + 1); ++i) {
        const float u = (float)(i % (cells[0] + 1)) / (float)cells[0];
        const float v = (float)(i / (cells[0] + 1)) / (float)cells[1];
        double local[3], normal[3];
        air_quadric_place(quadric->shape, u, v, local);
        air_quadric_local_normal(quadric->shape, local, normal);
        air_vec3 position = vec3((float)local[0], (float)local[1], (float)local[2]);
        air_vec3 out = vec3((float)normal[0], (float)normal[1], (float)normal[2]);
        if (in_world) {
            position = air_quadric_to_world(quadric, local);
            out = air_quadric_normal(quadric, local);
        }
        vec3_store(positions + 3 * i, position);
        vec3_store(normals + 3 * i, out);
        uv[2 * i] = u;
        uv[2 * i + 1] = v;
    }
}

/* Adds a triangle with its front where the normals point to; those without area, at poles, are left
 * out. */
static void add_triangle(const float *positions, const float *normals, const uint32_t corners[3],
                         air_export_primitive *primitive, uint32_t *indices)
{
    const air_vec3 a = vec3_load(positions + 3 * (size_t)corners[0]);
    const air_vec3 b = vec3_load(positions + 3 * (size_t)corners[1]);
    const air_vec3 c = vec3_load(positions + 3 * (size_t)corners[2]);
    const air_vec3 across = vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
    air_vec3 normal = vec3_set1(0.0f);
    for (size_t i = 0; i < 3; ++i)
        normal = vec3_add(normal, vec3_load(normals + 3 * (size_t)corners[i]));
    const float side = vec3_dot(across, normal);
    /* corners that a pole has in common are apart by rounding alone */
    if (!(vec3_length(across) >
          1e-5f * vec3_length(vec3_sub(b, a)) * vec3_length(vec3_sub(c, a))) ||
        side == 0.0f)
        return;
    uint32_t *out = indices + 3 * primitive->triangle_count++;
    out[0] = corners[0];
    out[1] = corners[side > 0.0f ? 1 : 2];
    out[2] = corners[side > 0.0f ? 2 : 1];
}

static air_status tessellate(air_export *self, const air_mesh_record *record, bool in_world,
                             air_export_primitive *out)
{
    air_quadric quadric;
    size_t cells[2];
    lattice_of(record->geometry->shape, cells);
    const size_t count = (cells[0] + 1) * (cells[1] + 1);
    float *positions = own(self, out, count, 3 * sizeof *positions);
    float *normals = own(self, out, count, 3 * sizeof *normals);
    float *uv = own(self, out, count, 2 * sizeof *uv);
    uint32_t *indices = own(self, out, cells[0] * cells[1], 6 * sizeof *indices);
    if (positions == NULL || normals == NULL || uv == NULL || indices == NULL)
        return AIR_ERROR_MEMORY;
    if (!air_quadric_make((air_ray_shape)record->geometry->shape, record->to_world, &quadric))
        return air_fail(self->context, AIR_ERROR_INTERNAL, "%s: mesh \"%s\" became singular",
                        self->path, record->base.name);
    place_corners(&quadric, cells, in_world, positions, normals, uv);
    for (size_t i = 0; i < cells[0] * cells[1]; ++i) {
        const uint32_t row = (uint32_t)(cells[0] + 1);
        const uint32_t first = (uint32_t)(i / cells[0]) * row + (uint32_t)(i % cells[0]);
        const uint32_t lower[3] = {first, first + 1, first + row + 1};
        const uint32_t upper[3] = {first, first + row + 1, first + row};
        add_triangle(positions, normals, lower, out, indices);
        add_triangle(positions, normals, upper, out, indices);
    }
    out->positions = positions;
    out->normals = normals;
    out->uv[0] = uv;
    out->indices = indices;
    out->vertex_count = count;
    return AIR_OK;
}

/* ---- triangles ---- */

static air_status take_arrays(air_mesh_record *record, bool in_world, air_export_primitive *out)
{
    const air_geometry *geometry = record->geometry;
    out->positions = geometry->positions;
    out->normals = geometry->normals;
    out->tangents = geometry->tangents;
    out->uv[0] = geometry->uv[0];
    out->uv[1] = geometry->uv[1];
    out->colors = geometry->colors;
    out->vertex_count = geometry->vertex_count;
    out->indices = geometry->indices;
    out->triangle_count = geometry->triangle_count;
    if (!in_world)
        return AIR_OK;
    const air_status status = air_mesh_record_place(record);
    if (status != AIR_OK)
        return status;
    out->positions = record->world->positions;
    out->normals = record->world->normals;
    out->tangents = record->world->tangents;
    return AIR_OK;
}

static air_status turn_triangles(air_export *self, air_export_primitive *primitive)
{
    uint32_t *turned = own(self, primitive, primitive->triangle_count, 3 * sizeof *turned);
    if (turned == NULL)
        return AIR_ERROR_MEMORY;
    for (size_t t = 0; t < primitive->triangle_count; ++t) {
        turned[3 * t] = primitive->indices[3 * t];
        turned[3 * t + 1] = primitive->indices[3 * t + 2];
        turned[3 * t + 2] = primitive->indices[3 * t + 1];
    }
    primitive->indices = turned;
    return AIR_OK;
}

/* Normals to the other side; bitangents, which follow from them, stay where they are. */
static air_status turn_normals(air_export *self, air_export_primitive *primitive)
{
    const size_t count = primitive->vertex_count;
    if (primitive->normals == NULL)
        return AIR_OK;
    float *normals = own(self, primitive, count, 3 * sizeof *normals);
    float *tangents = own(self, primitive, count, 4 * sizeof *tangents);
    if (normals == NULL || tangents == NULL)
        return AIR_ERROR_MEMORY;
    for (size_t i = 0; i < 3 * count; ++i)
        normals[i] = -primitive->normals[i];
    for (size_t i = 0; i < 4 * count && primitive->tangents != NULL; ++i)
        tangents[i] = i % 4 == 3 ? -primitive->tangents[i] : primitive->tangents[i];
    primitive->normals = normals;
    if (primitive->tangents != NULL)
        primitive->tangents = tangents;
    return AIR_OK;
}

air_status air_export_primitive_make(air_export *self, air_mesh_record *record, bool in_world,
                                     air_export_primitive *out)
{
    const bool quadric = record->geometry->shape != AIR_SHAPE_TRIANGLES;
    *out = (air_export_primitive){0};
    air_status status =
        quadric ? tessellate(self, record, in_world, out) : take_arrays(record, in_world, out);
    /* A quadric's triangles have been turned by its normals. */
    const bool mirrored = !quadric && in_world && status == AIR_OK && record->world->flip;
    if (status == AIR_OK && mirrored != record->flip_normals)
        status = turn_triangles(self, out);
    if (status == AIR_OK && record->flip_normals)
        status = turn_normals(self, out);
    if (status == AIR_OK && out->normals == NULL && out->tangents != NULL)
        air_warn(self->context, "%s: mesh \"%s\": tangents without normals are left out",
                 self->path, record->base.name);
    return status;
}
