/* unwrap_mesh.c: normals, and neighbours over sides of whatever number of triangles. */
#include "atlas/unwrap_mesh.h"

#include "atlas/edge_table.h"
#include "atlas/triangle.h"
#include "atlas/weld.h"
#include "core/vec.h"

/* Of sides with more triangles only neighbours in the list are linked, so that a fan of thousands
 * stays linear. */
enum { MOST_PAIRED = 8 };

static void set_normal(air_unwrap_mesh *mesh, size_t t)
{
    double normal[3];
    const bool flat = !air_triangle_normal(mesh->positions, mesh->indices + 3 * t, normal);
    const double length = air_length3(normal);
    mesh->areas[t] = flat ? 0.0 : 0.5 * length;
    for (size_t k = 0; k < 3; k++) {
        mesh->normals[3 * t + k] = flat ? 0.0 : normal[k] / length;
    }
}

/* A vertex that lies on another triangle's side only after rounding is off by 2^-25 of its
 * coordinates, three of them; so is the side. Twice that for good measure. */
static void set_tolerance(air_unwrap_mesh *mesh)
{
    float largest = 0.0f;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        const float *p = mesh->positions + 3 * (size_t)mesh->indices[i];
        for (int k = 0; k < 3; k++) {
            largest = float_max(largest, fabsf(p[k]));
        }
    }
    mesh->tolerance = 4.0 * sqrt(3.0) * 0x1p-25 * (double)largest;
}

/* Calls for both triangles of each pair: counts (neighbours NULL) or lists. */
static void pair(const air_edge_table *table, uint32_t *next, uint32_t *neighbours)
{
    for (size_t first = 0; first < table->count;) {
        const size_t end = air_edge_table_run(table, first);
        const size_t reach = end - first <= MOST_PAIRED ? MOST_PAIRED : 1;
        for (size_t i = first; i < end; i++) {
            for (size_t k = i + 1; k < end && k <= i + reach; k++) {
                const uint32_t a = table->edges[i].triangle, b = table->edges[k].triangle;
                if (a == b) { /* folded onto itself */
                    continue;
                }
                if (neighbours != NULL) {
                    neighbours[next[a]] = b;
                    neighbours[next[b]] = a;
                }
                next[a]++;
                next[b]++;
            }
        }
        first = end;
    }
}

static air_status link_neighbours(air_context *context, air_unwrap_mesh *mesh,
                                  const air_edge_table *table)
{
    const size_t count = mesh->triangle_count;
    uint32_t *next = air_allocate(context, count + 1, sizeof *next);
    mesh->first_neighbour = air_allocate(context, count + 1, sizeof *mesh->first_neighbour);
    if (next == NULL || mesh->first_neighbour == NULL) {
        air_free(context, next);
        return AIR_ERROR_MEMORY;
    }
    uint32_t sum = 0;
    pair(table, next, NULL);
    for (size_t t = 0; t < count; t++) {
        const uint32_t here = next[t];
        mesh->first_neighbour[t] = next[t] = sum;
        sum += here;
    }
    mesh->first_neighbour[count] = sum;
    mesh->neighbours = air_allocate(context, sum, sizeof *mesh->neighbours);
    if (mesh->neighbours != NULL) {
        pair(table, next, mesh->neighbours);
    }
    air_free(context, next);
    return mesh->neighbours != NULL ? AIR_OK : AIR_ERROR_MEMORY;
}

static air_status find_neighbours(air_context *context, air_unwrap_mesh *mesh)
{
    const air_weld_keys keys = {mesh->positions, NULL, mesh->vertex_count};
    air_edge_table table = {NULL, 0};
    uint32_t *names = air_allocate(context, mesh->vertex_count, sizeof *names);
    air_status status = names != NULL ? air_weld(context, &keys, names) : AIR_ERROR_MEMORY;
    if (status == AIR_OK) {
        status = air_edge_table_init(context, names, mesh->vertex_count, mesh->indices,
                                     mesh->triangle_count, &table);
    }
    if (status == AIR_OK) {
        status = link_neighbours(context, mesh, &table);
    }
    air_edge_table_finish(context, &table);
    air_free(context, names);
    return status;
}

air_status air_unwrap_mesh_init(air_context *context, const float *positions, size_t vertex_count,
                                const uint32_t *indices, size_t triangle_count,
                                air_unwrap_mesh *out_mesh)
{
    air_unwrap_mesh mesh = {.positions = positions,
                            .indices = indices,
                            .vertex_count = vertex_count,
                            .triangle_count = triangle_count};
    mesh.normals = air_allocate(context, triangle_count, 3 * sizeof *mesh.normals);
    mesh.areas = air_allocate(context, triangle_count, sizeof *mesh.areas);
    if (mesh.normals == NULL || mesh.areas == NULL || find_neighbours(context, &mesh) != AIR_OK) {
        air_unwrap_mesh_finish(context, &mesh);
        return AIR_ERROR_MEMORY;
    }
    for (size_t t = 0; t < triangle_count; t++) {
        set_normal(&mesh, t);
    }
    set_tolerance(&mesh);
    *out_mesh = mesh;
    return AIR_OK;
}

void air_unwrap_mesh_finish(air_context *context, air_unwrap_mesh *mesh)
{
    air_free(context, mesh->neighbours);
    air_free(context, mesh->first_neighbour);
    air_free(context, mesh->areas);
    air_free(context, mesh->normals);
    *mesh = (air_unwrap_mesh){.positions = NULL};
}
