/* eval_lanes.h: S at many points side by side; included once by the file of each instruction set
 * and precision, after lanes_double.h or lanes_float.h. */
#ifndef AIR_AREALIGHT_EVAL_LANES_H
#define AIR_AREALIGHT_EVAL_LANES_H

#include "arealight/eval_lanes_edge.h"
#include "arealight/eval_lanes_lobe.h"

/* Loads one group of points: directions from the point to the lamp's centre, and the axis. */
static inline void load_group(const eval_lamp *lamp, const lane_real *const position[3],
                              const lane_real *const wo[3], size_t at, eval_group *out)
{
    lanes finite = lanes_all(0), to_centre[3], axis[3];
    for (int i = 0; i < 3; i++) {
        const lanes p = lanes_load(position[i] + at), w = lanes_load(wo[i] + at);
        finite = lanes_madd(p, lanes_all(0), lanes_madd(w, lanes_all(0), finite));
        to_centre[i] = lanes_all(lamp->centre[i]) - p;
        axis[i] = lanes_all(lamp->peak) * w;
    }
    out->to_centre = (lanes3){to_centre[0], to_centre[1], to_centre[2]};
    out->axis = (lanes3){axis[0], axis[1], axis[2]};
    /* Of the plane over the point, by the first vertex: that of one who stands in the plane is 0.
     */
    const lanes height = lanes3_dot(lanes3_all(lamp->normal),
                                    lanes3_sum(out->to_centre, lanes3_all(lamp->offset[0])));
    out->below = lanes_less(height, lanes_all(0));
    out->lit = lanes_equal(finite, finite);
    if (!lamp->two_sided) {
        out->lit = mask_and(out->lit, out->below);
    }
}

/* count: that of the vertices, where known to the compiler. */
static inline void eval_group_at(const eval_lamp *lamp, size_t count,
                                 const lane_real *const position[3], const lane_real *const wo[3],
                                 size_t at, lane_real *out_s)
{
    eval_group group;
    load_group(lamp, position, wo, at, &group);
    const lanes s =
        lamp->lobes ? lobes_integral(lamp, &group, count) : edges_integral(lamp, &group, count);
    const lane_mask good = mask_and(group.lit, lanes_less(s, lanes_all((lane_real)LANES_GREATEST)));
    lanes_store(out_s, lanes_select(good, lanes_min(lanes_max(s, lanes_all(0)), lanes_all(1)),
                                    lanes_all(0)));
}

static inline void eval_groups(const eval_lamp *lamp, size_t count,
                               const lane_real *const position[3], const lane_real *const wo[3],
                               size_t points, lane_real *out_s)
{
    for (size_t at = 0; at + LANES <= points; at += LANES) {
        eval_group_at(lamp, count, position, wo, at, out_s + at);
    }
}

/* Loops over the edges of triangles and quadrilaterals are unrolled. */
static void eval_whole_groups(const eval_lamp *lamp, const lane_real *const position[3],
                              const lane_real *const wo[3], size_t points, lane_real *out_s)
{
    if (lamp->count == 3) {
        eval_groups(lamp, 3, position, wo, points, out_s);
    } else if (lamp->count == 4) {
        eval_groups(lamp, 4, position, wo, points, out_s);
    } else {
        eval_groups(lamp, lamp->count, position, wo, points, out_s);
    }
}

/* The points that fill no group, the last of them repeated. */
static void eval_rest(const eval_lamp *lamp, const lane_real *const position[3],
                      const lane_real *const wo[3], size_t at, size_t rest, lane_real *out_s)
{
    lane_real full[6][LANES], s[LANES];
    for (size_t i = 0; i < LANES; i++) {
        const size_t point = at + (i < rest ? i : rest - 1);
        for (int k = 0; k < 3; k++) {
            full[k][i] = position[k][point];
            full[3 + k][i] = wo[k][point];
        }
    }
    const lane_real *const positions[3] = {full[0], full[1], full[2]};
    const lane_real *const wos[3] = {full[3], full[4], full[5]};
    eval_whole_groups(lamp, positions, wos, LANES, s);
    memcpy(out_s, s, rest * sizeof *s);
}

static inline void eval_points(const air_area_plan *plan, const lane_real *const position[3],
                               const lane_real *const wo[3], size_t points, lane_real *out_s)
{
    eval_lamp lamp;
    eval_lamp_make(plan, &lamp);
    const size_t rest = points % LANES;
    eval_whole_groups(&lamp, position, wo, points, out_s);
    if (rest > 0) {
        eval_rest(&lamp, position, wo, points - rest, rest, out_s + (points - rest));
    }
}

#endif
