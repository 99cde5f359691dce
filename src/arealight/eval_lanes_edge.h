/* eval_lanes_edge.h: S by edges, side by side: edge.h's formulas with the trigonometry taken
 * out.
 *
 * With d and s the cosine and sine of an edge's arc, everything is wanted times 2 cos(arc / 2):
 *     X = 2 cos(arc/2) r0 r1 exp(i Theta/2)
 *       = (1 + gamma^2) (1 + d) - 2 gamma (z0 + z1) + i D s,
 *     P = 2 gamma ((1 + gamma^2) (z0 + z1) - 2 gamma (1 + d) (1 - h^2)) / |X|,
 *     Q = 2 gamma D (z1 - z0) (1 + d) / (s |X|).
 * Two halvings of X's angle give tan(Theta / 8). At a node t = xi tan(Theta / 8), psi = 4 atan t,
 * with sigma = t^2 and Y = (1 + sigma) q the integrand times dpsi/dt is
 *     4 (D (1 + sigma) + 2 Y) / ((D (1 + sigma) + Y)^2 - gamma^2 Y^2),
 *     Y^2 = (A + P) (1 + sigma^2) + (2 A - 6 P) sigma + 4 Q t (1 - sigma),  A = 1 + gamma^2.
 * Near the peak z is 1 - |a - v|^2 / 2, and differences of numbers near 1 are written in those. */
#ifndef AIR_AREALIGHT_EVAL_LANES_EDGE_H
#define AIR_AREALIGHT_EVAL_LANES_EDGE_H

#include "arealight/eval_lanes_lamp.h"

/* A vertex. */
typedef struct eval_end {
    eval_vertex vertex;
    lanes drop; /* 1 - a.v, v unit */
    lanes up;   /* apex.v */
} eval_end;

/* An edge, as far as it has come. */
typedef struct eval_arc {
    lanes h, s, inverse_s, d;  /* sine and cosine of the arc */
    lanes one_plus, one_minus; /* 1 + d, 1 - d */
    lanes size;                /* D */
    lanes scale;               /* 1 / |X| */
    lanes_plane half;          /* X / |X|, then at half its angle */
    lanes_plane factor;        /* exp(i solid angle / 2) of the triangle under it, of any length */
    /* For the nodes; the integral is gain times their sum. */
    lanes gain, tangent2; /* h tan(Theta / 8), tan(Theta / 8)^2 */
    lanes even0, even1, odd;
} eval_arc;

/* In [-limit, limit] even if it is not a number, as on edges through the point. */
static inline lanes within(lanes x, lane_real limit)
{
    return lanes_min(lanes_max(x, lanes_all(-limit)), lanes_all(limit));
}

/* A quotient: divisions are put off until four nodes are together. */
typedef struct eval_quotient {
    lanes above, below;
} eval_quotient;

static inline eval_quotient quotient_sum(eval_quotient a, eval_quotient b)
{
    return (eval_quotient){lanes_madd(a.above, b.below, b.above * a.below), a.below * b.below};
}

/* The integrand at Y^2, not below what rounding may leave of (1 - gamma)^2. */
static inline eval_quotient node_value(const eval_lamp *lamp, lanes d, lanes y2)
{
    const lanes bounded = lanes_max(y2, lanes_all(lamp->rest));
    const lanes y = lanes_root(bounded);
    const lanes sum = d + y, part = lanes_all(lamp->gamma) * y;
    return (eval_quotient){sum + y, lanes_nmadd(part, part, sum * sum)};
}

static inline eval_quotient pair_value(const eval_lamp *lamp, const eval_arc *arc, int i)
{
    const lane_real node = lamp->node[i];
    const lanes one = lanes_all(1), sigma = lanes_all(node * node) * arc->tangent2;
    const lanes even = lanes_madd(arc->even0, lanes_madd(sigma, sigma, one), arc->even1 * sigma);
    const lanes odd = lanes_all(node) * (one - sigma) * arc->odd;
    const lanes d = lanes_madd(arc->size, sigma, arc->size);
    eval_quotient out =
        quotient_sum(node_value(lamp, d, even + odd), node_value(lamp, d, even - odd));
    out.above *= lanes_all(lamp->weight[i]);
    return out;
}

/* Four nodes at a time of all edges: edges side by side again. */
static inline lanes arcs_integral(const eval_lamp *lamp, const eval_arc *arcs, size_t count)
{
    lanes sum = lanes_all(0);
    for (int i = 0; i < lamp->pairs; i += 2) {
        const bool two = i + 1 < lamp->pairs;
        for (size_t e = 0; e < count; e++) {
            eval_quotient q = pair_value(lamp, &arcs[e], i);
            if (two) {
                q = quotient_sum(q, pair_value(lamp, &arcs[e], i + 1));
            }
            sum = lanes_madd(arcs[e].gain * q.above, lanes_inverse(q.below), sum);
        }
    }
    return sum;
}

/* The apex of the fan that sums the solid angle. A far lamp's is its centre: all triangles have one
 * sign. Near lamps take the foot of the point, from which no vertices are opposite. */
typedef struct eval_apex {
    lanes3 v; /* unit */
    lane_mask far;
    lanes far_scale, near_scale; /* of the triple products */
} eval_apex;

static inline eval_apex apex_of(const eval_lamp *lamp, const eval_group *group)
{
    const lanes one = lanes_all(1), square = lanes3_dot(group->to_centre, group->to_centre);
    const lanes inverse = lanes_inverse_root(lanes_bounded(square));
    const lanes sign = lanes_select(group->below, lanes_all(-1), one);
    const lane_mask far = lanes_less(lanes_all(lamp->near_square), square);
    const lanes3 c = group->to_centre;
    return (eval_apex){{lanes_select(far, c.x * inverse, sign * lanes_all(lamp->normal[0])),
                        lanes_select(far, c.y * inverse, sign * lanes_all(lamp->normal[1])),
                        lanes_select(far, c.z * inverse, sign * lanes_all(lamp->normal[2]))},
                       far,
                       inverse,
                       sign};
}

static inline eval_end end_at(const eval_lamp *lamp, const eval_group *group, const eval_apex *apex,
                              size_t i)
{
    const eval_vertex vertex = vertex_at(lamp, group, i);
    const lanes back = lanes_all(0) - vertex.inverse;
    const lanes3 apart = lanes3_along(group->axis, back, vertex.v);
    return (eval_end){vertex, lanes_all((lane_real)0.5) * lanes3_dot(apart, apart),
                      lanes3_dot(apex->v, vertex.v) * vertex.inverse};
}

/* Edge i from a to b: its arc and its triangle. */
static inline void arc_begin(const eval_lamp *lamp, const eval_group *group, const eval_apex *apex,
                             const eval_end *a, const eval_end *b, size_t i, eval_arc *out)
{
    const eval_vertex *u = &a->vertex, *v = &b->vertex;
    const lanes inverses = u->inverse * v->inverse;
    const lanes lengths = (u->square * u->inverse) * (v->square * v->inverse);
    const lanes3 cross = lanes3_cross(u->v, lanes3_all(lamp->edge[i]));
    const lanes square = lanes3_dot(cross, cross);
    const lanes inverse = lanes_inverse_root(lanes_bounded(square));
    out->h = lanes3_dot(group->axis, cross) * inverse;
    out->s = square * inverse * inverses;
    out->inverse_s = lengths * inverse;
    out->d = lanes3_dot(u->v, v->v) * inverses;
    const lanes far = apex->far_scale * lanes3_dot(u->v, lanes3_all(lamp->spoke[i]));
    const lanes near = apex->near_scale * lanes3_dot(lanes3_all(lamp->normal), cross);
    out->factor.x = a->up + b->up;
    out->factor.y = lanes_select(apex->far, far, near) * inverses;
}

/* 1 + d and 1 - d, the one that cancels from s^2 = (1 + d)(1 - d); D. */
static inline void arc_sizes(const eval_lamp *lamp, eval_arc *e)
{
    const lane_mask behind = lanes_less(e->d, lanes_all(0));
    const lanes larger = lanes_all(1) + lanes_abs(e->d);
    const lanes smaller = e->s * e->s * lanes_inverse(larger);
    e->one_plus = lanes_select(behind, smaller, larger);
    e->one_minus = lanes_select(behind, larger, smaller);
    e->factor.x += e->one_plus;
    e->size = lanes_root(
        lanes_madd(lanes_all(lamp->four_gamma2), e->h * e->h, lanes_all(lamp->all_rest)));
}

static inline void arc_range(const eval_lamp *lamp, const eval_end *a, const eval_end *b,
                             eval_arc *e)
{
    const lanes apart = a->drop + b->drop - e->one_minus;
    const lanes x =
        lanes_madd(lanes_all(lamp->two_gamma), apart, lanes_all(lamp->rest) * e->one_plus);
    const lanes y = e->size * e->s;
    e->scale = lanes_inverse_root(lanes_bounded(lanes_madd(x, x, y * y)));
    e->half = (lanes_plane){x * e->scale, y * e->scale};
}

static inline void arc_finish(const eval_lamp *lamp, const eval_end *a, const eval_end *b,
                              eval_arc *e)
{
    const lane_real two_g = lamp->two_gamma;
    const lanes mean = lanes_all(lamp->mean), scale = lanes_all(two_g) * e->scale;
    const lanes tangent = plane_half_tangent(e->half);
    const lanes least = lanes_madd(e->one_plus, e->h * e->h, e->one_minus);
    const lanes along = lanes_nmadd(mean, a->drop + b->drop,
                                    lanes_madd(lanes_all(two_g), least, lanes_all(lamp->rest2)));
    const lanes across = e->size * (a->drop - b->drop) * e->one_plus * e->inverse_s;
    const lanes p = within(scale * along, two_g), q = within(scale * across, two_g);
    e->gain = e->h * tangent;
    e->tangent2 = tangent * tangent;
    e->even0 = mean + p;
    e->even1 = lanes_madd(lanes_all(-6), p, mean + mean);
    e->odd = lanes_all(4) * tangent * q;
}

/* One edge is a long chain of dependent steps; all of them, stage by stage, keep the processor
 * busy. */
static inline void arcs_make(const eval_lamp *lamp, const eval_group *group, const eval_apex *apex,
                             size_t count, eval_arc *arcs)
{
    eval_end ends[AIR_AREA_MAX_VERTICES + 1];
    for (size_t i = 0; i < count; i++) {
        ends[i] = end_at(lamp, group, apex, i);
    }
    ends[count] = ends[0];
    for (size_t i = 0; i < count; i++) {
        arc_begin(lamp, group, apex, &ends[i], &ends[i + 1], i, &arcs[i]);
    }
    for (size_t i = 0; i < count; i++) {
        arc_sizes(lamp, &arcs[i]);
    }
    for (size_t i = 0; i < count; i++) {
        arc_range(lamp, &ends[i], &ends[i + 1], &arcs[i]);
    }
    for (size_t i = 0; i < count; i++) {
        arcs[i].half = plane_half(arcs[i].half);
    }
    for (size_t i = 0; i < count; i++) {
        arc_finish(lamp, &ends[i], &ends[i + 1], &arcs[i]);
    }
}

/* Small lamps: edges nearly cancel, and with rounding e the sum's relative error is about
 *     e r^3 / ((1 - gamma^2) angle);
 * the phase function at the centre times the solid angle is off by less than 3 (angle / r)^2. Below
 * lamp->small_square, where both are alike, the latter is taken. half: half the solid angle. */
static inline lanes small_or(const eval_lamp *lamp, const eval_group *group, lanes half, lanes sum)
{
    const lane_real g = lamp->gamma;
    const lanes square = lanes3_dot(group->to_centre, group->to_centre);
    const lanes back = lanes_all(0) - lanes_inverse_root(lanes_bounded(square));
    const lanes3 apart = lanes3_along(group->axis, back, group->to_centre);
    const lanes r2 = lanes_madd(lanes_all(g), lanes3_dot(apart, apart), lanes_all(lamp->rest));
    const lanes inverse = lanes_inverse_root(r2);
    const lanes small = lanes_all(1 - g * g) * half * inverse * (inverse * inverse);
    return lanes_select(lanes_less(lanes_all(lamp->small_square), r2 * square), small, sum);
}

static inline lanes edges_integral(const eval_lamp *lamp, const eval_group *group, size_t count)
{
    const eval_apex apex = apex_of(lamp, group);
    eval_arc arcs[AIR_AREA_MAX_VERTICES];
    arcs_make(lamp, group, &apex, count, arcs);
    lanes_plane turn = {lanes_all(1), lanes_all(0)};
    for (size_t i = 0; i < count; i++) {
        turn = plane_product(turn, arcs[i].factor);
    }
    const lane_mask clockwise = lanes_less(turn.y, lanes_all(0));
    const lanes angle = plane_angle(plane_unit((lanes_plane){turn.x, lanes_abs(turn.y)}));
    const lanes whole = lanes_all(4 * lamp->gamma) * arcs_integral(lamp, arcs, count);
    const lanes all = lanes_abs(lanes_select(clockwise, whole - angle, whole + angle));
    return small_or(lamp, group, angle, all) *
           lanes_all((lane_real)0.15915494309189533577); /* 1 / (2 pi) */
}

#endif
