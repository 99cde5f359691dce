/* shadow_traverse.h: the way of a ray through the cells of a shadow tree, in order; included by one
 * file per instruction set, which brings its test of a block of triangles. */
#ifndef AIR_COLLIMATED_SHADOW_TRAVERSE_H
#define AIR_COLLIMATED_SHADOW_TRAVERSE_H

#include "collimated/shadow_tree.h"

/* Adds the shadows that a block's triangles throw on [begin, end] of the ray. */
typedef void shadow_test_block(const shadow_block *block, const shadow_ray *ray, float begin,
                               float end, shadow_list *list);

/* A part of the ray in a cell that waits for its turn. */
typedef struct shadow_visit {
    int32_t node;
    float begin, end;
    float x, y, half; /* of the cell, in coordinates in which the root is [0,1]^2: exact */
} shadow_visit;

static inline float shadow_height(const shadow_ray *ray, float t) { return ray->z + ray->c * t; }

/* Puts the parts of the ray in a cell's children on the stack, the first one on top. Neighbours
 * share the value of the parameter at which they meet. */
static inline shadow_visit *shadow_divide(const shadow_ray *ray, const shadow_visit *visit,
                                          int32_t first, shadow_visit *stack)
{
    const float tx = (visit->x - ray->qx) * ray->inverse_qx;
    const float ty = (visit->y - ray->qy) * ray->inverse_qy;
    const bool cut_x = tx > visit->begin && tx < visit->end;
    const bool cut_y = ty > visit->begin && ty < visit->end;
    /* on which side it ends: beyond the line, as seen along the ray, if it got there */
    unsigned k =
        (unsigned)((tx < visit->end) == ray->right) | (unsigned)((ty < visit->end) == ray->up) << 1;
    const float quarter = 0.5f * visit->half;
    float end = visit->end;
    /* from the end back, so that the first part comes last */
    float cuts[3];
    unsigned flips[2] = {0, 0};
    int count = 0;
    if (cut_x && cut_y) {
        const bool x_last = tx > ty;
        cuts[0] = x_last ? tx : ty;
        flips[0] = x_last ? 1u : 2u;
        cuts[1] = x_last ? ty : tx;
        flips[1] = x_last ? 2u : 1u;
        count = 2;
    } else if (cut_x || cut_y) {
        cuts[0] = cut_x ? tx : ty;
        flips[0] = cut_x ? 1u : 2u;
        count = 1;
    }
    cuts[count] = visit->begin;
    for (int i = 0; i <= count; i++) {
        if (cuts[i] < end) {
            *stack++ = (shadow_visit){first + (int32_t)k,
                                      cuts[i],
                                      end,
                                      visit->x + ((k & 1u) != 0 ? quarter : -quarter),
                                      visit->y + ((k & 2u) != 0 ? quarter : -quarter),
                                      quarter};
        }
        end = cuts[i];
        k ^= i < count ? flips[i] : 0u;
    }
    return stack;
}

/* A leaf decides between its two heights by its triangles; below them all is shadow, above light.
 */
static inline void shadow_visit_leaf(const air_shadow_tree *tree, const shadow_node *node,
                                     const shadow_ray *ray, float begin, float end,
                                     shadow_test_block *test, shadow_list *list)
{
    const float to_low = (node->low - ray->z) * ray->inverse_c;
    const float to_high = (node->high - ray->z) * ray->inverse_c;
    const bool rises = ray->c >= 0.0f;
    const float from = rises ? to_low : to_high, to = rises ? to_high : to_low;
    const float inner_begin = from > begin ? (from < end ? from : end) : begin;
    const float inner_end = to < end ? (to > begin ? to : begin) : end;
    if (rises && begin < inner_begin) {
        shadow_list_add(list, begin, inner_begin);
    }
    if (inner_begin < inner_end) {
        const shadow_block *blocks = tree->blocks + ~node->first;
        for (int32_t i = 0; i < node->block_count; i++) {
            test(&blocks[i], ray, inner_begin, inner_end, list);
        }
    }
    if (!rises && inner_end < end) {
        shadow_list_add(list, inner_end, end);
    }
}

static inline void shadow_traverse(const air_shadow_tree *tree, const shadow_ray *ray, float begin,
                                   float end, shadow_test_block *test, shadow_list *list)
{
    shadow_visit stack[SHADOW_STACK + 2];
    shadow_visit *top = stack;
    *top++ = (shadow_visit){0, begin, end, 0.5f, 0.5f, 0.5f};
    while (top > stack && !list->full) {
        const shadow_visit visit = *--top;
        const shadow_node *node = &tree->nodes[visit.node];
        const float z0 = shadow_height(ray, visit.begin), z1 = shadow_height(ray, visit.end);
        const float lower = z0 < z1 ? z0 : z1, upper = z0 < z1 ? z1 : z0;
        if (lower >= node->high) {
            continue;
        }
        if (upper <= node->low) {
            shadow_list_add(list, visit.begin, visit.end);
        } else if (node->first >= 0) {
            top = shadow_divide(ray, &visit, node->first, top);
        } else {
            shadow_visit_leaf(tree, node, ray, visit.begin, visit.end, test, list);
        }
    }
}

#endif
