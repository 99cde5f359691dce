/* edge_table.c: two stable counting sorts, by the higher and then by the lower vertex. */
#include "atlas/edge_table.h"

#include <string.h>

static size_t list_edges(const uint32_t *names, const uint32_t *indices, size_t triangle_count,
                         air_edge *edges)
{
    size_t count = 0;
    for (size_t t = 0; t < triangle_count; t++) {
        for (size_t k = 0; k < 3; k++) {
            const uint32_t a = names[indices[3 * t + k]];
            const uint32_t b = names[indices[3 * t + (k + 1) % 3]];
            if (a != b) {
                edges[count++] = (air_edge){.low = a < b ? a : b,
                                            .high = a < b ? b : a,
                                            .triangle = (uint32_t)t,
                                            .corner = (uint8_t)k,
                                            .reversed = a > b};
            }
        }
    }
    return count;
}

static void sort_by(const air_edge *from, size_t count, bool by_low, size_t *starts,
                    size_t vertex_count, air_edge *to)
{
    memset(starts, 0, (vertex_count + 1) * sizeof *starts);
    for (size_t i = 0; i < count; i++) {
        starts[(by_low ? from[i].low : from[i].high) + 1]++;
    }
    for (size_t v = 0; v < vertex_count; v++) {
        starts[v + 1] += starts[v];
    }
    for (size_t i = 0; i < count; i++) {
        to[starts[by_low ? from[i].low : from[i].high]++] = from[i];
    }
}

air_status air_edge_table_init(air_context *context, const uint32_t *names, size_t vertex_count,
                               const uint32_t *indices, size_t triangle_count,
                               air_edge_table *out_table)
{
    *out_table = (air_edge_table){NULL, 0};
    air_edge *edges = air_allocate(context, triangle_count, 3 * sizeof *edges);
    air_edge *other = air_allocate(context, triangle_count, 3 * sizeof *other);
    size_t *starts = air_allocate(context, vertex_count + 1, sizeof *starts);
    const bool good = edges != NULL && other != NULL && starts != NULL;
    if (good) {
        const size_t count = list_edges(names, indices, triangle_count, edges);
        sort_by(edges, count, false, starts, vertex_count, other);
        sort_by(other, count, true, starts, vertex_count, edges);
        *out_table = (air_edge_table){edges, count};
        edges = NULL;
    }
    air_free(context, starts);
    air_free(context, other);
    air_free(context, edges);
    return good ? AIR_OK : AIR_ERROR_MEMORY;
}

void air_edge_table_finish(air_context *context, air_edge_table *table)
{
    air_free(context, table->edges);
    *table = (air_edge_table){NULL, 0};
}
