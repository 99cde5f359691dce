/* seams.c: sides with equal positions are found in one table of all parts. */
#include "atlas/seams.h"

#include <math.h>

#include "atlas/edge_table.h"
#include "atlas/triangle.h"
#include "atlas/weld.h"
#include "core/triple.h"
#include "core/vec.h"

/* Of a side with very many triangles only so many are tried as a partner. */
enum { MOST_TRIED = 32 };

typedef struct seam_finder {
    air_context *context;
    const air_atlas_part *parts;
    size_t part_count;
    const float *const *normals;
    const uint32_t *pages;
    double least_cosine;
    /* all parts in one */
    float *positions;
    uint32_t *indices, *names, *part_of; /* part_of: per triangle */
    uint32_t *first_triangle, *first_vertex;
    size_t vertex_count, triangle_count;
    air_edge_table table;
    uint8_t *taken; /* per edge of the table */
    air_seam *seams;
    size_t count, capacity;
} seam_finder;

/* ---- one mesh of all parts ---- */

static air_status allocate_all(seam_finder *f)
{
    for (size_t p = 0; p < f->part_count; p++) {
        f->vertex_count += f->parts[p].vertex_count;
        f->triangle_count += f->parts[p].triangle_count;
    }
    if (f->vertex_count > UINT32_MAX || f->triangle_count > UINT32_MAX / 4) {
        return AIR_ERROR_MEMORY;
    }
    f->positions = air_allocate(f->context, f->vertex_count, 3 * sizeof *f->positions);
    f->indices = air_allocate(f->context, f->triangle_count, 3 * sizeof *f->indices);
    f->names = air_allocate(f->context, f->vertex_count, sizeof *f->names);
    f->part_of = air_allocate(f->context, f->triangle_count, sizeof *f->part_of);
    f->first_triangle = air_allocate(f->context, f->part_count, sizeof *f->first_triangle);
    f->first_vertex = air_allocate(f->context, f->part_count, sizeof *f->first_vertex);
    const bool good = f->positions != NULL && f->indices != NULL && f->names != NULL &&
                      f->part_of != NULL && f->first_triangle != NULL && f->first_vertex != NULL;
    return good ? AIR_OK : AIR_ERROR_MEMORY;
}

static void join_parts(seam_finder *f)
{
    size_t vertex = 0, triangle = 0;
    for (size_t p = 0; p < f->part_count; p++) {
        const air_atlas_part *part = &f->parts[p];
        f->first_vertex[p] = (uint32_t)vertex;
        f->first_triangle[p] = (uint32_t)triangle;
        for (size_t i = 0; i < 3 * part->vertex_count; i++) {
            f->positions[3 * vertex + i] = part->positions[i];
        }
        for (size_t t = 0; t < part->triangle_count; t++) {
            for (size_t k = 0; k < 3; k++) {
                f->indices[3 * (triangle + t) + k] = part->indices[3 * t + k] + (uint32_t)vertex;
            }
            f->part_of[triangle + t] = (uint32_t)p;
        }
        vertex += part->vertex_count;
        triangle += part->triangle_count;
    }
}

static air_status find_edges(seam_finder *f)
{
    const air_weld_keys keys = {f->positions, NULL, f->vertex_count};
    air_status status = air_weld(f->context, &keys, f->names);
    if (status == AIR_OK) {
        status = air_edge_table_init(f->context, f->names, f->vertex_count, f->indices,
                                     f->triangle_count, &f->table);
    }
    f->taken = status == AIR_OK ? air_allocate(f->context, f->table.count, 1) : NULL;
    return f->taken != NULL ? AIR_OK : AIR_ERROR_MEMORY;
}

/* ---- pairs ---- */

/* The corner (of all parts' vertices) at end 0 or 1 of an edge: the lower name first. */
static uint32_t corner_at(const seam_finder *f, const air_edge *edge, int end)
{
    const bool second = (end == 1) != edge->reversed;
    return f->indices[3 * (size_t)edge->triangle + (edge->corner + (second ? 1u : 0u)) % 3];
}

static bool triangle_normal(const seam_finder *f, size_t triangle, double out[3])
{
    return air_triangle_normal(f->positions, f->indices + 3 * triangle, out);
}

static bool within_angle(const seam_finder *f, const double a[3], const double b[3])
{
    return air_dot3(a, b) >= f->least_cosine * air_length3(a) * air_length3(b);
}

static const float *vertex_normal(const seam_finder *f, const air_edge *edge, int end)
{
    const uint32_t part = f->part_of[edge->triangle];
    if (f->normals == NULL || f->normals[part] == NULL) {
        return NULL;
    }
    const size_t v = corner_at(f, edge, end) - f->first_vertex[part];
    return f->normals[part] + 3 * v;
}

/* Do both sides face alike? */
static bool face_alike(const seam_finder *f, const air_edge *a, const air_edge *b)
{
    double n[2][3];
    if (!triangle_normal(f, a->triangle, n[0]) || !triangle_normal(f, b->triangle, n[1])) {
        return false;
    }
    if (vertex_normal(f, a, 0) == NULL || vertex_normal(f, b, 0) == NULL) {
        return within_angle(f, n[0], n[1]);
    }
    for (int end = 0; end < 2; end++) {
        const float *from[2] = {vertex_normal(f, a, end), vertex_normal(f, b, end)};
        for (int k = 0; k < 3; k++) {
            n[0][k] = (double)from[0][k];
            n[1][k] = (double)from[1][k];
        }
        if (!within_angle(f, n[0], n[1])) {
            return false;
        }
    }
    return true;
}

static void place_of(const seam_finder *f, const air_edge *edge, int end, float out[2])
{
    const uint32_t number = f->part_of[edge->triangle];
    const air_atlas_part *part = &f->parts[number];
    const size_t v = corner_at(f, edge, end) - f->first_vertex[number];
    for (int k = 0; k < 2; k++) {
        out[k] = (float)((double)part->uv[2 * v + (size_t)k] * part->size[k] + part->offset[k]);
    }
}

/* Are both sides one on the page, to a thousandth of a texel? */
static bool is_whole(const air_seam *seam)
{
    float most = 0.0f;
    for (int end = 0; end < 2; end++) {
        for (int k = 0; k < 2; k++) {
            most = float_max(most, fabsf(seam->place[0][end][k] - seam->place[1][end][k]));
        }
    }
    return seam->page[0] == seam->page[1] && most < 1e-3f;
}

static air_status add_pair(seam_finder *f, const air_edge *a, const air_edge *b)
{
    const air_edge *edges[2] = {a, b};
    air_seam seam;
    bool finite = true;
    for (int side = 0; side < 2; side++) {
        const uint32_t triangle = edges[side]->triangle;
        seam.triangle[side] = triangle;
        seam.page[side] = f->pages != NULL ? f->pages[f->part_of[triangle]] : 0;
        for (int end = 0; end < 2; end++) {
            place_of(f, edges[side], end, seam.place[side][end]);
            finite =
                finite && isfinite(seam.place[side][end][0]) && isfinite(seam.place[side][end][1]);
        }
    }
    if (!finite || is_whole(&seam)) {
        return AIR_OK;
    }
    if (f->count == f->capacity) {
        const size_t capacity = 2 * f->capacity + 64;
        air_seam *grown = air_reallocate(f->context, f->seams, capacity, sizeof *grown);
        if (grown == NULL) {
            return AIR_ERROR_MEMORY;
        }
        f->seams = grown;
        f->capacity = capacity;
    }
    f->seams[f->count++] = seam;
    return AIR_OK;
}

static air_status pair_run(seam_finder *f, size_t first, size_t end)
{
    for (size_t i = first; i < end; i++) {
        for (size_t k = i + 1; k < end && k <= i + MOST_TRIED && !f->taken[i]; k++) {
            const air_edge *a = &f->table.edges[i], *b = &f->table.edges[k];
            if (!f->taken[k] && a->triangle != b->triangle && face_alike(f, a, b)) {
                f->taken[i] = f->taken[k] = 1;
                const air_status status = add_pair(f, a, b);
                if (status != AIR_OK) {
                    return status;
                }
            }
        }
    }
    return AIR_OK;
}

static air_status pair_all(seam_finder *f)
{
    air_status status = AIR_OK;
    for (size_t first = 0; first < f->table.count && status == AIR_OK;) {
        const size_t end = air_edge_table_run(&f->table, first);
        status = pair_run(f, first, end);
        first = end;
    }
    return status;
}

/* ---- all of it ---- */

static void finish_finder(seam_finder *f)
{
    air_free(f->context, f->seams);
    air_free(f->context, f->taken);
    air_edge_table_finish(f->context, &f->table);
    air_free(f->context, f->first_vertex);
    air_free(f->context, f->first_triangle);
    air_free(f->context, f->part_of);
    air_free(f->context, f->names);
    air_free(f->context, f->indices);
    air_free(f->context, f->positions);
}

void air_seams_find_params_default(air_seams_find_params *params)
{
    *params = (air_seams_find_params){.angle_rad = 20.0 * AIR_PI / 180.0};
}

air_status air_seams_find(air_context *context, const air_atlas_part *parts, size_t part_count,
                          const float *const *normals, const uint32_t *pages,
                          const air_seams_find_params *params, air_seams *out_seams)
{
    seam_finder f = {.context = context,
                     .parts = parts,
                     .part_count = part_count,
                     .normals = normals,
                     .pages = pages,
                     .least_cosine = cos(params->angle_rad) - 1e-12};
    *out_seams = (air_seams){NULL, 0};
    if (!(params->angle_rad >= 0.0 && params->angle_rad <= 3.1416)) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "seams: angle %g: expected [0, pi]",
                        params->angle_rad);
    }
    for (size_t p = 0; p < part_count; p++) {
        if (parts[p].positions == NULL || parts[p].uv == NULL) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "seams: part %zu: expected positions and uv", p);
        }
    }
    air_status status = allocate_all(&f);
    if (status == AIR_OK) {
        join_parts(&f);
        status = find_edges(&f);
    }
    status = status == AIR_OK ? pair_all(&f) : status;
    if (status == AIR_OK) {
        *out_seams = (air_seams){f.seams, f.count};
        f.seams = NULL;
    }
    finish_finder(&f);
    return status == AIR_OK ? AIR_OK : air_fail_memory(context, "seams");
}

void air_seams_finish(air_context *context, air_seams *seams)
{
    air_free(context, seams->seams);
    *seams = (air_seams){NULL, 0};
}
