#include "scene/media/boundary_topology.h"

#include <stdlib.h>
#include <string.h>

#define NO_TRIANGLE UINT32_MAX

/* A place with the vertex it belongs to. */
typedef struct weld_key {
    float p[3];
    uint32_t vertex;
} weld_key;

/* An edge of a triangle, from its lower to its higher vertex. */
typedef struct half_edge {
    uint32_t low, high;
    uint32_t triangle;
    uint32_t corner; /* the edge begins here */
    bool forward;    /* the triangle runs from low to high */
} half_edge;

typedef struct component {
    double volume; /* signed */
    float low[3], high[3];
    uint32_t first; /* a triangle of it */
    bool flip;
} component;

/* A mesh under analysis. */
typedef struct mesh_work {
    const air_subject *subject;
    air_context *context;
    air_topology mesh;
    half_edge *edges;
    uint32_t *neighbours; /* per triangle and corner: 2 * triangle + (same direction ? 1 : 0) */
    uint32_t *owners;     /* per triangle: its component */
    bool *flips;          /* per triangle */
    uint32_t *stack;
    component *components;
} mesh_work;

typedef struct dvec3 {
    double x, y, z;
} dvec3;

static dvec3 load(const float *p) { return (dvec3){(double)p[0], (double)p[1], (double)p[2]}; }

static dvec3 sub(dvec3 a, dvec3 b) { return (dvec3){a.x - b.x, a.y - b.y, a.z - b.z}; }

static double dot(dvec3 a, dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static dvec3 cross(dvec3 a, dvec3 b)
{
    return (dvec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static int compare_keys(const void *a, const void *b)
{
    const weld_key *ka = a, *kb = b;
    for (int k = 0; k < 3; k++) {
        if (ka->p[k] != kb->p[k]) {
            return ka->p[k] < kb->p[k] ? -1 : 1;
        }
    }
    return ka->vertex < kb->vertex ? -1 : ka->vertex > kb->vertex;
}

static int compare_edges(const void *a, const void *b)
{
    const half_edge *ea = a, *eb = b;
    if (ea->low != eb->low) {
        return ea->low < eb->low ? -1 : 1;
    }
    if (ea->high != eb->high) {
        return ea->high < eb->high ? -1 : 1;
    }
    return ea->triangle < eb->triangle ? -1 : ea->triangle > eb->triangle;
}

static air_status check_input(const mesh_work *work, const float *positions, size_t vertex_count,
                              const uint32_t *indices, size_t triangle_count)
{
    if (triangle_count > UINT32_MAX / 4 || vertex_count > UINT32_MAX / 4) {
        return air_subject_fail(work->subject, "the boundary mesh has %zu triangles, too many",
                                triangle_count);
    }
    for (size_t i = 0; i < 3 * vertex_count; i++) {
        if (!isfinite(positions[i])) {
            return air_subject_fail(work->subject, "vertex %zu of the boundary mesh is not finite",
                                    i / 3);
        }
    }
    for (size_t i = 0; i < 3 * triangle_count; i++) {
        if (indices[i] >= vertex_count) {
            return air_subject_fail(
                work->subject,
                "triangle %zu of the boundary mesh has index %u, there are %zu vertices", i / 3,
                indices[i], vertex_count);
        }
    }
    return AIR_OK;
}

/* Makes vertices at the same place one. Places must be equal exactly: meshes are split along seams
 * of normals and texture coordinates, where exporters repeat the position. */
static air_status weld(mesh_work *work, const float *positions, size_t vertex_count,
                       const uint32_t *indices, size_t triangle_count)
{
    air_topology *mesh = &work->mesh;
    weld_key *keys = air_allocate(work->context, vertex_count, sizeof *keys);
    uint32_t *map = air_allocate(work->context, vertex_count, sizeof *map);
    mesh->positions = air_allocate(work->context, 3 * vertex_count + 1, sizeof(float));
    mesh->indices = air_allocate(work->context, 3 * triangle_count, sizeof(uint32_t));
    air_status status = AIR_OK;
    if (keys == NULL || map == NULL || mesh->positions == NULL || mesh->indices == NULL) {
        status = air_fail_memory(work->context, "boundary mesh");
        goto cleanup;
    }
    for (size_t v = 0; v < vertex_count; v++) {
        keys[v].vertex = (uint32_t)v;
        for (int k = 0; k < 3; k++) {
            keys[v].p[k] = positions[3 * v + (size_t)k] + 0.0f; /* -0 becomes 0 */
        }
    }
    qsort(keys, vertex_count, sizeof *keys, compare_keys);
    for (size_t v = 0; v < vertex_count; v++) {
        if (v == 0 || memcmp(keys[v].p, keys[v - 1].p, sizeof keys[v].p) != 0) {
            memcpy(mesh->positions + 3 * mesh->vertex_count++, keys[v].p, sizeof keys[v].p);
        }
        map[keys[v].vertex] = (uint32_t)(mesh->vertex_count - 1);
    }
    for (size_t t = 0; t < triangle_count; t++) {
        const uint32_t a = map[indices[3 * t]], b = map[indices[3 * t + 1]],
                       c = map[indices[3 * t + 2]];
        if (a != b && b != c && c != a) {
            uint32_t *out = mesh->indices + 3 * mesh->triangle_count++;
            out[0] = a;
            out[1] = b;
            out[2] = c;
        }
    }

cleanup:
    air_free(work->context, map);
    air_free(work->context, keys);
    return status;
}

static void list_edges(mesh_work *work)
{
    const air_topology *mesh = &work->mesh;
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        const size_t t = i / 3, corner = i % 3;
        const uint32_t a = mesh->indices[i], b = mesh->indices[3 * t + (corner + 1) % 3];
        work->edges[i] =
            (half_edge){a < b ? a : b, a < b ? b : a, (uint32_t)t, (uint32_t)corner, a < b};
    }
    qsort(work->edges, 3 * mesh->triangle_count, sizeof *work->edges, compare_edges);
}

/* Every edge must belong to two triangles: makes them neighbours. */
static air_status pair_edges(mesh_work *work)
{
    const air_topology *mesh = &work->mesh;
    const size_t edge_count = 3 * mesh->triangle_count;
    const half_edge *worst = NULL;
    size_t open = 0, crowded = 0;
    for (size_t i = 0, end; i < edge_count; i = end) {
        const half_edge *a = &work->edges[i];
        for (end = i + 1; end < edge_count && work->edges[end].low == a->low &&
                          work->edges[end].high == a->high;) {
            end++;
        }
        if (end - i != 2) {
            open += end - i == 1;
            crowded += end - i > 2;
            worst = worst == NULL ? a : worst;
            continue;
        }
        const half_edge *b = a + 1;
        const uint32_t same = a->forward == b->forward;
        work->neighbours[3 * a->triangle + a->corner] = 2 * b->triangle + same;
        work->neighbours[3 * b->triangle + b->corner] = 2 * a->triangle + same;
    }
    if (worst == NULL) {
        return AIR_OK;
    }
    const float *p = mesh->positions + 3 * worst->low, *q = mesh->positions + 3 * worst->high;
    return air_subject_fail(work->subject,
                            "the boundary mesh is not closed: %zu open edges and %zu edges of more "
                            "than two triangles, one "
                            "from (%g, %g, %g) to (%g, %g, %g)",
                            open, crowded, (double)p[0], (double)p[1], (double)p[2], (double)q[0],
                            (double)q[1], (double)q[2]);
}

/* Gives the triangles connected to `first` to a component and turns them so that neighbours agree;
 * false if they cannot. */
static bool flood(mesh_work *work, uint32_t first, uint32_t owner)
{
    size_t depth = 0;
    bool consistent = true;
    work->owners[first] = owner;
    work->stack[depth++] = first;
    while (depth > 0) {
        const uint32_t t = work->stack[--depth];
        for (size_t corner = 0; corner < 3; corner++) {
            const uint32_t link = work->neighbours[3 * t + corner];
            const uint32_t other = link / 2;
            const bool flip = work->flips[t] != (link % 2 == 1);
            if (work->owners[other] == NO_TRIANGLE) {
                work->owners[other] = owner;
                work->flips[other] = flip;
                work->stack[depth++] = other;
            }
            consistent = consistent && work->flips[other] == flip;
        }
    }
    return consistent;
}

static air_status find_components(mesh_work *work)
{
    air_topology *mesh = &work->mesh;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        work->owners[t] = NO_TRIANGLE;
    }
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        if (work->owners[t] == NO_TRIANGLE && !flood(work, t, (uint32_t)mesh->component_count++)) {
            return air_subject_fail(work->subject,
                                    "the boundary mesh is one-sided, it has no inside");
        }
    }
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        if (work->flips[t]) {
            const uint32_t b = mesh->indices[3 * t + 1];
            mesh->indices[3 * t + 1] = mesh->indices[3 * t + 2];
            mesh->indices[3 * t + 2] = b;
        }
    }
    return AIR_OK;
}

/* The volume of the tetrahedron between a triangle and `from`. */
static double triangle_volume(const air_topology *mesh, size_t t, dvec3 from)
{
    const dvec3 a = sub(load(mesh->positions + 3 * mesh->indices[3 * t]), from);
    const dvec3 b = sub(load(mesh->positions + 3 * mesh->indices[3 * t + 1]), from);
    const dvec3 c = sub(load(mesh->positions + 3 * mesh->indices[3 * t + 2]), from);
    return dot(a, cross(b, c)) / 6.0;
}

static double triangle_area(const air_topology *mesh, size_t t)
{
    const dvec3 a = load(mesh->positions + 3 * mesh->indices[3 * t]);
    const dvec3 n = cross(sub(load(mesh->positions + 3 * mesh->indices[3 * t + 1]), a),
                          sub(load(mesh->positions + 3 * mesh->indices[3 * t + 2]), a));
    return 0.5 * sqrt(dot(n, n));
}

static void measure_components(mesh_work *work)
{
    const air_topology *mesh = &work->mesh;
    for (size_t c = 0; c < mesh->component_count; c++) {
        work->components[c] = (component){.low = {INFINITY, INFINITY, INFINITY},
                                          .high = {-INFINITY, -INFINITY, -INFINITY},
                                          .first = NO_TRIANGLE};
    }
    const dvec3 from = load(mesh->positions);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        component *part = &work->components[work->owners[t]];
        part->first = part->first == NO_TRIANGLE ? (uint32_t)t : part->first;
        part->volume += triangle_volume(mesh, t, from);
        for (size_t corner = 0; corner < 3; corner++) {
            const float *p = mesh->positions + 3 * mesh->indices[3 * t + corner];
            for (int k = 0; k < 3; k++) {
                part->low[k] = fminf(part->low[k], p[k]);
                part->high[k] = fmaxf(part->high[k], p[k]);
            }
        }
    }
}

/* Is p inside the component? By the winding number: the solid angle of its triangles over 4 pi,
 * each by [VanOosterom1983, eq. 8]. */
static bool component_contains(const mesh_work *work, uint32_t c, const float *p)
{
    const air_topology *mesh = &work->mesh;
    const component *part = &work->components[c];
    for (int k = 0; k < 3; k++) {
        if (!(p[k] >= part->low[k] && p[k] <= part->high[k])) {
            return false;
        }
    }
    double half_angle = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        if (work->owners[t] != c) {
            continue;
        }
        const dvec3 from = load(p);
        const dvec3 u = sub(load(mesh->positions + 3 * mesh->indices[3 * t]), from);
        const dvec3 v = sub(load(mesh->positions + 3 * mesh->indices[3 * t + 1]), from);
        const dvec3 w = sub(load(mesh->positions + 3 * mesh->indices[3 * t + 2]), from);
        const double lu = sqrt(dot(u, u)), lv = sqrt(dot(v, v)), lw = sqrt(dot(w, w));
        half_angle += atan2(dot(u, cross(v, w)),
                            lu * lv * lw + dot(u, v) * lw + dot(v, w) * lu + dot(w, u) * lv);
    }
    return fabs(half_angle) > AIR_PI; /* half of the full 2 pi */
}

/* A component that reaches out of another's bounds is not its cavity, wherever its corners lie. */
static bool lies_within(const component *inner, const component *outer)
{
    bool within = true;
    for (int k = 0; k < 3; k++) {
        within = within && inner->low[k] >= outer->low[k] && inner->high[k] <= outer->high[k];
    }
    return within;
}

/* Turns each component outwards, or inwards if it lies in an odd number of others. */
static void orient_components(mesh_work *work)
{
    air_topology *mesh = &work->mesh;
    for (uint32_t c = 0; c < mesh->component_count; c++) {
        component *part = &work->components[c];
        const float *p = mesh->positions + 3 * mesh->indices[3 * part->first];
        bool cavity = false;
        for (uint32_t other = 0; other < mesh->component_count; other++) {
            cavity = cavity != (other != c && lies_within(part, &work->components[other]) &&
                                component_contains(work, other, p));
        }
        part->flip = (part->volume < 0.0) != cavity;
        mesh->volume += cavity ? -fabs(part->volume) : fabs(part->volume);
    }
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        if (work->components[work->owners[t]].flip) {
            const uint32_t b = mesh->indices[3 * t + 1];
            mesh->indices[3 * t + 1] = mesh->indices[3 * t + 2];
            mesh->indices[3 * t + 2] = b;
        }
    }
}

/* The largest absolute coordinate and the diagonal of the bounds. */
static void measure_extent(const air_topology *mesh, double *out_largest, double *out_diagonal)
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double largest = 0.0, square = 0.0;
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        low[i % 3] = fminf(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmaxf(high[i % 3], mesh->positions[i]);
        largest = fmax(largest, fabs((double)mesh->positions[i]));
    }
    for (int k = 0; k < 3; k++) {
        square += ((double)high[k] - (double)low[k]) * ((double)high[k] - (double)low[k]);
    }
    *out_largest = largest;
    *out_diagonal = sqrt(square);
}

/* Volume over area is half the thickness of a slab: below the precision of positions there is
 * nothing inside. */
static air_status check_volume(const mesh_work *work)
{
    double area = 0.0, largest, diagonal;
    for (size_t t = 0; t < work->mesh.triangle_count; t++) {
        area += triangle_area(&work->mesh, t);
    }
    measure_extent(&work->mesh, &largest, &diagonal);
    if (!(work->mesh.volume > 1e-7 * area * largest)) {
        return air_subject_fail(work->subject, "the boundary mesh encloses no volume");
    }
    return AIR_OK;
}

static air_status allocate_work(mesh_work *work)
{
    const size_t count = work->mesh.triangle_count;
    if (count < 4) {
        return air_subject_fail(work->subject,
                                "the boundary mesh has %zu triangles of three different corners, a "
                                "closed one has 4 or more",
                                count);
    }
    work->edges = air_allocate(work->context, 3 * count, sizeof *work->edges);
    work->neighbours = air_allocate(work->context, 3 * count, sizeof *work->neighbours);
    work->owners = air_allocate(work->context, count, sizeof *work->owners);
    work->flips = air_allocate(work->context, count, sizeof *work->flips);
    work->stack = air_allocate(work->context, count, sizeof *work->stack);
    if (work->edges == NULL || work->neighbours == NULL || work->owners == NULL ||
        work->flips == NULL || work->stack == NULL) {
        return air_fail_memory(work->context, "boundary mesh");
    }
    return AIR_OK;
}

static air_status analyse(mesh_work *work)
{
    air_status status = allocate_work(work);
    if (status != AIR_OK) {
        return status;
    }
    list_edges(work);
    status = pair_edges(work);
    if (status == AIR_OK) {
        status = find_components(work);
    }
    if (status != AIR_OK) {
        return status;
    }
    work->components =
        air_allocate(work->context, work->mesh.component_count, sizeof *work->components);
    if (work->components == NULL) {
        return air_fail_memory(work->context, "boundary mesh");
    }
    measure_components(work);
    orient_components(work);
    return check_volume(work);
}

air_status air_topology_make(const air_subject *subject, const float *positions,
                             size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                             air_topology *out)
{
    air_context *context = subject->context;
    mesh_work work = {.subject = subject, .context = context};
    air_status status = check_input(&work, positions, vertex_count, indices, triangle_count);
    if (status == AIR_OK) {
        status = weld(&work, positions, vertex_count, indices, triangle_count);
    }
    if (status == AIR_OK) {
        status = analyse(&work);
    }
    if (status == AIR_OK) {
        *out = work.mesh;
    } else {
        air_topology_finish(context, &work.mesh);
    }
    air_free(context, work.components);
    air_free(context, work.stack);
    air_free(context, work.flips);
    air_free(context, work.owners);
    air_free(context, work.neighbours);
    air_free(context, work.edges);
    return status;
}

air_status air_topology_is_closed(air_context *context, const float *positions, size_t vertex_count,
                                  const uint32_t *indices, size_t triangle_count, bool *out_closed)
{
    mesh_work work = {.context = context};
    air_status status = weld(&work, positions, vertex_count, indices, triangle_count);
    const size_t edge_count = 3 * work.mesh.triangle_count;
    if (status == AIR_OK) {
        work.edges = air_allocate(context, edge_count, sizeof *work.edges);
        status = work.edges == NULL ? air_fail_memory(context, "boundary mesh") : AIR_OK;
    }
    if (status == AIR_OK) {
        list_edges(&work);
        *out_closed = edge_count > 0 && edge_count % 2 == 0;
        for (size_t i = 0; i < edge_count && *out_closed; i += 2) {
            const half_edge *a = &work.edges[i], *b = a + 1;
            *out_closed = a->low == b->low && a->high == b->high &&
                          (i == 0 || a[-1].low != a->low || a[-1].high != a->high);
        }
    }
    air_free(context, work.edges);
    air_topology_finish(context, &work.mesh);
    return status;
}

void air_topology_finish(air_context *context, air_topology *topology)
{
    air_free(context, topology->indices);
    air_free(context, topology->positions);
    *topology = (air_topology){0};
}

/* Triangles by falling area: planes are taken from large ones, whose normals are well determined.
 */
typedef struct face_key {
    double area;
    uint32_t triangle;
} face_key;

static int compare_faces(const void *a, const void *b)
{
    const face_key *fa = a, *fb = b;
    if (fa->area != fb->area) {
        return fa->area > fb->area ? -1 : 1;
    }
    return fa->triangle < fb->triangle ? -1 : fa->triangle > fb->triangle;
}

static double plane_distance(const air_plane *plane, const float *p)
{
    return (double)plane->n.x * (double)p[0] + (double)plane->n.y * (double)p[1] +
           (double)plane->n.z * (double)p[2] - (double)plane->h;
}

static air_plane triangle_plane(const air_topology *mesh, size_t t)
{
    const dvec3 a = load(mesh->positions + 3 * mesh->indices[3 * t]);
    const dvec3 b = load(mesh->positions + 3 * mesh->indices[3 * t + 1]);
    const dvec3 c = load(mesh->positions + 3 * mesh->indices[3 * t + 2]);
    const dvec3 n = cross(sub(b, a), sub(c, a));
    const double scale = 1.0 / sqrt(dot(n, n));
    const dvec3 sum = {a.x + b.x + c.x, a.y + b.y + c.y, a.z + b.z + c.z};
    return (air_plane){vec3((float)(n.x * scale), (float)(n.y * scale), (float)(n.z * scale)),
                       (float)(dot(n, sum) * scale / 3.0)};
}

/* Do the triangle's corners lie on one of the planes? */
static bool on_known_plane(const air_topology *mesh, size_t t, const air_plane *planes,
                           size_t count, double tolerance)
{
    for (size_t i = 0; i < count; i++) {
        bool on = true;
        for (size_t corner = 0; corner < 3; corner++) {
            on = on && fabs(plane_distance(&planes[i],
                                           mesh->positions + 3 * mesh->indices[3 * t + corner])) <=
                           tolerance;
        }
        if (on) {
            return true;
        }
    }
    return false;
}

static bool all_behind(const air_topology *mesh, const air_plane *plane, double tolerance)
{
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        if (plane_distance(plane, mesh->positions + 3 * v) > tolerance) {
            return false;
        }
    }
    return true;
}

air_status air_topology_convex_planes(air_context *context, const air_topology *topology,
                                      air_plane out_planes[AIR_MAX_PLANES], size_t *out_count)
{
    *out_count = 0;
    if (topology->component_count != 1) {
        return AIR_OK;
    }
    face_key *faces = air_allocate(context, topology->triangle_count, sizeof *faces);
    if (faces == NULL) {
        return air_fail_memory(context, "boundary mesh");
    }
    for (size_t t = 0; t < topology->triangle_count; t++) {
        faces[t] = (face_key){triangle_area(topology, t), (uint32_t)t};
    }
    qsort(faces, topology->triangle_count, sizeof *faces, compare_faces);
    double largest, diagonal;
    measure_extent(topology, &largest, &diagonal);
    /* positions and planes are rounded to 2^-24 of the largest coordinate; a few of these add up */
    const double tolerance = 4e-7 * largest + 1e-6 * diagonal;
    size_t count = 0;
    bool convex = true;
    for (size_t i = 0; i < topology->triangle_count && convex; i++) {
        const size_t t = faces[i].triangle;
        if (on_known_plane(topology, t, out_planes, count, tolerance)) {
            continue;
        }
        convex = count < AIR_MAX_PLANES && faces[i].area > 0.0;
        if (convex) {
            out_planes[count] = triangle_plane(topology, t);
            convex = all_behind(topology, &out_planes[count++], tolerance);
        }
    }
    *out_count = convex ? count : 0;
    air_free(context, faces);
    return AIR_OK;
}
