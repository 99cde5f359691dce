/* eval_lanes_lamp.h: the lamp and a group of points as the lanes see them. */
#ifndef AIR_AREALIGHT_EVAL_LANES_LAMP_H
#define AIR_AREALIGHT_EVAL_LANES_LAMP_H

#include <float.h>
#include <math.h>
#include <string.h>

#include "arealight/eval.h"
#include "core/lanes_angle.h"

typedef struct lanes3 {
    lanes x, y, z;
} lanes3;

static inline lanes3 lanes3_all(const lane_real v[3])
{
    return (lanes3){lanes_all(v[0]), lanes_all(v[1]), lanes_all(v[2])};
}

static inline lanes lanes3_dot(lanes3 a, lanes3 b)
{
    return lanes_madd(a.x, b.x, lanes_madd(a.y, b.y, a.z * b.z));
}

static inline lanes3 lanes3_sum(lanes3 a, lanes3 b)
{
    return (lanes3){a.x + b.x, a.y + b.y, a.z + b.z};
}

/* a + t b */
static inline lanes3 lanes3_along(lanes3 a, lanes t, lanes3 b)
{
    return (lanes3){lanes_madd(t, b.x, a.x), lanes_madd(t, b.y, a.y), lanes_madd(t, b.z, a.z)};
}

static inline lanes3 lanes3_cross(lanes3 a, lanes3 b)
{
    return (lanes3){lanes_nmadd(a.z, b.y, a.y * b.z), lanes_nmadd(a.x, b.z, a.z * b.x),
                    lanes_nmadd(a.y, b.x, a.x * b.y)};
}

/* The plan in the precision at hand. Vertices count from the centre: floats far from the origin
 * lose nothing. */
typedef struct eval_lamp {
    size_t count;
    bool two_sided, lobes;
    int pairs;
    lane_real centre[3], normal[3], peak, gamma;
    lane_real two_gamma, four_gamma2, mean; /* mean: 1 + gamma^2 */
    lane_real rest, rest2, all_rest;        /* (1 - gamma)^2, twice that, (1 - gamma^2)^2 */
    lane_real near_square;  /* of the distance below which the lamp counts as near */
    lane_real small_square; /* of the distance times r from which on it counts as small */
    lane_real offset[AIR_AREA_MAX_VERTICES][3], edge[AIR_AREA_MAX_VERTICES][3];
    lane_real spoke[AIR_AREA_MAX_VERTICES][3]; /* the normals of the fan about the centre */
    lane_real node[AIR_EDGE_PAIRS], weight[AIR_EDGE_PAIRS];
    lane_real share[2], inverse_s[2], w[2];
} eval_lamp;

/* x in the precision at hand. Volatile, since gcc 12 at -O3 takes (double)(float)x for x where it
 * vectorises; the offsets of floats then miss what the centre's rounding has moved. */
static lane_real rounded(double x)
{
    const volatile lane_real out = (lane_real)x;
    return out;
}

static void eval_lamp_shape(const air_area_lamp *lamp, eval_lamp *out)
{
    double offset[AIR_AREA_MAX_VERTICES][3], radius_square = 0.0;
    out->count = lamp->vertex_count;
    for (int k = 0; k < 3; k++) {
        out->centre[k] = rounded(lamp->centre[k]);
        out->normal[k] = (lane_real)lamp->normal[k];
    }
    for (size_t i = 0; i < out->count; i++) {
        const double *a = lamp->vertices[i], *b = lamp->vertices[(i + 1) % out->count];
        double square = 0.0;
        for (int k = 0; k < 3; k++) {
            offset[i][k] = a[k] - (double)out->centre[k];
            out->offset[i][k] = (lane_real)offset[i][k];
            out->edge[i][k] = (lane_real)(b[k] - a[k]);
            square += offset[i][k] * offset[i][k];
        }
        radius_square = fmax(radius_square, square);
    }
    for (size_t i = 0; i < out->count; i++) {
        const double *a = offset[i], *b = offset[(i + 1) % out->count];
        out->spoke[i][0] = (lane_real)(a[1] * b[2] - a[2] * b[1]);
        out->spoke[i][1] = (lane_real)(a[2] * b[0] - a[0] * b[2]);
        out->spoke[i][2] = (lane_real)(a[0] * b[1] - a[1] * b[0]);
    }
    const double g = (double)out->gamma;
    const double rounding = sizeof(lane_real) == sizeof(double) ? DBL_EPSILON : FLT_EPSILON;
    const double small = cbrt(0.2 * rounding * (1.0 + g) / (1.0 - g)); /* angle / r */
    out->near_square = (lane_real)(16.0 * radius_square);
    out->small_square = (lane_real)(radius_square / (small * small));
}

static void eval_lamp_make(const air_area_plan *plan, eval_lamp *out)
{
    out->two_sided = plan->lamp->two_sided;
    out->lobes = plan->lobes;
    out->pairs = plan->rule.pairs;
    out->peak = (lane_real)plan->peak;
    const lane_real g = out->gamma = (lane_real)plan->gamma;
    out->two_gamma = g + g;
    out->four_gamma2 = 4 * g * g;
    out->mean = 1 + g * g;
    out->rest = (1 - g) * (1 - g);
    out->rest2 = out->rest + out->rest;
    out->all_rest = (1 - g * g) * (1 - g * g);
    for (int i = 0; i < plan->rule.pairs; i++) {
        out->node[i] = (lane_real)plan->rule.node[i];
        out->weight[i] = (lane_real)plan->rule.weight[i];
    }
    for (int i = 0; i < 2 && plan->lobes; i++) {
        out->share[i] = (lane_real)plan->halves.share[i];
        out->inverse_s[i] = (lane_real)(1.0 / plan->halves.s[i]);
        out->w[i] = (lane_real)plan->halves.w[i];
    }
    eval_lamp_shape(plan->lamp, out);
}

/* Points side by side. */
typedef struct eval_group {
    lanes3 to_centre; /* from the point */
    lanes3 axis;
    lane_mask below; /* the point is on the side to which the lamp's normal points */
    lane_mask lit;
} eval_group;

/* A vertex seen from the point. */
typedef struct eval_vertex {
    lanes3 v;
    lanes square, inverse; /* of its length, and 1 / length */
} eval_vertex;

static inline eval_vertex vertex_at(const eval_lamp *lamp, const eval_group *group, size_t i)
{
    eval_vertex out;
    out.v = lanes3_sum(group->to_centre, lanes3_all(lamp->offset[i]));
    out.square = lanes3_dot(out.v, out.v);
    out.inverse = lanes_inverse_root(lanes_bounded(out.square));
    return out;
}

#endif
