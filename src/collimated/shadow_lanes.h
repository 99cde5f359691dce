/* shadow_lanes.h: the test of a block, eight triangles at once, as shadow_walk.c does it for one;
 * the compiler makes of eight lanes what the instruction set has. */
#ifndef AIR_COLLIMATED_SHADOW_LANES_H
#define AIR_COLLIMATED_SHADOW_LANES_H

#include <string.h>

#include "collimated/shadow_traverse.h"

/* Nothing here is called across files, so the calling convention of wide vectors does not matter.
 */
#pragma GCC diagnostic ignored "-Wpsabi"

typedef float lanes __attribute__((vector_size(4 * SHADOW_LANES)));
typedef int32_t lane_mask __attribute__((vector_size(4 * SHADOW_LANES)));

static inline lanes lanes_all(float x) { return (lanes){x, x, x, x, x, x, x, x}; }

static inline lanes lanes_load(const float *p)
{
    lanes v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline lanes lanes_select(lane_mask mask, lanes yes, lanes no)
{
    return (lanes)((mask & (lane_mask)yes) | (~mask & (lane_mask)no));
}

/* Bit k: lane k of the mask is set. Each file brings what its instruction set has for it. */
static inline unsigned lane_bits(lane_mask mask);

typedef struct lane_corner {
    lanes side, along, above, height;
} lane_corner;

static inline lane_corner lanes_see_corner(const shadow_block *block, int k, const shadow_ray *ray)
{
    const lanes x = lanes_load(block->x[k]) - ray->x, y = lanes_load(block->y[k]) - ray->y;
    lane_corner out;
    out.height = lanes_load(block->z[k]) - ray->z;
    out.side = x * ray->wy - y * ray->wx;
    out.along = x * ray->wx + y * ray->wy;
    out.above = out.height * ray->s - out.along * ray->c;
    return out;
}

static inline lane_corner lanes_select_corner(lane_mask mask, const lane_corner *yes,
                                              const lane_corner *no)
{
    return (lane_corner){
        lanes_select(mask, yes->side, no->side), lanes_select(mask, yes->along, no->along),
        lanes_select(mask, yes->above, no->above), lanes_select(mask, yes->height, no->height)};
}

/* Without the height, which only rays that are nearly parallel to the light need. */
static inline lane_corner lanes_meet_plane(const lane_corner *a, const lane_corner *b)
{
    const lanes d = b->side - a->side;
    return (lane_corner){.along = (a->along * b->side - b->along * a->side) / d,
                         .above = (a->above * b->side - b->above * a->side) / d};
}

static inline lanes lanes_meet_height(const lane_corner *a, const lane_corner *b)
{
    return (a->height * b->side - b->height * a->side) / (b->side - a->side);
}

static inline void shadow_test_lanes(const shadow_block *block, const shadow_ray *ray, float begin,
                                     float end, shadow_list *list)
{
    const lane_corner c0 = lanes_see_corner(block, 0, ray), c1 = lanes_see_corner(block, 1, ray);
    const lane_corner c2 = lanes_see_corner(block, 2, ray);
    const lane_mask s0 = c0.side >= 0.0f, s1 = c1.side >= 0.0f, s2 = c2.side >= 0.0f;
    const lane_mask split = (s0 ^ s1) | (s0 ^ s2);
    if (lane_bits(split) == 0) {
        return;
    }
    const lane_mask lone2 = ~(s0 ^ s1), lone1 = ~(s0 ^ s2) & ~lone2;
    /* i is alone on its side; the order of j and k is that of shadow_walk.c */
    lane_corner i = lanes_select_corner(lone1, &c1, &c0);
    i = lanes_select_corner(lone2, &c2, &i);
    const lane_mask lone0 = ~(lone1 | lone2);
    const lane_corner j = lanes_select_corner(lone0, &c1, &c0);
    const lane_corner k = lanes_select_corner(lone2, &c1, &c2);
    const lane_corner p = lanes_meet_plane(&i, &j), q = lanes_meet_plane(&i, &k);
    const lane_mask p_above = p.above > 0.0f, q_above = q.above > 0.0f;
    if (lane_bits(split & (p_above | q_above)) == 0) {
        return;
    }
    const lanes f = p.above / (p.above - q.above);
    const lanes along = p.along + f * (q.along - p.along);
    lanes t_cross = along * ray->inverse_s;
    if (ray->s < 0.1f) {
        const lanes p_height = lanes_meet_height(&i, &j), q_height = lanes_meet_height(&i, &k);
        t_cross = along * ray->s + (p_height + f * (q_height - p_height)) * ray->c;
    }
    const lanes t_p = lanes_select(p_above, p.along * ray->inverse_s, t_cross);
    const lanes t_q = lanes_select(q_above, q.along * ray->inverse_s, t_cross);
    const lane_mask order = t_p < t_q;
    const lanes low = lanes_select(order, t_p, t_q), high = lanes_select(order, t_q, t_p);
    const lanes t0 = lanes_select(low > begin, low, lanes_all(begin));
    const lanes t1 = lanes_select(high < end, high, lanes_all(end));
    unsigned found = lane_bits(split & (p_above | q_above) & (t0 < t1));
    float begins[SHADOW_LANES], ends[SHADOW_LANES];
    memcpy(begins, &t0, sizeof begins);
    memcpy(ends, &t1, sizeof ends);
    for (; found != 0; found &= found - 1) {
        const int lane = __builtin_ctz(found);
        shadow_list_add(list, begins[lane], ends[lane]);
    }
}

#endif
