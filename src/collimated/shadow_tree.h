/* shadow_tree.h: what a shadow tree is made of; shared by its build and its walks.
 *
 * Light space has its origin at the hull's centre and the axes e1, e2 and l (to the light); x and y
 * place a point in the plane perpendicular to the light, z is its height. */
#ifndef AIR_COLLIMATED_SHADOW_TREE_H
#define AIR_COLLIMATED_SHADOW_TREE_H

#include "airlight/shadow.h"

enum {
    SHADOW_DEPTH_MAX = 16,                  /* levels below the root */
    SHADOW_STACK = 3 * SHADOW_DEPTH_MAX + 4 /* three of a cell's four parts can wait */
};

/* A cell of the quadtree: points of it below low are in shadow, points at or above high are lit,
 * between them the triangles of its leaf decide. Four siblings share a cache line; sibling k is the
 * right half for k & 1, the upper one for k & 2. */
typedef struct shadow_node {
    float low, high;
    int32_t first;          /* of four children, or ~(index of a leaf's first triangle) */
    int32_t triangle_count; /* of a leaf; may be 0 */
} shadow_node;

/* Corners, in light space. */
typedef struct shadow_triangle {
    float x[3], y[3], z[3];
} shadow_triangle;

typedef struct shadow_frame {
    double axes[3][3]; /* e1, e2, l */
    double centre[3];  /* of the hull, world space */
    double half[2];    /* the hull's projection lies in |x| <= half[0], |y| <= half[1] */
    double side;       /* of the square, centred at 0, that the root covers */
    double floor;      /* no point of the hull is lower */
    double pad;        /* cells are widened by it: more than the rounding of a ray in floats */
} shadow_frame;

/* A ray in light space, its parameter measured from the point nearest to the hull's centre, where
 * floats are densest. */
typedef struct shadow_ray {
    float x, y, z;   /* that point */
    float wx, wy;    /* unit vector along the ray in the plane across the light */
    float s, c;      /* the ray's direction is s (wx, wy) + c l */
    float inverse_s; /* inverses are clamped to 1e20 */
    float inverse_c;
    float qx, qy;                 /* the point in coordinates in which the root is [0,1]^2 */
    float inverse_qx, inverse_qy; /* parameter per unit of them */
    bool right, up;               /* of the ray's way through the plane */
    float begin, end;             /* the stretch that is asked for */
} shadow_ray;

/* The shadows found along one ray: sorted, disjoint, with ends that are floats. */
typedef struct shadow_list {
    air_interval *intervals;
    size_t count, capacity;
    bool full; /* it did not hold all */
} shadow_list;

/* Finds the shadows of ray of[i], i < count: lists[i]. */
typedef void shadow_walk(const air_shadow_tree *tree, const shadow_ray *of, size_t count,
                         shadow_list *lists);

struct air_shadow_tree {
    air_context *context;
    shadow_walk *walk;
    shadow_frame frame;
    shadow_node *nodes; /* [0] is the root, [1] to [3] are unused */
    size_t node_count;
    shadow_triangle *triangles; /* of the leaves */
    size_t triangle_count;
};

/* Inserts [begin, end] into the list. */
void air_shadow_list_insert(shadow_list *list, float begin, float end);

static inline void shadow_list_add(shadow_list *list, float begin, float end)
{
    if (list->count > 0 && !list->full) { /* nearly always it touches or follows the last one */
        air_interval *last = &list->intervals[list->count - 1];
        if ((double)begin >= last->begin && (double)begin <= last->end) {
            last->end = (double)end > last->end ? (double)end : last->end;
            return;
        }
    }
    air_shadow_list_insert(list, begin, end);
}

/* One per instruction set, all with the same results to the bit. */
shadow_walk air_shadow_walk_c, air_shadow_walk_sse42, air_shadow_walk_avx2, air_shadow_walk_avx512;

#endif
