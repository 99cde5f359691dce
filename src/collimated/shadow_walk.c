/* shadow_walk.c: the plain walk of a ray through the cells of a shadow tree, in order. The truth
 * that the packets repeat. */
#include "collimated/shadow_tree.h"

/* ---- a triangle ---- */

/* A triangle's corner as the ray's own plane (through it and the light) sees it. */
typedef struct corner {
    float side;   /* S: of the plane, times distance */
    float along;  /* R: distance along the ray's projection */
    float above;  /* D: distance above the ray within the plane, perpendicular to it */
    float height; /* Z */
} corner;

static corner see_corner(const shadow_triangle *triangle, int k, const shadow_ray *ray)
{
    const float x = triangle->x[k] - ray->x, y = triangle->y[k] - ray->y;
    const float z = triangle->z[k] - ray->z;
    corner out;
    out.side = x * ray->wy - y * ray->wx;
    out.along = x * ray->wx + y * ray->wy;
    out.above = z * ray->s - out.along * ray->c;
    out.height = z;
    return out;
}

/* Where the edge between two corners on different sides meets the plane. Turned round, the edge
 * gives the same bits: two triangles have the same point on the edge they share. */
static corner meet_plane(const corner *a, const corner *b)
{
    const float d = b->side - a->side;
    return (corner){0.0f, (a->along * b->side - b->along * a->side) / d,
                    (a->above * b->side - b->above * a->side) / d,
                    (a->height * b->side - b->height * a->side) / d};
}

/* The parameter at which the ray is below (or above) a point of the plane at its own height. */
static float crossing(const corner *a, const corner *b, const shadow_ray *ray)
{
    const float f = a->above / (a->above - b->above);
    const float along = a->along + f * (b->along - a->along);
    const float height = a->height + f * (b->height - a->height);
    return ray->s < 0.1f ? along * ray->s + height * ray->c : along * ray->inverse_s;
}

static void test_triangle(const shadow_triangle *triangle, const shadow_ray *ray, float begin,
                          float end, shadow_list *list)
{
    corner c[3];
    for (int k = 0; k < 3; k++) {
        c[k] = see_corner(triangle, k, ray);
    }
    const bool side[3] = {c[0].side >= 0.0f, c[1].side >= 0.0f, c[2].side >= 0.0f};
    if (side[0] == side[1] && side[0] == side[2]) {
        return;
    }
    const int lone = side[0] == side[1] ? 2 : side[0] == side[2] ? 1 : 0;
    const corner *i = &c[lone], *j = &c[lone == 0 ? 1 : 0], *k = &c[lone == 2 ? 1 : 2];
    const corner p = meet_plane(i, j), q = meet_plane(i, k);
    if (!(p.above > 0.0f) && !(q.above > 0.0f)) {
        return;
    }
    const float t_cross = crossing(&p, &q, ray);
    const float t_p = p.above > 0.0f ? p.along * ray->inverse_s : t_cross;
    const float t_q = q.above > 0.0f ? q.along * ray->inverse_s : t_cross;
    const float low = t_p < t_q ? t_p : t_q, high = t_p < t_q ? t_q : t_p;
    const float t0 = low > begin ? low : begin, t1 = high < end ? high : end;
    if (t0 < t1) {
        shadow_list_add(list, t0, t1);
    }
}

/* ---- the walk ---- */

/* A part of the ray in a cell that waits for its turn. */
typedef struct shadow_visit {
    int32_t node;
    float begin, end;
    float x, y, half; /* of the cell, in coordinates in which the root is [0,1]^2: exact */
} shadow_visit;

static float height_at(const shadow_ray *ray, float t) { return ray->z + ray->c * t; }

static float lesser(float a, float b) { return a < b ? a : b; }

static float greater(float a, float b) { return a > b ? a : b; }

/* Puts child k on the stack if the ray passes it. */
static shadow_visit *push(const shadow_visit *parent, int32_t first, unsigned k, float begin,
                          float end, shadow_visit *top)
{
    const float quarter = 0.5f * parent->half;
    if (begin < end) {
        *top++ = (shadow_visit){first + (int32_t)k,
                                begin,
                                end,
                                parent->x + ((k & 1u) != 0 ? quarter : -quarter),
                                parent->y + ((k & 2u) != 0 ? quarter : -quarter),
                                quarter};
    }
    return top;
}

/* The near child is visited first, the far one last; of the two at the sides no ray meets both.
 * Neighbours share the value of the parameter at which they meet. */
static shadow_visit *divide(const shadow_ray *ray, const shadow_visit *visit, int32_t first,
                            shadow_visit *top)
{
    const float tx = (visit->x - ray->qx) * ray->inverse_qx;
    const float ty = (visit->y - ray->qy) * ray->inverse_qy;
    const float after_x = greater(tx, visit->begin), before_x = lesser(tx, visit->end);
    const float after_y = greater(ty, visit->begin), before_y = lesser(ty, visit->end);
    const unsigned near = (ray->right ? 0u : 1u) | (ray->up ? 0u : 2u);
    top = push(visit, first, near ^ 3u, greater(after_x, ty), visit->end, top);
    top = push(visit, first, near ^ 2u, after_y, before_x, top);
    top = push(visit, first, near ^ 1u, after_x, before_y, top);
    return push(visit, first, near, visit->begin, lesser(before_x, ty), top);
}

/* A leaf decides between its two heights by its triangles; below them all is shadow, above light.
 */
static void visit_leaf(const air_shadow_tree *tree, const shadow_node *node, const shadow_ray *ray,
                       float begin, float end, shadow_list *list)
{
    const float to_low = (node->low - ray->z) * ray->inverse_c;
    const float to_high = (node->high - ray->z) * ray->inverse_c;
    const bool rises = ray->c >= 0.0f;
    const float from = rises ? to_low : to_high, to = rises ? to_high : to_low;
    const float inner_begin = greater(begin, lesser(from, end));
    const float inner_end = lesser(end, greater(to, begin));
    if (rises && begin < inner_begin) {
        shadow_list_add(list, begin, inner_begin);
    }
    if (inner_begin < inner_end) {
        const shadow_triangle *triangles = tree->triangles + ~node->first;
        for (int32_t i = 0; i < node->triangle_count; i++) {
            test_triangle(&triangles[i], ray, inner_begin, inner_end, list);
        }
    }
    if (!rises && inner_end < end) {
        shadow_list_add(list, inner_end, end);
    }
}

static void walk_ray(const air_shadow_tree *tree, const shadow_ray *ray, shadow_list *list)
{
    shadow_visit stack[SHADOW_STACK];
    shadow_visit *top = stack;
    *top++ = (shadow_visit){0, ray->begin, ray->end, 0.5f, 0.5f, 0.5f};
    while (top > stack && !list->full) {
        const shadow_visit visit = *--top;
        const shadow_node *node = &tree->nodes[visit.node];
        const float z0 = height_at(ray, visit.begin), z1 = height_at(ray, visit.end);
        if (lesser(z0, z1) >= node->high) {
            continue;
        }
        if (greater(z0, z1) <= node->low) {
            shadow_list_add(list, visit.begin, visit.end);
        } else if (node->first >= 0) {
            top = divide(ray, &visit, node->first, top);
        } else {
            visit_leaf(tree, node, ray, visit.begin, visit.end, list);
        }
    }
}

void air_shadow_walk_c(const air_shadow_tree *tree, const shadow_ray *of, size_t count,
                       shadow_list *lists)
{
    for (size_t i = 0; i < count; i++) {
        walk_ray(tree, &of[i], &lists[i]);
    }
}
