#include <string.h>

#include "scene/import/mitsuba/mitsuba.h"

/* Faces of the cube by their normal and the corner of each of their four vertices: bit k of a
 * corner says on which side of axis k it lies. Each face has the whole of uv. */
static const struct {
    float normal[3];
    uint8_t corners[4];
} cube_faces[6] = {{{0, -1, 0}, {1, 5, 4, 0}}, {{0, 1, 0}, {3, 2, 6, 7}},
                   {{1, 0, 0}, {1, 3, 7, 5}},  {{0, 0, 1}, {5, 7, 6, 4}},
                   {{-1, 0, 0}, {4, 6, 2, 0}}, {{0, 0, -1}, {3, 1, 0, 2}}};
static const float cube_uv[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};

static const struct {
    float position[2], uv[2];
} rectangle_corners[4] = {
    {{-1, -1}, {0, 0}}, {{1, -1}, {1, 0}}, {{1, 1}, {1, 1}}, {{-1, 1}, {0, 1}}};

/* Room for faces of four vertices and two triangles. */
static air_status allocate_faces(air_context *context, size_t count, air_mesh_file *mesh)
{
    mesh->vertex_count = 4 * count;
    mesh->triangle_count = 2 * count;
    mesh->positions = air_allocate(context, mesh->vertex_count, 3 * sizeof(float));
    mesh->normals = air_allocate(context, mesh->vertex_count, 3 * sizeof(float));
    mesh->uv = air_allocate(context, mesh->vertex_count, 2 * sizeof(float));
    mesh->indices = air_allocate(context, mesh->triangle_count, 3 * sizeof(uint32_t));
    if (mesh->positions == NULL || mesh->normals == NULL || mesh->uv == NULL ||
        mesh->indices == NULL)
        return air_fail_memory(context, "shape");
    for (uint32_t face = 0; face < count; ++face) {
        const uint32_t corners[6] = {0, 1, 2, 3, 0, 2};
        for (size_t i = 0; i < 6; ++i)
            mesh->indices[6 * face + i] = 4 * face + corners[i];
    }
    return AIR_OK;
}

static void fill_cube(air_mesh_file *mesh)
{
    for (size_t vertex = 0; vertex < 24; ++vertex) {
        const uint8_t corner = cube_faces[vertex / 4].corners[vertex % 4];
        for (size_t axis = 0; axis < 3; ++axis)
            mesh->positions[3 * vertex + axis] = (corner >> axis & 1) != 0 ? 1.0f : -1.0f;
        memcpy(mesh->normals + 3 * vertex, cube_faces[vertex / 4].normal, 3 * sizeof(float));
        memcpy(mesh->uv + 2 * vertex, cube_uv[vertex % 4], sizeof cube_uv[0]);
    }
}

static void fill_rectangle(air_mesh_file *mesh)
{
    for (size_t vertex = 0; vertex < 4; ++vertex) {
        memcpy(mesh->positions + 3 * vertex, rectangle_corners[vertex].position, 2 * sizeof(float));
        mesh->normals[3 * vertex + 2] = 1.0f;
        memcpy(mesh->uv + 2 * vertex, rectangle_corners[vertex].uv, 2 * sizeof(float));
    }
}

air_status air_mitsuba_solid(air_context *context, const air_xml *at, air_mitsuba_geometry *out)
{
    const bool cube = air_mitsuba_is(at, "cube");
    const air_status status = allocate_faces(context, cube ? 6 : 1, &out->mesh);
    if (status != AIR_OK)
        return status;
    out->box = cube;
    if (cube)
        fill_cube(&out->mesh);
    else
        fill_rectangle(&out->mesh);
    return AIR_OK;
}
