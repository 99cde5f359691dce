/* fuzz_mesh.h: what the harnesses of mesh files share: a mesh is sound, or there is an error. */
#ifndef AIR_TESTS_FUZZ_MESH_H
#define AIR_TESTS_FUZZ_MESH_H

#include <math.h>

#include "fuzz_host.h"
#include "scene/import/mesh_file.h"

static inline void fuzz_check_numbers(const float *values, size_t count)
{
    for (size_t i = 0; values != NULL && i < count; ++i) {
        if (!isfinite(values[i]))
            abort();
    }
}

static inline void fuzz_mesh(const uint8_t *data, size_t size, air_mesh_format format,
                             size_t shape_index)
{
    fuzz_files files = {.files = {{"", data, size}}, .count = 1};
    air_context *context = fuzz_context(&files, NULL);
    air_mesh_file mesh = {0};
    if (context == NULL)
        return;
    const air_status status = air_mesh_file_read(context, "input", format, shape_index, &mesh);
    fuzz_check_outcome(context, status, mesh.positions);
    fuzz_check_numbers(mesh.positions, 3 * mesh.vertex_count);
    fuzz_check_numbers(mesh.normals, 3 * mesh.vertex_count);
    fuzz_check_numbers(mesh.uv, 2 * mesh.vertex_count);
    fuzz_check_numbers(mesh.colors, 4 * mesh.vertex_count);
    for (size_t i = 0; i < 3 * mesh.triangle_count; ++i) {
        if (mesh.indices[i] >= mesh.vertex_count)
            abort();
    }
    air_mesh_file_finish(context, &mesh);
    air_context_destroy(context);
}

#endif
