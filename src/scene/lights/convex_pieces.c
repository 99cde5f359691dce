/* convex_pieces.c: see convex_pieces.h. Pieces know their corners only: where two of them share a
 * side whole, the corners at its ends are all that joining them can change. */
#include "scene/lights/convex_pieces.h"

#include <stdlib.h>
#include <string.h>

#include "core/host.h"
#include "core/triple.h"
#include "scene/lights/polygon.h"

enum { MOST_CORNERS = AIR_AREA_MAX_VERTICES, MOST_PASSES = 64 };

/* Of the largest coordinate: what rounding moves a point by, sixteen halves of a float's last place
 * for itself, its neighbours, and a transform that they went through. */
static const double rounding = 0x1p-20;

typedef struct piece {
    uint32_t count; /* of its corners; 0: joined to another, or without area */
    uint32_t corners[MOST_CORNERS];
    uint32_t heir; /* the piece it was joined to; itself if to none */
} piece;

/* A side of a piece from point `low` to point `high`, or back. */
typedef struct side {
    uint32_t low, high, piece;
    bool back;
} side;

/* A side that two pieces share: of the left one from `from` to `to`. */
typedef struct joint {
    double rank; /* small ones first */
    uint32_t from, to, left, right;
} joint;

/* Around two pieces. */
typedef struct ring {
    size_t count;
    uint32_t corners[2 * MOST_CORNERS];
} ring;

typedef struct work {
    const double (*points)[3]; /* the vertices as given */
    size_t triangle_count;
    piece *pieces; /* by triangle */
    side *sides;
    joint *joints;
    size_t side_count, joint_count;
} work;

/* ---- triangles ---- */

typedef struct place {
    double position[3];
    uint32_t vertex;
} place;

static int compare_numbers(double a, double b) { return (a > b) - (a < b); }

static int compare_indices(uint32_t a, uint32_t b) { return (a > b) - (a < b); }

static int compare_positions(const place *a, const place *b)
{
    for (int k = 0; k < 3; k++) {
        const int order = compare_numbers(a->position[k], b->position[k]);
        if (order != 0) {
            return order;
        }
    }
    return 0;
}

static int compare_places(const void *a, const void *b)
{
    const place *p = a, *q = b;
    const int order = compare_positions(p, q);
    return order != 0 ? order : compare_indices(p->vertex, q->vertex);
}

/* A piece of each triangle. Equal vertices are one point, the first of them. */
static air_status make_triangles(air_context *context, work *w)
{
    const size_t count = 3 * w->triangle_count;
    place *places = air_allocate(context, count, sizeof *places);
    if (places == NULL) {
        return air_fail_memory(context, "convex pieces");
    }
    for (size_t i = 0; i < count; i++) {
        air_copy3(w->points[i], places[i].position);
        places[i].vertex = (uint32_t)i;
    }
    qsort(places, count, sizeof *places, compare_places);
    uint32_t first = 0;
    for (size_t i = 0; i < count; i++) {
        const uint32_t vertex = places[i].vertex;
        first = i > 0 && compare_positions(&places[i - 1], &places[i]) == 0 ? first : vertex;
        w->pieces[vertex / 3].corners[vertex % 3] = first;
    }
    air_free(context, places);
    for (size_t i = 0; i < w->triangle_count; i++) {
        piece *p = &w->pieces[i];
        const uint32_t *c = p->corners;
        p->count = c[0] != c[1] && c[1] != c[2] && c[2] != c[0] ? 3 : 0;
        p->heir = (uint32_t)i;
    }
    return AIR_OK;
}

/* ---- rings ---- */

typedef struct ring_plane {
    double center[3], normal[3];
    double area, extent, magnitude;
} ring_plane;

static void add_spoke(const double first[3], const double a[3], const double b[3], double sum[3])
{
    double to_a[3], to_b[3], cross[3];
    air_subtract3(a, first, to_a);
    air_subtract3(b, first, to_b);
    air_cross3(to_a, to_b, cross);
    air_along3(sum, 0.5, cross, sum);
}

/* The plane through the middle of points. False if they enclose no area but rounding. */
static bool fit(const work *w, const uint32_t *corners, size_t count, ring_plane *out)
{
    double sum[3] = {0.0, 0.0, 0.0};
    *out = (ring_plane){.area = 0.0};
    for (size_t i = 0; i < count; i++) {
        const double *p = w->points[corners[i]];
        air_along3(out->center, 1.0 / (double)count, p, out->center);
        for (int k = 0; k < 3; k++) {
            out->magnitude = fmax(out->magnitude, fabs(p[k]));
        }
        add_spoke(w->points[corners[0]], p, w->points[corners[(i + 1) % count]], sum);
    }
    for (size_t i = 0; i < count; i++) {
        double way[3];
        air_subtract3(w->points[corners[i]], out->center, way);
        out->extent = fmax(out->extent, air_length3(way));
    }
    out->area = air_length3(sum);
    for (int k = 0; k < 3; k++) {
        out->normal[k] = sum[k] / out->area;
    }
    return !air_polygon_is_thin(out->area, out->extent, out->magnitude);
}

static double height(const ring_plane *plane, const double point[3])
{
    double way[3];
    air_subtract3(point, plane->center, way);
    return air_dot3(way, plane->normal);
}

static bool is_flat(const work *w, const ring *r, const ring_plane *plane)
{
    for (size_t i = 0; i < r->count; i++) {
        if (fabs(height(plane, w->points[r->corners[i]])) > rounding * plane->magnitude) {
            return false;
        }
    }
    return true;
}

typedef enum ring_turn { TURN_LEFT, TURN_NONE, TURN_WRONG } ring_turn;

static ring_turn turn_at(const work *w, const ring *r, const ring_plane *plane, size_t i)
{
    const double *before = w->points[r->corners[(i + r->count - 1) % r->count]];
    const double *at = w->points[r->corners[i]];
    const double *after = w->points[r->corners[(i + 1) % r->count]];
    double into[3], out_of[3], chord[3], cross[3];
    air_subtract3(at, before, into);
    air_subtract3(after, at, out_of);
    air_subtract3(after, before, chord);
    air_cross3(into, out_of, cross);
    const double left = air_dot3(cross, plane->normal);
    const double least = rounding * plane->magnitude * air_length3(chord);
    if (left > least) {
        return TURN_LEFT;
    }
    return left >= -least && air_dot3(into, out_of) > 0.0 ? TURN_NONE : TURN_WRONG;
}

/* Takes out the corners that do not turn. False if one turns right. */
static bool straighten(const work *w, const ring_plane *plane, ring *r)
{
    size_t at = 0, kept = 0;
    while (kept < r->count) {
        switch (turn_at(w, r, plane, at)) {
        case TURN_LEFT:
            at = (at + 1) % r->count;
            kept++;
            break;
        case TURN_NONE:
            r->count--;
            memmove(r->corners + at, r->corners + at + 1, (r->count - at) * sizeof *r->corners);
            at %= r->count;
            kept = 0; /* its neighbours turn otherwise now */
            break;
        case TURN_WRONG:
            return false;
        }
    }
    return r->count >= 3;
}

/* ---- joining ---- */

/* Where a piece has the side, or its count. */
static size_t find_side(const piece *p, uint32_t from, uint32_t to)
{
    size_t i = 0;
    while (i < p->count && !(p->corners[i] == from && p->corners[(i + 1) % p->count] == to)) {
        i++;
    }
    return i;
}

/* The ring around both. False if they do not share that side any more. */
static bool go_around(const piece *a, const piece *b, const joint *j, ring *out)
{
    const size_t of_a = find_side(a, j->from, j->to), of_b = find_side(b, j->to, j->from);
    if (of_a == a->count || of_b == b->count) {
        return false;
    }
    out->count = 0;
    for (size_t i = 0; i < a->count; i++) {
        out->corners[out->count++] = a->corners[(of_a + 1 + i) % a->count];
    }
    for (size_t i = 2; i < b->count; i++) {
        out->corners[out->count++] = b->corners[(of_b + i) % b->count];
    }
    return true;
}

static uint32_t find_heir(piece *pieces, uint32_t i)
{
    while (pieces[i].heir != i) {
        pieces[i].heir = pieces[pieces[i].heir].heir;
        i = pieces[i].heir;
    }
    return i;
}

static bool join(work *w, const joint *j)
{
    const uint32_t left = find_heir(w->pieces, j->left), right = find_heir(w->pieces, j->right);
    piece *first = &w->pieces[left < right ? left : right];
    piece *second = &w->pieces[left < right ? right : left];
    ring around;
    ring_plane plane;
    if (left == right || !go_around(&w->pieces[left], &w->pieces[right], j, &around) ||
        !fit(w, around.corners, around.count, &plane) || !is_flat(w, &around, &plane) ||
        !straighten(w, &plane, &around) || around.count > MOST_CORNERS) {
        return false;
    }
    first->count = (uint32_t)around.count;
    memcpy(first->corners, around.corners, around.count * sizeof *around.corners);
    second->count = 0;
    second->heir = first->heir;
    return true;
}

/* ---- what can be joined ---- */

static int compare_sides(const void *a, const void *b)
{
    const side *s = a, *t = b;
    int order = compare_indices(s->low, t->low);
    order = order != 0 ? order : compare_indices(s->high, t->high);
    order = order != 0 ? order : (int)s->back - (int)t->back;
    return order != 0 ? order : compare_indices(s->piece, t->piece);
}

static int compare_joints(const void *a, const void *b)
{
    const joint *j = a, *k = b;
    int order = compare_numbers(j->rank, k->rank);
    order = order != 0 ? order : compare_indices(j->left, k->left);
    return order != 0 ? order : compare_indices(j->from, k->from);
}

static void list_sides(work *w)
{
    w->side_count = 0;
    for (size_t i = 0; i < w->triangle_count; i++) {
        const piece *p = &w->pieces[i];
        for (size_t k = 0; k < p->count; k++) {
            const uint32_t from = p->corners[k], to = p->corners[(k + 1) % p->count];
            w->sides[w->side_count++] = (side){.low = from < to ? from : to,
                                               .high = from < to ? to : from,
                                               .piece = (uint32_t)i,
                                               .back = from > to};
        }
    }
    qsort(w->sides, w->side_count, sizeof *w->sides, compare_sides);
}

static double distance(const work *w, uint32_t a, uint32_t b)
{
    double way[3];
    air_subtract3(w->points[a], w->points[b], way);
    return air_length3(way);
}

static bool is_longest(const work *w, const piece *p, double length)
{
    for (size_t k = 0; k < p->count; k++) {
        if (distance(w, p->corners[k], p->corners[(k + 1) % p->count]) > length) {
            return false;
        }
    }
    return true;
}

/* Diagonals first, so that a grid gets its quadrilaterals back; then by direction, so that they
 * become rows and these one whole. Parallel sides have the same share of an axis that nothing is
 * likely to lie along. */
static double rank_of(const work *w, const joint *j)
{
    static const double axis[3] = {0.3906, 0.8207, 0.4172};
    double way[3];
    air_subtract3(w->points[j->to], w->points[j->from], way);
    const double length = air_length3(way);
    const bool diagonal =
        is_longest(w, &w->pieces[j->left], length) && is_longest(w, &w->pieces[j->right], length);
    return fabs(air_dot3(way, axis)) / length + (diagonal ? 0.0 : 2.0);
}

/* Pairs sides with those that run back; where more than two pieces meet, in the order of the
 * pieces. */
static void list_joints(work *w)
{
    w->joint_count = 0;
    for (size_t begin = 0, end; begin < w->side_count; begin = end) {
        const side *first = &w->sides[begin];
        size_t back = begin;
        for (end = begin; end < w->side_count && w->sides[end].low == first->low &&
                          w->sides[end].high == first->high;
             end++) {
            back += w->sides[end].back ? 0 : 1;
        }
        for (size_t i = begin, k = back; i < back && k < end; i++, k++) {
            joint *j = &w->joints[w->joint_count++];
            *j = (joint){.from = first->low,
                         .to = first->high,
                         .left = w->sides[i].piece,
                         .right = w->sides[k].piece};
            j->rank = rank_of(w, j);
        }
    }
    qsort(w->joints, w->joint_count, sizeof *w->joints, compare_joints);
}

/* Joined pieces have new sides, which the next pass finds. */
static void join_all(work *w)
{
    bool any = true;
    for (int pass = 0; any && pass < MOST_PASSES; pass++) {
        any = false;
        list_sides(w);
        list_joints(w);
        for (size_t i = 0; i < w->joint_count; i++) {
            any = join(w, &w->joints[i]) || any;
        }
    }
}

/* ---- the result ---- */

/* Corners in the plane that fits them. */
static void store(const work *w, const piece *p, const ring_plane *plane, air_convex_pieces *out)
{
    const size_t begin = out->count > 0 ? out->ends[out->count - 1] : 0;
    for (size_t k = 0; k < p->count; k++) {
        const double *point = w->points[p->corners[k]];
        air_along3(point, -height(plane, point), plane->normal, out->corners[begin + k]);
    }
    out->ends[out->count++] = begin + p->count;
}

static air_status store_all(air_context *context, const work *w, air_convex_pieces *out)
{
    size_t pieces = 0, corners = 0;
    for (size_t i = 0; i < w->triangle_count; i++) {
        pieces += w->pieces[i].count > 0 ? 1 : 0;
        corners += w->pieces[i].count;
    }
    out->ends = air_allocate(context, pieces, sizeof *out->ends);
    out->corners = air_allocate(context, corners, sizeof *out->corners);
    if (out->ends == NULL || out->corners == NULL) {
        air_convex_pieces_finish(context, out);
        return air_fail_memory(context, "convex pieces");
    }
    for (size_t i = 0; i < w->triangle_count; i++) {
        const piece *p = &w->pieces[i];
        ring_plane plane;
        if (p->count > 0 && fit(w, p->corners, p->count, &plane)) {
            store(w, p, &plane, out);
        }
    }
    return AIR_OK;
}

air_status air_convex_pieces_make(air_context *context, const double (*vertices)[3],
                                  size_t triangle_count, air_convex_pieces *out)
{
    *out = (air_convex_pieces){.count = 0};
    if (triangle_count > UINT32_MAX / 3) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "convex pieces: %zu triangles, must be at most %u", triangle_count,
                        UINT32_MAX / 3);
    }
    work w = {.points = vertices, .triangle_count = triangle_count};
    w.pieces = air_allocate(context, triangle_count, sizeof *w.pieces);
    w.sides = air_allocate(context, 3 * triangle_count, sizeof *w.sides);
    w.joints = air_allocate(context, 2 * triangle_count, sizeof *w.joints); /* two sides each */
    air_status status = w.pieces != NULL && w.sides != NULL && w.joints != NULL
                            ? make_triangles(context, &w)
                            : air_fail_memory(context, "convex pieces");
    if (status == AIR_OK) {
        join_all(&w);
        status = store_all(context, &w, out);
    }
    air_free(context, w.joints);
    air_free(context, w.sides);
    air_free(context, w.pieces);
    return status;
}

void air_convex_pieces_finish(air_context *context, air_convex_pieces *pieces)
{
    air_free(context, pieces->corners);
    air_free(context, pieces->ends);
    *pieces = (air_convex_pieces){.count = 0};
}
