/* shadow_walk.c: the plain version: one triangle at a time. The truth that the others repeat. */
#include "collimated/shadow_traverse.h"

/* A triangle's corner as the ray's own plane (through it and the light) sees it. */
typedef struct corner {
    float side;   /* S: of the plane, times distance */
    float along;  /* R: distance along the ray's projection */
    float above;  /* D: distance above the ray within the plane, perpendicular to it */
    float height; /* Z */
} corner;

static corner see_corner(const shadow_block *block, size_t lane, int k, const shadow_ray *ray)
{
    const float x = block->x[k][lane] - ray->x, y = block->y[k][lane] - ray->y;
    const float z = block->z[k][lane] - ray->z;
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

static void test_triangle(const corner c[3], const shadow_ray *ray, float begin, float end,
                          shadow_list *list)
{
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

static void test_block(const shadow_block *block, const shadow_ray *ray, float begin, float end,
                       shadow_list *list)
{
    for (size_t lane = 0; lane < SHADOW_LANES; lane++) {
        corner c[3];
        for (int k = 0; k < 3; k++) {
            c[k] = see_corner(block, lane, k, ray);
        }
        test_triangle(c, ray, begin, end, list);
    }
}

void air_shadow_walk_c(const air_shadow_tree *tree, const shadow_ray *ray, float begin, float end,
                       shadow_list *list)
{
    shadow_traverse(tree, ray, begin, end, test_block, list);
}
