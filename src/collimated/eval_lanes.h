/* eval_lanes.h: T of many rays side by side; included once by the file of each instruction set.
 *
 * The same integral as profile.c's, without branches. Lines are the distances to the faces towards
 * the light, offset + slope t; along the ray the lowest of them has ever lower slope. With three
 * lines at most (a box) these are sorted and their two changes written down; with more the envelope
 * is walked by all lanes together. */
#ifndef AIR_COLLIMATED_EVAL_LANES_H
#define AIR_COLLIMATED_EVAL_LANES_H

#include <math.h>

#include "collimated/eval.h"
#include "collimated/pieces.h"
#include "core/lanes_exponential.h"

enum { BOX_LINES = AIR_EVAL_BOX_LINES, BLOCK_GROUPS = 4 };

typedef struct lanes_line {
    lanes offset, slope;
} lanes_line;

static inline lanes line_at(lanes_line line, lanes t) { return line.offset + line.slope * t; }

static inline lanes_line line_select(lane_mask mask, lanes_line a, lanes_line b)
{
    return (lanes_line){lanes_select(mask, a.offset, b.offset),
                        lanes_select(mask, a.slope, b.slope)};
}

static inline lanes not_negative(lanes x) { return lanes_max(x, lanes_all(0.0)); }

/* ---- a ray ---- */

typedef struct lanes_ray {
    lanes origin[3], dir[3], t_max;
} lanes_ray;

static inline lanes_ray load_ray(const air_collimated_rays *rays, size_t at)
{
    lanes_ray ray;
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = lanes_load(rays->origin[i] + at);
        ray.dir[i] = lanes_load(rays->dir[i] + at);
    }
    ray.t_max = rays->t_max != NULL ? lanes_load(rays->t_max + at) : lanes_all(INFINITY);
    return ray;
}

/* Zero times what is not finite is NaN. */
static inline lane_mask ray_is_finite(const lanes_ray *ray)
{
    lanes sum = lanes_all(0.0);
    for (int i = 0; i < 3; i++) {
        sum = lanes_madd(ray->origin[i], lanes_all(0.0), sum);
        sum = lanes_madd(ray->dir[i], lanes_all(0.0), sum);
    }
    return lanes_equal(sum, sum);
}

/* The stretch inside. Where it begins (ends) at a face towards the light, enters (exits) is set: d
 * is 0 there. */
typedef struct lanes_stretch {
    lanes begin, end;
    lane_mask enters, exits;
    lanes_line entry; /* the line of the face where it enters; kept by the walk only */
} lanes_stretch;

/* Clips the stretch by one slab and gives the line of its front face. A ray along the slab has r =
 * inf: the ends are infinite, or NaN and ignored, as it lies between the planes or not. */
static inline lanes_line clip(const air_eval_slab *slab, bool faces_light, bool keep_entry,
                              const lanes_ray *ray, lanes_stretch *s)
{
    const double *n = slab->normal;
    const lanes along = n[0] * ray->origin[0] + n[1] * ray->origin[1] + n[2] * ray->origin[2];
    const lanes nv = n[0] * ray->dir[0] + n[1] * ray->dir[1] + n[2] * ray->dir[2];
    const lanes no = slab->front - along, r = 1.0 / nv;
    const lanes t_front = no * r, t_back = -(slab->back + along) * r;
    const lane_mask outwards = lanes_less(lanes_all(0.0), r); /* knows -0 from 0 */
    const lanes leave = lanes_select(outwards, t_front, t_back),
                enter = lanes_select(outwards, t_back, t_front);
    const lane_mask sooner = lanes_less(leave, s->end), later = lanes_less(s->begin, enter);
    const lanes_line line = {no * slab->inverse, 0.0 - nv * slab->inverse}; /* no -0 */
    s->end = lanes_min(leave, s->end);
    s->begin = lanes_max(enter, s->begin);
    s->exits = mask_and_not(s->exits, sooner);
    s->enters = mask_and_not(s->enters, later);
    if (faces_light) {
        const lane_mask here = mask_and_not(later, outwards);
        s->exits = mask_or(s->exits, mask_and(sooner, outwards));
        s->enters = mask_or(s->enters, here);
        if (keep_entry) {
            s->entry = line_select(here, line, s->entry);
        }
    }
    return line;
}

static inline lanes_stretch whole_ray(const lanes_ray *ray)
{
    const lanes zero = lanes_all(0.0);
    return (lanes_stretch){zero, ray->t_max, mask_none(), mask_none(), {zero, zero}};
}

/* The lowest line at t; of equal ones the one of least slope. */
static inline lanes_line lowest_line(const lanes_line *lines, size_t count, lanes t, lanes *out_d)
{
    lanes_line lowest = lines[0];
    lanes least = line_at(lowest, t);
    for (size_t j = 1; j < count; j++) {
        const lanes d = line_at(lines[j], t);
        const lane_mask lower =
            mask_or(lanes_less(d, least),
                    mask_and(lanes_equal(d, least), lanes_less(lines[j].slope, lowest.slope)));
        lowest = line_select(lower, lines[j], lowest);
        least = lanes_min(d, least);
    }
    *out_d = least;
    return lowest;
}

static inline lanes least_at(const lanes_line *lines, size_t count, lanes t)
{
    lanes least = line_at(lines[0], t);
    for (size_t j = 1; j < count; j++) {
        least = lanes_min(line_at(lines[j], t), least);
    }
    return not_negative(least);
}

/* A stretch without end is cut where nothing comes through any more. */
static inline lanes cut_end(const lanes_stretch *s, lanes d_begin, double sigma_t)
{
    const lanes cut = s->begin + d_begin + AIR_COLLIMATED_OPAQUE / sigma_t;
    return lanes_select(lanes_equal(s->end, lanes_all(INFINITY)), cut, s->end);
}

/* ---- the integral, piece by piece ---- */

/* Depths rise, then fall. Rising pieces are summed with exp(-x_first) taken out, falling ones with
 * exp(-x) of the current end taken out; so every factor is an exp of something negative. */
typedef struct lanes_sum {
    lanes rising, thin; /* thin: exp(x_first - x) while depths rise */
    lanes falling;
} lanes_sum;

/* A piece of some length, maybe 0, from depth x0 to x1. The mean of exp over it, seen from its
 * thinner end, is (1 - exp(-x))/x; 1e-300 makes that 1 for x = 0 and changes nothing for others. */
static inline void add_piece(lanes_sum *sum, lanes length, lanes x0, lanes x1)
{
    lanes loss;
    const lanes x = lanes_abs(x1 - x0);
    const lane_mask falls = lanes_less(x1, x0);
    const lanes through = air_lanes_transmittance(x, &loss);
    const lanes part = length * ((loss + 1e-300) / (x + 1e-300));
    const lanes one = lanes_all(1.0), zero = lanes_all(0.0);
    sum->rising = lanes_madd(sum->thin, lanes_select(falls, zero, part), sum->rising);
    sum->thin = sum->thin * lanes_select(falls, one, through);
    sum->falling = lanes_madd(sum->falling, lanes_select(falls, through, one),
                              lanes_select(falls, part, zero));
}

/* T and log T from the sum and the depths at the ends, 0 and -inf where not valid. */
static inline void finish(const lanes_sum *sum, lanes first, lanes last, lane_mask valid,
                          double *out_t, double *out_log)
{
    lanes loss;
    const lanes least = lanes_min(first, last);
    const lanes far = air_lanes_transmittance(lanes_abs(last - first), &loss);
    const lane_mask rises = lanes_less(first, last);
    const lanes scaled = lanes_select(rises, lanes_madd(far, sum->falling, sum->rising),
                                      lanes_madd(far, sum->rising, sum->falling));
    const lane_mask good = mask_and(valid, mask_and(lanes_less(lanes_all(0.0), scaled),
                                                    lanes_less(scaled, lanes_all(INFINITY))));
    lanes_store(out_t, lanes_select(good, scaled * air_lanes_exp(-least), lanes_all(0.0)));
    if (out_log != NULL) {
        lanes_store(out_log,
                    lanes_select(good, air_lanes_log(scaled) - least, lanes_all(-INFINITY)));
    }
}

/* ---- up to three faces towards the light ---- */

/* The steeper first; of parallel ones the lower. */
static inline void sort_lines(lanes_line *a, lanes_line *b)
{
    const lane_mask swap =
        mask_or(lanes_less(a->slope, b->slope),
                mask_and(lanes_equal(a->slope, b->slope), lanes_less(b->offset, a->offset)));
    const lanes_line first = line_select(swap, *b, *a);
    *b = line_select(swap, *a, *b);
    *a = first;
}

/* Of two lines the value at t of the one that changes less: where they cross, it is the exact one.
 */
static inline lanes kink(lanes_line a, lanes_line b, lanes t)
{
    return line_at(line_select(lanes_less(lanes_abs(a.slope), lanes_abs(b.slope)), a, b), t);
}

/* Where the first line gives way and where the last takes over, within [begin, end]; and d there.
 */
typedef struct box_nodes {
    lanes t[2], d[2];
} box_nodes;

/* l: sorted. Crossings x_ij; if the middle line is ever lowest, x_12 < x_13 < x_23, else x_23 <=
 * x_13 <= x_12: the nodes are min(x_12, x_13) and max(x_23, x_13). Which, is seen without dividing.
 * Parallel lines cross at infinity, equal ones at NaN, which counts as before the stretch. A node
 * moved to an end of the stretch has there the value of the lines that are lowest inside. */
static inline box_nodes find_nodes(const lanes_line l[BOX_LINES], lanes begin, lanes end)
{
    const lanes rise12 = l[1].offset - l[0].offset, run12 = l[0].slope - l[1].slope;
    const lanes rise13 = l[2].offset - l[0].offset, run13 = l[0].slope - l[2].slope;
    const lanes rise23 = l[2].offset - l[1].offset, run23 = l[1].slope - l[2].slope;
    const lane_mask second = lanes_less(rise12 * run13, rise13 * run12);
    const lane_mask middle = lanes_less(rise13 * run23, rise23 * run13);
    const lanes p = lanes_select(second, rise12, rise13) / lanes_select(second, run12, run13);
    const lanes q = lanes_select(middle, rise23, rise13) / lanes_select(middle, run23, run13);
    const lane_mask p_in = lanes_less(begin, p), p_before = lanes_less(p, end);
    const lane_mask q_in = lanes_less(begin, q), q_before = lanes_less(q, end);
    box_nodes out;
    const lanes p_inside = kink(l[0], line_select(second, l[1], l[2]), p);
    const lanes p_at_end = line_at(l[0], end);
    const lanes p_at_begin = lanes_min(line_at(l[1], begin), line_at(l[2], begin));
    out.t[0] = lanes_min(lanes_max(p, begin), end);
    out.d[0] =
        not_negative(lanes_select(p_in, lanes_select(p_before, p_inside, p_at_end), p_at_begin));
    const lanes q_inside = kink(line_select(middle, l[1], l[0]), l[2], q);
    out.t[1] = lanes_min(lanes_max(q, out.t[0]), end);
    const lane_mask later = mask_and(lanes_less(out.t[0], q), lanes_less(out.t[0], end));
    const lanes stays = lanes_select(q_in, out.d[0], not_negative(line_at(l[2], begin)));
    out.d[1] = lanes_select(
        later, not_negative(lanes_select(q_before, q_inside, line_at(l[1], end))), stays);
    return out;
}

/* A ray's depths at its nodes and the lengths between them. */
typedef struct box_pieces {
    lanes length[3], depth[4];
    lane_mask valid;
} box_pieces;

static inline void trace_box(const air_eval_batch *batch, const air_collimated_rays *rays,
                             size_t at, box_pieces *out)
{
    const lanes_ray ray = load_ray(rays, at);
    lanes_stretch s = whole_ray(&ray);
    lanes_line l[BOX_LINES];
    for (size_t k = 0; k < BOX_LINES; k++) {
        l[k] = clip(&batch->slabs[k], true, false, &ray, &s);
    }
    for (size_t k = BOX_LINES; k < batch->count; k++) {
        (void)clip(&batch->slabs[k], false, false, &ray, &s);
    }
    sort_lines(&l[0], &l[1]);
    sort_lines(&l[1], &l[2]);
    sort_lines(&l[0], &l[1]);
    const lanes zero = lanes_all(0.0), begin = s.begin;
    const double sigma_t = batch->sigma_t;
    const lanes d_begin = lanes_select(s.enters, zero, least_at(l, BOX_LINES, begin));
    const lanes end = cut_end(&s, d_begin, sigma_t);
    const lanes d_end = lanes_select(s.exits, zero, least_at(l, BOX_LINES, end));
    const box_nodes node = find_nodes(l, begin, end);
    out->length[0] = node.t[0] - begin;
    out->length[1] = node.t[1] - node.t[0];
    out->length[2] = end - node.t[1];
    out->depth[0] = sigma_t * d_begin;
    out->depth[1] = sigma_t * ((node.t[0] - begin) + node.d[0]);
    out->depth[2] = sigma_t * ((node.t[1] - begin) + node.d[1]);
    out->depth[3] = sigma_t * ((end - begin) + d_end);
    out->valid = mask_and(lanes_less(begin, s.end), ray_is_finite(&ray));
}

static inline void integrate_box(const box_pieces *p, double *out_t, double *out_log)
{
    const lanes zero = lanes_all(0.0);
    lanes_sum sum = {zero, lanes_all(1.0), zero};
    for (int i = 0; i < 3; i++) {
        add_piece(&sum, p->length[i], p->depth[i], p->depth[i + 1]);
    }
    finish(&sum, p->depth[0], p->depth[3], p->valid, out_t, out_log);
}

/* One group is a long chain of dependent steps; a few of them, stage by stage, keep the processor
 * busy. */
static inline void eval_box(const air_eval_batch *batch, const air_collimated_rays *rays, size_t at,
                            size_t groups, double *out_t, double *out_log)
{
    box_pieces pieces[BLOCK_GROUPS];
    for (size_t g = 0; g < groups; g++) {
        trace_box(batch, rays, at + g * LANES, &pieces[g]);
    }
    for (size_t g = 0; g < groups; g++) {
        integrate_box(&pieces[g], out_t + g * LANES, out_log != NULL ? out_log + g * LANES : NULL);
    }
}

/* ---- any number of faces ---- */

/* The line that takes over from `active` and where (rise / run, run > 0); lanes where none does are
 * not in the mask. */
static inline lane_mask next_line(const lanes_line *lines, size_t count, lanes_line active,
                                  lanes_line *out_next, lanes *out_at)
{
    lanes rise = lanes_all(INFINITY), run = lanes_all(1.0);
    lanes_line next = active;
    for (size_t j = 0; j < count; j++) {
        const lanes gap = lines[j].offset - active.offset, gain = active.slope - lines[j].slope;
        const lane_mask sooner =
            mask_and(lanes_less(lanes_all(0.0), gain), lanes_less(gap * run, rise * gain));
        rise = lanes_select(sooner, gap, rise);
        run = lanes_select(sooner, gain, run);
        next = line_select(sooner, lines[j], next);
    }
    *out_next = next;
    *out_at = rise / run;
    return lanes_less(rise, lanes_all(INFINITY));
}

/* A walk under way: the lowest line at t, the depth x there; the slope of the lowest line at the
 * end. */
typedef struct lanes_walk {
    lanes_line lines[AIR_COLLIMATED_MAX_PLANES];
    lanes_line line;
    lanes begin, end, t, x, first, last, last_slope;
    lanes_sum sum;
    lane_mask valid, going;
} lanes_walk;

static inline void walk_start(const air_eval_batch *batch, const air_collimated_rays *rays,
                              size_t at, lanes_walk *w)
{
    const lanes_ray ray = load_ray(rays, at);
    const size_t count = batch->facing;
    const double sigma_t = batch->sigma_t;
    lanes_stretch s = whole_ray(&ray);
    for (size_t k = 0; k < count; k++) {
        w->lines[k] = clip(&batch->slabs[k], true, true, &ray, &s);
    }
    for (size_t k = count; k < batch->count; k++) {
        (void)clip(&batch->slabs[k], false, true, &ray, &s);
    }
    const lanes zero = lanes_all(0.0);
    lanes d_lowest, d_last;
    const lanes_line lowest = lowest_line(w->lines, count, s.begin, &d_lowest);
    const lanes d_begin = lanes_select(s.enters, zero, not_negative(d_lowest));
    w->line = line_select(s.enters, s.entry, lowest);
    w->begin = w->t = s.begin;
    w->end = cut_end(&s, d_begin, sigma_t);
    w->last_slope = lowest_line(w->lines, count, w->end, &d_last).slope;
    const lanes d_end = lanes_select(s.exits, zero, not_negative(d_last));
    w->first = w->x = sigma_t * d_begin;
    w->last = sigma_t * ((w->end - s.begin) + d_end);
    w->sum = (lanes_sum){zero, lanes_all(1.0), zero};
    w->valid = w->going = mask_and(lanes_less(s.begin, s.end), ray_is_finite(&ray));
}

/* To where the next line takes over; false if all lanes are under their last. */
static inline bool walk_step(const air_eval_batch *batch, lanes_walk *w)
{
    lanes_line next;
    lanes crossing;
    w->going = mask_and(w->going, lanes_less(w->last_slope, w->line.slope));
    if (!mask_any(w->going)) {
        return false;
    }
    const lane_mask found = next_line(w->lines, batch->facing, w->line, &next, &crossing);
    w->going = mask_and(w->going, mask_and(found, lanes_less(crossing, w->end)));
    const lanes t = lanes_select(w->going, lanes_max(crossing, w->t), w->t);
    const lanes d = not_negative(kink(w->line, next, t));
    const lanes x = lanes_select(w->going, batch->sigma_t * ((t - w->begin) + d), w->x);
    add_piece(&w->sum, t - w->t, w->x, x);
    w->line = line_select(w->going, next, w->line);
    w->t = t;
    w->x = x;
    return true;
}

static inline void eval_walk(const air_eval_batch *batch, const air_collimated_rays *rays,
                             size_t at, size_t groups, double *out_t, double *out_log)
{
    lanes_walk walks[BLOCK_GROUPS];
    bool going = true;
    for (size_t g = 0; g < groups; g++) {
        walk_start(batch, rays, at + g * LANES, &walks[g]);
    }
    for (size_t step = 1; step < batch->facing && going; step++) {
        going = false;
        for (size_t g = 0; g < groups; g++) {
            going = walk_step(batch, &walks[g]) || going;
        }
    }
    for (size_t g = 0; g < groups; g++) {
        lanes_walk *w = &walks[g];
        add_piece(&w->sum, w->end - w->t, w->x, w->last);
        finish(&w->sum, w->first, w->last, w->valid, out_t + g * LANES,
               out_log != NULL ? out_log + g * LANES : NULL);
    }
}

/* ---- batches ---- */

/* groups <= BLOCK_GROUPS */
static inline void eval_block(const air_eval_batch *batch, const air_collimated_rays *rays,
                              size_t at, size_t groups, double *out_t, double *out_log)
{
    if (batch->facing <= BOX_LINES) {
        eval_box(batch, rays, at, groups, out_t, out_log);
    } else {
        eval_walk(batch, rays, at, groups, out_t, out_log);
    }
}

/* The rays that fill no group, the last of them repeated. */
static void eval_rest(const air_eval_batch *batch, const air_collimated_rays *rays, size_t at,
                      size_t count, double *out_t, double *out_log)
{
    double full[7][LANES], t[LANES], log_t[LANES];
    for (size_t i = 0; i < LANES; i++) {
        const size_t ray = at + (i < count ? i : count - 1);
        for (int k = 0; k < 3; k++) {
            full[k][i] = rays->origin[k][ray];
            full[3 + k][i] = rays->dir[k][ray];
        }
        full[6][i] = rays->t_max != NULL ? rays->t_max[ray] : INFINITY;
    }
    const air_collimated_rays group = {
        {full[0], full[1], full[2]}, {full[3], full[4], full[5]}, full[6]};
    eval_block(batch, &group, 0, 1, t, log_t);
    memcpy(out_t, t, count * sizeof *t);
    if (out_log != NULL) {
        memcpy(out_log, log_t, count * sizeof *t);
    }
}

static inline void eval_rays(const air_eval_batch *batch, const air_collimated_rays *rays,
                             size_t count, double *out_t, double *out_log)
{
    size_t done = 0;
    while (done + LANES <= count) {
        const size_t left = (count - done) / LANES;
        const size_t groups = left < BLOCK_GROUPS ? left : BLOCK_GROUPS;
        eval_block(batch, rays, done, groups, out_t + done,
                   out_log != NULL ? out_log + done : NULL);
        done += groups * LANES;
    }
    if (done < count) {
        eval_rest(batch, rays, done, count - done, out_t + done,
                  out_log != NULL ? out_log + done : NULL);
    }
}

#endif
