/* graded.h: Gauss panels that become smaller towards an end, where an integrand is not smooth. */
#ifndef AIR_IMPULSE_GRADED_H
#define AIR_IMPULSE_GRADED_H

#include "core/quadrature.h"

enum { GRADED_NODES_MAX = 16 };

/* A Gauss rule on [0, 1]. */
typedef struct graded_rule {
    int nodes;
    double x[GRADED_NODES_MAX], w[GRADED_NODES_MAX];
} graded_rule;

static inline graded_rule graded_rule_make(int nodes)
{
    graded_rule rule = {.nodes = nodes};
    air_gauss_legendre((size_t)nodes, rule.x, rule.w);
    for (int i = 0; i < nodes; i++) {
        rule.x[i] = 0.5 * (1.0 + rule.x[i]);
        rule.w[i] *= 0.5;
    }
    return rule;
}

enum { GRADED_LIST_MAX = 1536 };

/* Nodes and weights of many panels. */
typedef struct graded_list {
    int count;
    double x[GRADED_LIST_MAX], w[GRADED_LIST_MAX];
} graded_list;

/* [a, b] as one panel; what does not fit any more is left out (lists are sized by their makers). */
static inline void graded_panel(graded_list *list, const graded_rule *rule, double a, double b)
{
    for (int i = 0; i < rule->nodes && list->count < GRADED_LIST_MAX; i++, list->count++) {
        list->x[list->count] = a + (b - a) * rule->x[i];
        list->w[list->count] = (b - a) * rule->w[i];
    }
}

/* [from, to], halved `levels` times towards `from`; to < from is legal. */
static inline void graded_towards(graded_list *list, const graded_rule *rule, double from,
                                  double to, int levels)
{
    double scale = to - from;
    for (int i = 0; i < levels; i++, scale *= 0.5) {
        graded_panel(list, rule, from + 0.5 * scale, from + scale);
    }
    graded_panel(list, rule, from, from + scale);
}

/* The same towards both ends. Weights are positive: the integral from the smaller to the larger. */
static inline void graded_both(graded_list *list, const graded_rule *rule, double a, double b,
                               int levels_a, int levels_b)
{
    const int start = list->count;
    const double middle = 0.5 * (a + b);
    graded_towards(list, rule, a, middle, levels_a);
    graded_towards(list, rule, b, middle, levels_b);
    for (int i = start; i < list->count; i++) {
        list->w[i] = list->w[i] < 0.0 ? -list->w[i] : list->w[i];
    }
}

#endif
