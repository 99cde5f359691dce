#include "scene/import/mesh_file.h"

#include "core/vec.h"
#include "scene/import/mesh_decode.h"

void air_mesh_file_finish(air_context *context, air_mesh_file *file)
{
    air_free(context, file->indices);
    air_free(context, file->colors);
    air_free(context, file->uv);
    air_free(context, file->normals);
    air_free(context, file->positions);
    *file = (air_mesh_file){0};
}

static air_status decode(air_context *context, const char *path, air_mesh_format format,
                         size_t shape_index, const void *data, size_t size, air_mesh_file *out)
{
    switch (format) {
    case AIR_MESH_OBJ:
        return air_mesh_obj_decode(context, path, data, size, out);
    case AIR_MESH_PLY:
        return air_mesh_ply_decode(context, path, data, size, out);
    case AIR_MESH_SERIALIZED:
        return air_mesh_serialized_decode(context, path, data, size, shape_index, out);
    }
    return air_fail(context, AIR_ERROR_ARGUMENT, "%s: %d is no format of meshes", path,
                    (int)format);
}

air_status air_mesh_file_decode(air_context *context, const char *path, air_mesh_format format,
                                size_t shape_index, const void *data, size_t size,
                                air_mesh_file *out)
{
    air_mesh_file mesh = {0};
    air_status status = decode(context, path, format, shape_index, data, size, &mesh);
    if (status == AIR_OK && mesh.triangle_count == 0)
        status = air_fail(context, AIR_ERROR_FORMAT, "%s: expected at least one triangle", path);
    if (status == AIR_OK)
        *out = mesh;
    else
        air_mesh_file_finish(context, &mesh);
    return status;
}

air_status air_mesh_file_read(air_context *context, const char *path, air_mesh_format format,
                              size_t shape_index, air_mesh_file *out)
{
    void *data = NULL;
    size_t size = 0;
    air_status status = air_file_read(context, path, &data, &size);
    if (status == AIR_OK)
        status = air_mesh_file_decode(context, path, format, shape_index, data, size, out);
    air_free(context, data);
    return status;
}

/* The angle between two vectors: the two halves of a unit rhombus's diagonals keep their digits
 * where an arc cosine would not [Kahan2006]. */
static float angle_between(air_vec3 a, air_vec3 b)
{
    const air_vec3 p = vec3_scale(a, vec3_length(b)), q = vec3_scale(b, vec3_length(a));
    return 2.0f * atan2f(vec3_length(vec3_sub(p, q)), vec3_length(vec3_add(p, q)));
}

static void add_triangle(const air_mesh_file *file, const uint32_t *indices)
{
    air_vec3 corners[3];
    for (int k = 0; k < 3; ++k)
        corners[k] = vec3_load(file->positions + 3 * (size_t)indices[k]);
    const air_vec3 across =
        vec3_cross(vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[0]));
    const float area2 = vec3_length(across);
    if (!(area2 > 0.0f))
        return;
    for (int k = 0; k < 3; ++k) {
        float *normal = file->normals + 3 * (size_t)indices[k];
        const float angle = angle_between(vec3_sub(corners[(k + 1) % 3], corners[k]),
                                          vec3_sub(corners[(k + 2) % 3], corners[k]));
        vec3_store(normal, vec3_madd(vec3_load(normal), angle / area2, across));
    }
}

air_status air_mesh_file_smooth(air_context *context, air_mesh_file *file)
{
    file->normals = air_allocate(context, 3 * file->vertex_count, sizeof *file->normals);
    if (file->normals == NULL)
        return air_fail_memory(context, "normals of a mesh");
    for (size_t i = 0; i < file->triangle_count; ++i)
        add_triangle(file, file->indices + 3 * i);
    for (size_t i = 0; i < file->vertex_count; ++i) {
        const air_vec3 sum = vec3_load(file->normals + 3 * i);
        const float length = vec3_length(sum);
        if (length > 0.0f)
            vec3_store(file->normals + 3 * i, vec3_scale(sum, 1.0f / length));
    }
    return AIR_OK;
}
