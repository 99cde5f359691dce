/* edge_table.h: the sides of triangles, sorted so that those over the same two vertices stand side
 * by side. */
#ifndef AIR_ATLAS_EDGE_TABLE_H
#define AIR_ATLAS_EDGE_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include "core/host.h"

/* Side `corner` of a triangle runs from its vertex `corner` to the next one. */
typedef struct air_edge {
    uint32_t low, high; /* the vertices' names, low < high */
    uint32_t triangle;
    uint8_t corner;
    bool reversed; /* the triangle runs from high to low */
} air_edge;

typedef struct air_edge_table {
    air_edge *edges; /* by low, then high, then triangle */
    size_t count;
} air_edge_table;

/* names[v] stands for vertex v (air_weld); sides between equal names are left out. Linear. Fails
 * for want of memory only, without a message. Free with air_edge_table_finish. */
air_status air_edge_table_init(air_context *context, const uint32_t *names, size_t vertex_count,
                               const uint32_t *indices, size_t triangle_count,
                               air_edge_table *out_table);
void air_edge_table_finish(air_context *context, air_edge_table *table);

/* One past the last edge over the same vertices as edge `first`. */
static inline size_t air_edge_table_run(const air_edge_table *table, size_t first)
{
    size_t end = first + 1;
    while (end < table->count && table->edges[end].low == table->edges[first].low &&
           table->edges[end].high == table->edges[first].high) {
        end++;
    }
    return end;
}

#endif
