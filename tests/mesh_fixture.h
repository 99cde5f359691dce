/* mesh_fixture.h: mesh files in memory, read and looked at. */
#ifndef AIR_TESTS_MESH_FIXTURE_H
#define AIR_TESTS_MESH_FIXTURE_H

#include <math.h>

#include "core/triple.h"
#include "memory_files.h"
#include "scene/import/mesh_file.h"

static inline air_status mesh_read(memory_file *host, air_mesh_format format, const void *data,
                                   size_t size, air_mesh_file *out)
{
    memory_file_serve(host, data, size);
    return air_mesh_file_read(host->context, "file", format, 0, out);
}

/* This file is refused with a message that says `part`, and the output is untouched. */
static inline void mesh_expect_refusal(air_mesh_format format, const void *data, size_t size,
                                       const char *part)
{
    memory_file host;
    memory_file_init(&host);
    air_mesh_file mesh = {.vertex_count = 7};
    const air_status status = mesh_read(&host, format, data, size, &mesh);
    if (status == AIR_OK)
        fail_msg("not refused: expected \"%s\"", part);
    memory_file_expect(&host, part);
    assert_true(mesh.vertex_count == 7 && mesh.positions == NULL);
    memory_file_finish(&host);
}

/* Every allocation that this file needs may fail: a message each time, and no leak. */
static inline void mesh_expect_survival(air_mesh_format format, const void *data, size_t size)
{
    memory_file host;
    memory_file_init(&host);
    air_status status = AIR_ERROR_MEMORY;
    for (long allowed = 0; status != AIR_OK; ++allowed) {
        air_mesh_file mesh = {0};
        assert_true(allowed < 100);
        atomic_store(&host.allocator.remaining, allowed);
        status = mesh_read(&host, format, data, size, &mesh);
        atomic_store(&host.allocator.remaining, 1000000);
        if (status == AIR_OK)
            air_mesh_file_finish(host.context, &mesh);
        else
            assert_int_equal(status, AIR_ERROR_MEMORY);
    }
    memory_file_finish(&host);
}

/* Twice the vector area of all triangles: for planar parts its length is twice their area. */
static inline void mesh_vector_area(const air_mesh_file *mesh, double out[3])
{
    out[0] = out[1] = out[2] = 0.0;
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        double p[3][3], a[3], b[3], cross[3];
        for (int k = 0; k < 9; ++k)
            p[k / 3][k % 3] =
                (double)
                    mesh->positions[3 * mesh->indices[3 * i + (size_t)(k / 3)] + (uint32_t)(k % 3)];
        air_subtract3(p[1], p[0], a);
        air_subtract3(p[2], p[0], b);
        air_cross3(a, b, cross);
        for (int k = 0; k < 3; ++k)
            out[k] += cross[k];
    }
}

#endif
