#include <stdlib.h>
#include <string.h>

#include "scene/import/mitsuba/mitsuba.h"

typedef struct air_mitsuba_vertex {
    float position[3];
    uint32_t index;
} air_mitsuba_vertex;

/* An edge from its lower vertex to its higher one; passes: as often it is passed that way, less
 * the other. */
typedef struct air_mitsuba_edge {
    uint32_t low, high;
    int passes;
} air_mitsuba_edge;

static int compare_vertices(const void *a, const void *b)
{
    const air_mitsuba_vertex *p = a, *q = b;
    for (size_t i = 0; i < 3; ++i)
        if (p->position[i] != q->position[i])
            return p->position[i] < q->position[i] ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b)
{
    const air_mitsuba_edge *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    return p->high == q->high ? 0 : p->high < q->high ? -1 : 1;
}

/* For each vertex the number of its place, which several vertices may share. */
static void weld(const air_import_geometry *geometry, air_mitsuba_vertex *vertices,
                 uint32_t *places)
{
    for (size_t i = 0; i < geometry->vertex_count; ++i) {
        memcpy(vertices[i].position, geometry->positions + 3 * i, sizeof vertices[i].position);
        vertices[i].index = (uint32_t)i;
    }
    qsort(vertices, geometry->vertex_count, sizeof *vertices, compare_vertices);
    uint32_t place = 0;
    for (size_t i = 0; i < geometry->vertex_count; ++i) {
        place += i > 0 && compare_vertices(&vertices[i - 1], &vertices[i]) != 0;
        places[vertices[i].index] = place;
    }
}

static size_t list_edges(const air_import_geometry *geometry, const uint32_t *places,
                         air_mitsuba_edge *edges)
{
    size_t count = 0;
    for (size_t i = 0; i < 3 * geometry->triangle_count; ++i) {
        const uint32_t from = places[geometry->indices[i]];
        const uint32_t to = places[geometry->indices[i % 3 == 2 ? i - 2 : i + 1]];
        if (from < to)
            edges[count++] = (air_mitsuba_edge){from, to, 1};
        else if (to < from)
            edges[count++] = (air_mitsuba_edge){to, from, -1};
    }
    return count;
}

static bool edges_cancel(air_mitsuba_edge *edges, size_t count)
{
    int passes = 0;
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0; i < count; ++i) {
        passes += edges[i].passes;
        const bool last = i + 1 == count || compare_edges(&edges[i], &edges[i + 1]) != 0;
        if (last && passes != 0)
            return false;
    }
    return count > 0;
}

air_status air_mitsuba_is_closed(air_context *context, const air_import_geometry *geometry,
                                 bool *out_closed)
{
    air_mitsuba_vertex *vertices = air_allocate(context, geometry->vertex_count, sizeof *vertices);
    uint32_t *places = air_allocate(context, geometry->vertex_count, sizeof *places);
    air_mitsuba_edge *edges = air_allocate(context, geometry->triangle_count, 3 * sizeof *edges);
    const bool ok = vertices != NULL && places != NULL && edges != NULL;
    if (ok) {
        weld(geometry, vertices, places);
        *out_closed = edges_cancel(edges, list_edges(geometry, places, edges));
    }
    air_free(context, vertices);
    air_free(context, places);
    air_free(context, edges);
    return ok ? AIR_OK : air_fail_memory(context, "medium boundary");
}
