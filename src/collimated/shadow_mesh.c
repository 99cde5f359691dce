/* shadow_mesh.c: projection of meshes into light space, and the adjacency of their triangles.
 *
 * Two triangles continue each other beyond an edge if they alone share it and their third corners
 * lie strictly on opposite sides of it in projection. Corners are the same if their projections are
 * equal as floats, so it does not matter how the meshes index their vertices. */
#include "collimated/shadow_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/host.h"

enum {
    CHUNK = 4096,           /* vertices, triangles or corners per task */
    SORT_ABOVE = 24,        /* edges at one corner that are matched by sorting, not pairwise */
    TRIANGLES_MAX = 1 << 28 /* so that indices of corners, nodes and blocks fit 32 bits */
};

/* The edge from the corner under which it is filed to a higher one. */
typedef struct filed_edge {
    uint32_t other;
    uint32_t side; /* 3 * triangle + edge */
} filed_edge;

typedef struct projection {
    const shadow_frame *frame;
    const air_shadow_mesh *meshes;
    size_t mesh_count, vertex_count;
    size_t *first_vertex; /* of each mesh, and the total */
    float (*points)[3];   /* per vertex */
    uint32_t *corners;    /* 3 per kept triangle: vertices, then the first vertex equal to it */
    uint32_t *table;      /* hash table of vertices + 1 */
    uint32_t *edge_starts;
    filed_edge *edges;
    size_t *bad_vertices; /* per chunk: first vertex that is not finite, or SIZE_MAX */
    shadow_mesh *out;
} projection;

/* ---- checks ---- */

static air_status check_indices(air_context *context, const air_shadow_mesh *mesh, size_t number)
{
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        if (mesh->indices[i] >= mesh->vertex_count) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "shadow tree: mesh %zu, triangle %zu: index %u, but there are %zu "
                            "vertices",
                            number, i / 3, mesh->indices[i], mesh->vertex_count);
        }
    }
    return AIR_OK;
}

/* Sets *out_triangles to their number in all meshes. */
static air_status check_meshes(air_context *context, const air_shadow_mesh *meshes,
                               size_t mesh_count, size_t *out_triangles)
{
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < mesh_count; i++) {
        const air_shadow_mesh *mesh = &meshes[i];
        if (mesh->vertex_count > TRIANGLES_MAX || mesh->triangle_count > TRIANGLES_MAX ||
            (vertices += mesh->vertex_count) > 3 * (size_t)TRIANGLES_MAX ||
            (triangles += mesh->triangle_count) > TRIANGLES_MAX) {
            return air_fail(context, AIR_ERROR_UNSUPPORTED, "shadow tree: more than %d triangles",
                            (int)TRIANGLES_MAX);
        }
        if ((mesh->vertex_count > 0 && mesh->positions == NULL) ||
            (mesh->triangle_count > 0 && mesh->indices == NULL)) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "shadow tree: mesh %zu has no positions or no indices", i);
        }
        const air_status status = check_indices(context, mesh, i);
        if (status != AIR_OK) {
            return status;
        }
    }
    *out_triangles = triangles;
    return AIR_OK;
}

/* ---- projection ---- */

static size_t mesh_of_vertex(const projection *self, size_t vertex)
{
    size_t low = 0, high = self->mesh_count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        *(self->first_vertex[middle] <= vertex ? &low : &high) = middle;
    }
    return low;
}

static void project_chunk(void *user, size_t chunk, size_t worker)
{
    projection *self = user;
    const shadow_frame *frame = self->frame;
    const size_t begin = chunk * CHUNK;
    const size_t end = begin + CHUNK < self->vertex_count ? begin + CHUNK : self->vertex_count;
    size_t mesh = mesh_of_vertex(self, begin);
    (void)worker;
    self->bad_vertices[chunk] = SIZE_MAX;
    for (size_t v = begin; v < end; v++) {
        while (v >= self->first_vertex[mesh + 1]) {
            mesh++;
        }
        const float *p = self->meshes[mesh].positions + 3 * (v - self->first_vertex[mesh]);
        const double q[3] = {(double)p[0] - frame->centre[0], (double)p[1] - frame->centre[1],
                             (double)p[2] - frame->centre[2]};
        for (int k = 0; k < 3; k++) {
            const double *axis = frame->axes[k];
            /* + 0: never -0, so that equal floats have equal bits */
            self->points[v][k] = (float)(axis[0] * q[0] + axis[1] * q[1] + axis[2] * q[2]) + 0.0f;
            if (!isfinite(self->points[v][k]) && self->bad_vertices[chunk] == SIZE_MAX) {
                self->bad_vertices[chunk] = v;
            }
        }
    }
}

static air_status project(air_context *context, projection *self)
{
    const size_t chunks = (self->vertex_count + CHUNK - 1) / CHUNK;
    air_parallel_for(context, chunks, project_chunk, self);
    for (size_t i = 0; i < chunks; i++) {
        if (self->bad_vertices[i] != SIZE_MAX) {
            const size_t mesh = mesh_of_vertex(self, self->bad_vertices[i]);
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "shadow tree: mesh %zu, vertex %zu: position is not finite", mesh,
                            self->bad_vertices[i] - self->first_vertex[mesh]);
        }
    }
    return AIR_OK;
}

static float least(const float v[3])
{
    const float low = v[0] < v[1] ? v[0] : v[1];
    return low < v[2] ? low : v[2];
}

static float greatest(const float v[3])
{
    const float high = v[0] > v[1] ? v[0] : v[1];
    return high > v[2] ? high : v[2];
}

static bool throws_shadow(const shadow_frame *frame, const shadow_triangle *t)
{
    const double x = frame->half[0], y = frame->half[1];
    const double area = ((double)t->x[1] - t->x[0]) * ((double)t->y[2] - t->y[0]) -
                        ((double)t->x[2] - t->x[0]) * ((double)t->y[1] - t->y[0]);
    return area != 0.0 && (double)greatest(t->z) > frame->floor && (double)greatest(t->x) >= -x &&
           (double)least(t->x) <= x && (double)greatest(t->y) >= -y && (double)least(t->y) <= y;
}

static void keep_triangles(projection *self)
{
    shadow_mesh *out = self->out;
    for (size_t m = 0; m < self->mesh_count; m++) {
        const air_shadow_mesh *mesh = &self->meshes[m];
        for (size_t i = 0; i < mesh->triangle_count; i++) {
            shadow_triangle *t = &out->triangles[out->count];
            uint32_t *corners = self->corners + 3 * out->count;
            for (int k = 0; k < 3; k++) {
                corners[k] = (uint32_t)(self->first_vertex[m] + mesh->indices[3 * i + (size_t)k]);
                t->x[k] = self->points[corners[k]][0];
                t->y[k] = self->points[corners[k]][1];
                t->z[k] = self->points[corners[k]][2];
            }
            out->count += throws_shadow(self->frame, t);
        }
    }
}

/* ---- welding ---- */

static uint32_t hash_point(const float p[3])
{
    uint32_t bits[3];
    memcpy(bits, p, sizeof bits);
    uint64_t h = bits[0] * 0x9e3779b97f4a7c15u;
    h = (h ^ (h >> 32) ^ bits[1]) * 0xd6e8feb86659fd93u;
    h = (h ^ (h >> 32) ^ bits[2]) * 0xd6e8feb86659fd93u;
    return (uint32_t)(h >> 32);
}

/* Replaces each corner by the first vertex met at the same place. table_size is a power of two
 * above the number of vertices. */
static void weld(projection *self, size_t table_size)
{
    const uint32_t mask = (uint32_t)(table_size - 1);
    for (size_t i = 0; i < 3 * self->out->count; i++) {
        const float *p = self->points[self->corners[i]];
        uint32_t slot = hash_point(p) & mask;
        while (self->table[slot] != 0 &&
               memcmp(self->points[self->table[slot] - 1], p, 3 * sizeof *p) != 0) {
            slot = (slot + 1) & mask;
        }
        if (self->table[slot] == 0) {
            self->table[slot] = self->corners[i] + 1;
        }
        self->corners[i] = self->table[slot] - 1;
    }
}

/* ---- adjacency ---- */

static uint32_t next_corner(uint32_t side) { return side % 3 == 2 ? side - 2 : side + 1; }

/* Files every edge under its lower corner, in the order of the triangles. */
static void file_edges(projection *self)
{
    const size_t sides = 3 * self->out->count;
    uint32_t *starts = self->edge_starts;
    for (uint32_t i = 0; i < sides; i++) {
        const uint32_t a = self->corners[i], b = self->corners[next_corner(i)];
        starts[(a < b ? a : b) + 1]++;
    }
    for (size_t v = 0; v < self->vertex_count; v++) {
        starts[v + 1] += starts[v];
    }
    for (uint32_t i = 0; i < sides; i++) {
        const uint32_t a = self->corners[i], b = self->corners[next_corner(i)];
        self->edges[starts[a < b ? a : b]++] = (filed_edge){a < b ? b : a, i};
    }
    memmove(starts + 1, starts, self->vertex_count * sizeof *starts); /* back to the beginnings */
    starts[0] = 0;
}

/* On which side of the line from a to b lies p: 1, -1, or 0 where rounding could decide. */
static int side_of(const float a[3], const float b[3], const float p[3])
{
    const double left = ((double)b[0] - a[0]) * ((double)p[1] - a[1]);
    const double right = ((double)b[1] - a[1]) * ((double)p[0] - a[0]);
    const double cross = left - right;
    if (!(fabs(cross) > 1e-12 * (fabs(left) + fabs(right)))) {
        return 0;
    }
    return cross > 0.0 ? 1 : -1;
}

/* Two sides of triangles along the same edge, which no third has. */
static void join_sides(projection *self, uint32_t a, uint32_t b)
{
    const uint32_t *corners = self->corners;
    const float *from = self->points[corners[a]], *to = self->points[corners[next_corner(a)]];
    const float *third_a = self->points[corners[next_corner(next_corner(a))]];
    const float *third_b = self->points[corners[next_corner(next_corner(b))]];
    if (side_of(from, to, third_a) * side_of(from, to, third_b) < 0) {
        self->out->neighbours[a] = (int32_t)(b / 3);
        self->out->neighbours[b] = (int32_t)(a / 3);
    }
}

static int compare_edges(const void *a, const void *b)
{
    const filed_edge *x = a, *y = b;
    if (x->other != y->other) {
        return x->other < y->other ? -1 : 1;
    }
    return x->side < y->side ? -1 : 1;
}

static void match_sorted(projection *self, const filed_edge *edges, size_t count)
{
    for (size_t i = 0; i < count;) {
        size_t end = i + 1;
        while (end < count && edges[end].other == edges[i].other) {
            end++;
        }
        if (end - i == 2) {
            join_sides(self, edges[i].side, edges[i + 1].side);
        }
        i = end;
    }
}

static void match_pairwise(projection *self, const filed_edge *edges, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        size_t others = 0, last = 0;
        for (size_t k = 0; k < count; k++) {
            if (k != i && edges[k].other == edges[i].other) {
                others++;
                last = k;
            }
        }
        if (others == 1 && last > i) {
            join_sides(self, edges[i].side, edges[last].side);
        }
    }
}

static void match_chunk(void *user, size_t chunk, size_t worker)
{
    projection *self = user;
    const size_t begin = chunk * CHUNK;
    const size_t end = begin + CHUNK < self->vertex_count ? begin + CHUNK : self->vertex_count;
    (void)worker;
    for (size_t v = begin; v < end; v++) {
        filed_edge *edges = self->edges + self->edge_starts[v];
        const size_t count = self->edge_starts[v + 1] - self->edge_starts[v];
        if (count > SORT_ABOVE) {
            qsort(edges, count, sizeof *edges, compare_edges);
            match_sorted(self, edges, count);
        } else {
            match_pairwise(self, edges, count);
        }
    }
}

/* ---- all of it ---- */

static air_status allocate_projection(air_context *context, projection *self, size_t triangles,
                                      size_t *out_table_size)
{
    const size_t vertices = self->vertex_count;
    size_t table_size = 16;
    while (table_size < 2 * vertices) {
        table_size *= 2;
    }
    self->points = air_allocate(context, vertices, sizeof *self->points);
    self->corners = air_allocate(context, 3 * triangles, sizeof *self->corners);
    self->table = air_allocate(context, table_size, sizeof *self->table);
    self->edge_starts = air_allocate(context, vertices + 2, sizeof *self->edge_starts);
    self->edges = air_allocate(context, 3 * triangles, sizeof *self->edges);
    self->bad_vertices = air_allocate(context, vertices / CHUNK + 1, sizeof *self->bad_vertices);
    self->out->triangles = air_allocate(context, triangles, sizeof *self->out->triangles);
    self->out->neighbours = air_allocate(context, 3 * triangles, sizeof *self->out->neighbours);
    *out_table_size = table_size;
    const bool done = self->points != NULL && self->corners != NULL && self->table != NULL &&
                      self->edge_starts != NULL && self->edges != NULL &&
                      self->bad_vertices != NULL && self->out->triangles != NULL &&
                      self->out->neighbours != NULL;
    return done ? AIR_OK : air_fail_memory(context, "shadow tree");
}

static void free_projection(air_context *context, projection *self)
{
    air_free(context, self->first_vertex);
    air_free(context, self->points);
    air_free(context, self->corners);
    air_free(context, self->table);
    air_free(context, self->edge_starts);
    air_free(context, self->edges);
    air_free(context, self->bad_vertices);
}

static air_status fill_mesh(air_context *context, projection *self, size_t triangles)
{
    size_t table_size;
    self->first_vertex = air_allocate(context, self->mesh_count + 1, sizeof *self->first_vertex);
    if (self->first_vertex == NULL) {
        return air_fail_memory(context, "shadow tree");
    }
    for (size_t i = 0; i < self->mesh_count; i++) {
        self->first_vertex[i + 1] = self->first_vertex[i] + self->meshes[i].vertex_count;
    }
    self->vertex_count = self->first_vertex[self->mesh_count];
    air_status status = allocate_projection(context, self, triangles, &table_size);
    if (status == AIR_OK) {
        status = project(context, self);
    }
    if (status != AIR_OK) {
        return status;
    }
    keep_triangles(self);
    weld(self, table_size);
    file_edges(self);
    for (size_t i = 0; i < 3 * self->out->count; i++) {
        self->out->neighbours[i] = -1;
    }
    air_parallel_for(context, (self->vertex_count + CHUNK - 1) / CHUNK, match_chunk, self);
    return AIR_OK;
}

air_status air_shadow_mesh_init(air_context *context, const shadow_frame *frame,
                                const air_shadow_mesh *meshes, size_t mesh_count, shadow_mesh *out)
{
    projection self = {.frame = frame, .meshes = meshes, .mesh_count = mesh_count, .out = out};
    size_t triangles = 0;
    *out = (shadow_mesh){0};
    air_status status = check_meshes(context, meshes, mesh_count, &triangles);
    if (status == AIR_OK && triangles > 0) {
        status = fill_mesh(context, &self, triangles);
        free_projection(context, &self);
    }
    if (status != AIR_OK) {
        air_shadow_mesh_finish(context, out);
    }
    return status;
}

void air_shadow_mesh_finish(air_context *context, shadow_mesh *mesh)
{
    air_free(context, mesh->triangles);
    air_free(context, mesh->neighbours);
    *mesh = (shadow_mesh){0};
}
