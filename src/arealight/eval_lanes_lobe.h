/* eval_lanes_lobe.h: S by two lobes, side by side.
 *
 * The plane through the point across the axis cuts each edge in at most two parts, one for each
 * half; the parts and the stretch of the horizon between the two crossings bound the half's
 * polygon. Stretching by s along the axis leaves the axis' component t of v0 x v1 as it is and
 * divides the rest by s; it leaves crossings and horizon as they are. With theta the part's
 * stretched arc and beta half the stretched triangle of axis, v0 and v1,
 *     integral = |sum w theta t / |v0 x v1| + (1 - w) 2 beta +- horizon| / (2 pi),
 * since the horizon counts its length both in cosines and in solid angle. */
#ifndef AIR_AREALIGHT_EVAL_LANES_LOBE_H
#define AIR_AREALIGHT_EVAL_LANES_LOBE_H

#include "arealight/eval_lanes_lamp.h"

/* An edge and the point x at which it crosses the horizon, at `at` of its length, if it does.
 * Scalar products, and components along the axis. */
typedef struct eval_cut {
    lanes v00, v01, v11, v0x, vx1, vxx;
    lanes z0, z1, at;
    lanes axial, across; /* of v0 x v1: the part along the axis, the square of the rest */
    lane_mask near0, near1;
} eval_cut;

/* The part of an edge in one half. */
typedef struct eval_part {
    int half;         /* 0: around the peak, 1: the other */
    lane_mask there;  /* not in lanes whose edge is all in the other half */
    lanes_plane arc;  /* exp(i theta), then at half the angle, then a quarter */
    lanes_plane turn; /* exp(i beta), of any length */
    lanes slope;      /* t / |v0 x v1| */
} eval_part;

/* The crossings where the near half is left and entered, of any length. */
typedef struct eval_horizon {
    lanes3 leave, enter;
    lane_mask crossed;
} eval_horizon;

static inline lanes3 lanes3_select(lane_mask mask, lanes3 a, lanes3 b)
{
    return (lanes3){lanes_select(mask, a.x, b.x), lanes_select(mask, a.y, b.y),
                    lanes_select(mask, a.z, b.z)};
}

static inline eval_cut cut_edge(const eval_lamp *lamp, const eval_group *group,
                                const eval_vertex *a, const eval_vertex *b, lanes z0, lanes z1,
                                size_t i, eval_horizon *horizon)
{
    const lanes zero = lanes_all(0);
    const lanes3 edge = lanes3_all(lamp->edge[i]), cross = lanes3_cross(a->v, edge);
    const lane_mask near0 = lanes_less(zero, z0), near1 = lanes_less(zero, z1);
    const lane_mask leaves = mask_and_not(near0, near1), enters = mask_and_not(near1, near0);
    const lanes gap = lanes_select(mask_or(leaves, enters), z0 - z1, lanes_all(1));
    const lanes at = lanes_min(lanes_max(z0 / gap, zero), lanes_all(1));
    const lanes3 x = lanes3_along(a->v, at, edge);
    const lanes axial = lanes3_dot(group->axis, cross);
    horizon->leave = lanes3_select(leaves, x, horizon->leave);
    horizon->enter = lanes3_select(enters, x, horizon->enter);
    horizon->crossed = mask_or(horizon->crossed, leaves);
    return (eval_cut){a->square,
                      lanes3_dot(a->v, b->v),
                      b->square,
                      lanes3_dot(a->v, x),
                      lanes3_dot(x, b->v),
                      lanes3_dot(x, x),
                      z0,
                      z1,
                      at,
                      axial,
                      lanes_max(lanes_nmadd(axial, axial, lanes3_dot(cross, cross)), zero),
                      near0,
                      near1};
}

/* in0, in1: which ends are in the half; not both missing in all lanes. Components along the axis
 * count as positive: beta and t then both belong to the axis. */
static inline void part_make(const eval_cut *e, int half, lane_mask in0, lane_mask in1,
                             lanes inverse_s, eval_part *out)
{
    const lanes zero = lanes_all(0), one = lanes_all(1);
    const lane_mask both = mask_and(in0, in1);
    const lanes s2 = inverse_s * inverse_s, lift = s2 - one;
    const lanes z0 = lanes_select(in0, lanes_abs(e->z0), zero),
                z1 = lanes_select(in1, lanes_abs(e->z1), zero);
    const lanes aa = lanes_madd(lift * z0, z0, lanes_select(in0, e->v00, e->vxx));
    const lanes bb = lanes_madd(lift * z1, z1, lanes_select(in1, e->v11, e->vxx));
    const lanes ab =
        lanes_madd(lift * z0, z1, lanes_select(both, e->v01, lanes_select(in0, e->v0x, e->vx1)));
    const lanes share = lanes_select(both, one, lanes_select(in0, e->at, one - e->at));
    const lanes a = lanes_inverse_root(lanes_bounded(aa)),
                b = lanes_inverse_root(lanes_bounded(bb));
    const lanes inverses = a * b, square = lanes_madd(e->across, s2, e->axial * e->axial);
    const lanes size_inverse = lanes_inverse_root(lanes_bounded(square));
    out->half = half;
    out->there = mask_or(in0, in1);
    out->arc = (lanes_plane){ab * inverses, share * square * size_inverse * inverses};
    out->turn = (lanes_plane){one + out->arc.x + inverse_s * lanes_madd(z0, a, z1 * b),
                              share * e->axial * inverses};
    out->slope = e->axial * size_inverse;
}

/* Cuts all edges; returns how many parts there are, halves that no lane asks for left out. */
static inline size_t parts_make(const eval_lamp *lamp, const eval_group *group, size_t count,
                                eval_part *parts, eval_horizon *horizon)
{
    const lanes zero = lanes_all(0);
    const lane_mask all = lanes_equal(zero, zero);
    eval_vertex vertices[AIR_AREA_MAX_VERTICES + 1];
    lanes z[AIR_AREA_MAX_VERTICES + 1];
    size_t made = 0;
    for (size_t i = 0; i < count; i++) {
        vertices[i] = vertex_at(lamp, group, i);
        z[i] = lanes3_dot(group->axis, vertices[i].v);
    }
    vertices[count] = vertices[0];
    z[count] = z[0];
    for (size_t i = 0; i < count; i++) {
        const eval_cut e =
            cut_edge(lamp, group, &vertices[i], &vertices[i + 1], z[i], z[i + 1], i, horizon);
        const lane_mask far0 = mask_and_not(all, e.near0), far1 = mask_and_not(all, e.near1);
        if (mask_any(mask_or(e.near0, e.near1))) {
            part_make(&e, 0, e.near0, e.near1, lanes_all(lamp->inverse_s[0]), &parts[made++]);
        }
        if (mask_any(mask_or(far0, far1))) {
            part_make(&e, 1, far0, far1, lanes_all(lamp->inverse_s[1]), &parts[made++]);
        }
    }
    return made;
}

/* What parts of one half add up to. */
typedef struct eval_half {
    lanes cosine;     /* theta t / |v0 x v1| */
    lanes_plane turn; /* exp(i sum beta) */
} eval_half;

/* Stage by stage, since each angle is a long chain of dependent steps. */
static inline void parts_sum(eval_part *parts, size_t count, eval_half halves[2])
{
    for (size_t i = 0; i < count; i++) {
        parts[i].arc = plane_half(parts[i].arc);
    }
    for (size_t i = 0; i < count; i++) {
        parts[i].arc = plane_half(parts[i].arc);
    }
    for (size_t i = 0; i < count; i++) {
        const lane_mask there = parts[i].there;
        eval_half *half = &halves[parts[i].half];
        const lanes theta = plane_angle_of_quarter(parts[i].arc);
        const lanes_plane turned = plane_product(half->turn, parts[i].turn);
        half->cosine =
            lanes_madd(lanes_select(there, theta, lanes_all(0)), parts[i].slope, half->cosine);
        half->turn.x = lanes_select(there, turned.x, half->turn.x);
        half->turn.y = lanes_select(there, turned.y, half->turn.y);
    }
}

/* The signed angle of a complex number. */
static inline lanes signed_angle(lanes_plane a)
{
    const lanes angle = plane_angle(plane_unit((lanes_plane){a.x, lanes_abs(a.y)}));
    return lanes_select(lanes_less(a.y, lanes_all(0)), lanes_all(0) - angle, angle);
}

/* The length of the horizon between the crossings, signed as the polygon runs about the axis. */
static inline lanes horizon_length(const eval_group *group, const eval_horizon *horizon,
                                   lane_mask clockwise)
{
    const lanes zero = lanes_all(0);
    if (!mask_any(horizon->crossed)) {
        return zero;
    }
    const lanes turn = lanes3_dot(group->axis, lanes3_cross(horizon->leave, horizon->enter));
    const lanes_plane between = {lanes3_dot(horizon->leave, horizon->enter), lanes_abs(turn)};
    const lanes angle = plane_angle(plane_unit(between));
    return lanes_select(horizon->crossed, lanes_select(clockwise, zero - angle, angle), zero);
}

static inline lanes half_integral(const eval_half *half, lanes horizon, lane_real w)
{
    const lanes beta = w < 1 ? signed_angle(half->turn) : lanes_all(0);
    const lanes sum = lanes_madd(lanes_all(w), half->cosine, lanes_all(2 * (1 - w)) * beta);
    return lanes_abs(sum + horizon) * lanes_all((lane_real)0.15915494309189533577); /* 1/(2 pi) */
}

static inline lanes lobes_integral(const eval_lamp *lamp, const eval_group *group, size_t count)
{
    const lanes zero = lanes_all(0);
    const eval_half none = {zero, {lanes_all(1), zero}};
    eval_half halves[2] = {none, none};
    eval_part parts[2 * AIR_AREA_MAX_VERTICES];
    eval_horizon horizon = {group->to_centre, group->to_centre, mask_none()};
    parts_sum(parts, parts_make(lamp, group, count, parts, &horizon), halves);
    /* From where the normal points to, the polygon runs clockwise about the directions to it. */
    const lanes length = horizon_length(group, &horizon, group->below);
    return lanes_madd(lanes_all(lamp->share[0]), half_integral(&halves[0], length, lamp->w[0]),
                      lanes_all(lamp->share[1]) *
                          half_integral(&halves[1], zero - length, lamp->w[1]));
}

#endif
