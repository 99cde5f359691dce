/* beam.c: light from infinity through a box of cells, layer by layer. */
#include <math.h>

#include "ordinates/beam.h"
#include "ordinates/four.h"

enum { CHANNELS = BEAM_CHANNELS };

/* Cells of a row of planes: the border and room for whole vectors. */
static size_t row_of(size_t count) { return (count + BEAM_PAD - 1) / BEAM_PAD * BEAM_PAD + 2; }

/* Planes of single numbers are smaller: 4 a > a + BEAM_ROOM for rows of 6 and more. */
size_t air_beam_scratch(const size_t size[3])
{
    size_t most = 0;
    for (int axis = 0; axis < 3; axis++) {
        const size_t plane = row_of(size[axis]) * (size[(axis + 1) % 3] + 2);
        most = plane > most ? plane : most;
    }
    return BEAM_PLANES * most * CHANNELS * sizeof(float);
}

beam_sweep beam_sweep_make(const air_beam_box *box, const float dir[3], size_t numbers,
                           void *scratch)
{
    const size_t strides[3] = {1, box->size[0], box->size[0] * box->size[1]};
    float speed[3]; /* in cells */
    int w = 0;
    for (int axis = 0; axis < 3; axis++) {
        speed[axis] = dir[axis] / box->cell_m[axis];
        w = fabsf(speed[axis]) > fabsf(speed[w]) ? axis : w;
    }
    const int axes[3] = {(w + 1) % 3, (w + 2) % 3, w};
    beam_sweep s = {.box = box,
                    .numbers = numbers,
                    .back = speed[w] < 0.0f,
                    .length = box->cell_m[w] / fabsf(dir[w])};
    for (int i = 0; i < 3; i++) {
        s.count[i] = box->size[axes[i]];
        s.stride[i] = strides[axes[i]];
    }
    for (int i = 0; i < 2; i++) {
        s.shift[i] = speed[axes[i]] / fabsf(speed[w]);
    }
    s.row = numbers == 1 ? s.count[0] + 2 : row_of(s.count[0]);
    const size_t plane =
        s.row * (s.count[1] + 2) * numbers + (numbers == 1 ? (size_t)BEAM_ROOM : 0);
    float *at = scratch;
    float **const planes[BEAM_PLANES] = {&s.depth, &s.next, &s.through, &s.sigma, &s.sum};
    for (int i = 0; i < BEAM_PLANES; i++, at += plane) {
        *planes[i] = at;
        for (size_t n = 0; n < plane; n++) {
            at[n] = i == 2 ? 1.0f : 0.0f;
        }
    }
    return s;
}

/* Border cells are such that between them and their neighbours, at the box's side, the depth is 0.
 */
static void extend(float *plane, size_t numbers, size_t step, size_t count)
{
    float *const low = plane, *const high = plane + (count + 1) * step;
    for (size_t n = 0; n < numbers; n++) {
        low[n] = -low[step + n];
        high[n] = -(high - step)[n];
    }
}

static void extend_plane(const beam_sweep *s, float *plane)
{
    const size_t row = s->row * s->numbers;
    for (size_t v = 1; v <= s->count[1]; v++) {
        extend(plane + v * row, s->numbers, s->numbers, s->count[0]);
    }
    for (size_t u = 0; u < s->count[0] + 2; u++) {
        extend(plane + u * s->numbers, s->numbers, row, s->count[1]);
    }
}

beam_stencil beam_stencil_make(float shift_u, float shift_v)
{
    const float u = fabsf(shift_u), v = fabsf(shift_v);
    const beam_stencil out = {{(1.0f - u) * (1.0f - v), u * (1.0f - v), (1.0f - u) * v, u * v},
                              shift_u > 0.0f ? -1 : 1,
                              shift_v > 0.0f ? -1 : 1};
    return out;
}

static size_t clamped(size_t i, ptrdiff_t step, size_t count)
{
    const bool outside = step < 0 ? i == 0 : i + 1 == count;
    return outside ? i : (size_t)((ptrdiff_t)i + step);
}

/* Where a characteristic's neighbours lie, in numbers. */
typedef struct steps {
    ptrdiff_t depth_u, depth_v;
    size_t sigma_u, sigma_v;
} steps;

static inline four interpolate(const float weight[4], const float *at, ptrdiff_t u, ptrdiff_t v)
{
    return (weight[0] * four_load(at) + weight[1] * four_load(at + u)) +
           (weight[2] * four_load(at + v) + weight[3] * four_load(at + u + v));
}

/* Cells that the light enters by the side: behind the layer its way began at that side. */
static void enter(const beam_sweep *s, size_t u, size_t v, float share, const float *sigma)
{
    float *const next = s->next + beam_place(s, u + 1, v + 1);
    for (size_t n = 0; n < s->numbers; n++) {
        next[n] = sigma[n] * (share * s->length);
    }
}

/* The rows and columns where it does: those at the near side if characteristics go farther than
 * half a cell within a layer. */
static void enter_sides(const beam_sweep *s, const beam_stencil *up, size_t w)
{
    const float *const sigma = s->box->extinction + w * s->stride[2] * CHANNELS;
    const ptrdiff_t way[2] = {up->to_u, up->to_v};
    for (int side = 0; side < 2; side++) {
        const float shift = fabsf(s->shift[side]), other = fabsf(s->shift[1 - side]);
        for (size_t i = 0; shift > 0.5f && i < s->count[1 - side]; i++) {
            const size_t near = way[side] < 0 ? 0 : s->count[side] - 1;
            const bool corner = way[1 - side] < 0 ? i == 0 : i + 1 == s->count[1 - side];
            const float share = 0.5f / (corner ? fmaxf(shift, other) : shift);
            const size_t u = side == 0 ? near : i, v = side == 0 ? i : near;
            enter(s, u, v, share, sigma + (u * s->stride[0] + v * s->stride[1]) * CHANNELS);
        }
    }
}

void beam_close_sides(const beam_sweep *s, const beam_stencil *up, size_t w)
{
    enter_sides(s, up, w);
    extend_plane(s, s->next);
}

/* The optical depths behind layer w from those before it. */
static void carry(const beam_sweep *s, size_t w)
{
    const beam_stencil up = beam_stencil_make(s->shift[0], s->shift[1]);
    const beam_stencil half = beam_stencil_make(0.5f * s->shift[0], 0.5f * s->shift[1]);
    const ptrdiff_t to_u = up.to_u * CHANNELS;
    const ptrdiff_t to_v = up.to_v * (ptrdiff_t)(s->row * CHANNELS);
    const float *const sigma = s->box->extinction + w * s->stride[2] * CHANNELS;
    const size_t step = s->stride[0] * CHANNELS;
    for (size_t v = 0; v < s->count[1]; v++) {
        const float *const row = sigma + v * s->stride[1] * CHANNELS;
        const ptrdiff_t beside =
            (sigma - row) + (ptrdiff_t)(clamped(v, up.to_v, s->count[1]) * s->stride[1] * CHANNELS);
        const float *const depth = s->depth + beam_place(s, 1, v + 1);
        float *const next = s->next + beam_place(s, 1, v + 1);
        for (size_t u = 0; u < s->count[0]; u++) {
            const ptrdiff_t at = (ptrdiff_t)(u * step);
            const ptrdiff_t along = (ptrdiff_t)(clamped(u, up.to_u, s->count[0]) * step) - at;
            const four mean = interpolate(half.weight, row + at, along, beside);
            const four before = interpolate(up.weight, depth + u * CHANNELS, to_u, to_v);
            four_store(next + u * CHANNELS, four_max(before, four_all(0.0f)) + mean * s->length);
        }
    }
    beam_close_sides(s, &up, w);
}

static inline four size_of(four a) { return four_max(a, -a); }

/* Half of how much the depth changes across the cell, between two neighbours of it (at the box's
 * side itself): none at an extremum, not beyond twice what either side has, nor beyond depth 0.
 * Else cells behind steep borders of shadows would be lit through them. */
static inline four half_slope(const float *before, const float *after, ptrdiff_t low,
                              ptrdiff_t high)
{
    const four own = four_load(before) + four_load(after);
    four up = four_load(before + high) + four_load(after + high) - own;
    four down = own - (four_load(before + low) + four_load(after + low));
    up = high == 0 ? down : up;
    down = low == 0 ? up : down;
    const four least = four_min(four_min(size_of(up), size_of(down)), own);
    const four within = four_min(0.125f * size_of(up + down), 0.5f * least);
    return four_select(up * down > 0.0f, within, four_all(0.0f));
}

/* log(sinh(x) / x), by which the mean of exp over an even slope exceeds that of its middle, off by
 * 0.01 up to x = 2.5 and 0.02 up to 5, where it is 2.7. */
static inline four log_spread(four half)
{
    const four size = size_of(half), square = half * half;
    return square / (6.0f + square * 0.2f / (1.0f + size * 0.1f));
}

/* Mean transmittance of a cell from depths and transmittances before and behind it: along the axis
 * exactly, but for rounding where they hardly differ; across it as of even slopes. */
static inline four cell_mean(four depth, four next, four through, four next_through, four spread)
{
    const four change = next - depth, small = change * change;
    const four size = four_max(change, -change);
    const four safe = four_select(size < 0.05f, four_all(1.0f), change);
    const four middle =
        through * (1.0f - change * 0.5f + small * (1.0f / 6.0f - change * (1.0f / 24.0f)));
    const four mean = four_select(size < 0.05f, middle, (through - next_through) / safe);
    const four more = 1.0f / four_exp(-four_min(spread, four_all(BEAM_DEPTH_MOST)));
    return four_min(mean * more, four_all(1.0f));
}

/* Cells of layer w; transmittances behind it replace those before. */
static void average(const beam_sweep *s, size_t w, float *out)
{
    const ptrdiff_t row = (ptrdiff_t)(s->row * CHANNELS);
    float *const layer = out + w * s->stride[2] * CHANNELS;
    for (size_t v = 0; v < s->count[1]; v++) {
        const ptrdiff_t low_v = v == 0 ? 0 : -row, high_v = v + 1 == s->count[1] ? 0 : row;
        for (size_t u = 0; u < s->count[0]; u++) {
            const size_t at = beam_place(s, u + 1, v + 1);
            const float *const before = s->depth + at, *const after = s->next + at;
            const ptrdiff_t low_u = u == 0 ? 0 : -CHANNELS;
            const ptrdiff_t high_u = u + 1 == s->count[0] ? 0 : CHANNELS;
            const four next = four_load(after), through = four_load(s->through + at);
            const four next_through = four_exp(-four_min(next, four_all(BEAM_DEPTH_MOST)));
            const four across = log_spread(half_slope(before, after, low_u, high_u)) +
                                log_spread(half_slope(before, after, low_v, high_v));
            four_store(layer + (v * s->stride[1] + u * s->stride[0]) * CHANNELS,
                       cell_mean(four_load(before), next, through, next_through, across));
            four_store(s->through + at, next_through);
        }
    }
}

void beam_directional_plain(const air_beam_box *box, const float dir[3], void *scratch,
                            float *out_fluence)
{
    beam_sweep s = beam_sweep_make(box, dir, CHANNELS, scratch);
    for (size_t layer = 0; layer < s.count[2]; layer++) {
        const size_t w = s.back ? s.count[2] - 1 - layer : layer;
        carry(&s, w);
        average(&s, w, out_fluence);
        float *const keep = s.depth;
        s.depth = s.next;
        s.next = keep;
    }
}

static beam_directional *version_of(air_cpu cpu)
{
    switch (cpu) {
#if defined(__x86_64__)
    case AIR_CPU_AVX512:
        return beam_directional_avx512;
    case AIR_CPU_AVX2:
        return beam_directional_avx2;
    case AIR_CPU_SSE42:
        return beam_directional_sse42;
#endif
    default:
        return beam_directional_plain;
    }
}

void air_beam_directional(const air_context *context, const air_beam_box *box, const float dir[3],
                          void *scratch, float *out_fluence)
{
    version_of(air_context_cpu(context))(box, dir, scratch, out_fluence);
}

/* ---- points ---- */

/* Cells along the segment, by the distances at which it crosses their planes. */
void air_beam_depth(const air_beam_box *box, const float from[3], const float to[3], float out[4])
{
    float dir[3], t = 0.0f, end = 1.0f, next[3], step[3];
    ptrdiff_t cell[3], way[3];
    four depth = {0.0f};
    float length = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        dir[axis] = to[axis] - from[axis];
        length += dir[axis] * dir[axis];
        const float inverse = 1.0f / dir[axis];
        const float side = box->cell_m[axis] * (float)(ptrdiff_t)box->size[axis];
        const float a = (0.0f - from[axis]) * inverse, b = (side - from[axis]) * inverse;
        const bool inside = from[axis] >= 0.0f && from[axis] <= side;
        if (dir[axis] != 0.0f) {
            t = fmaxf(t, fminf(a, b));
            end = fminf(end, fmaxf(a, b));
        } else if (!inside) {
            end = 0.0f;
        }
    }
    memset(out, 0, CHANNELS * sizeof *out);
    if (!(t < end)) {
        return;
    }
    length = sqrtf(length);
    for (int axis = 0; axis < 3; axis++) {
        const float at = (from[axis] + t * dir[axis]) / box->cell_m[axis];
        const float last = (float)(ptrdiff_t)box->size[axis] - 1.0f;
        cell[axis] = (ptrdiff_t)fminf(fmaxf(floorf(at), 0.0f), last);
        way[axis] = dir[axis] < 0.0f ? -1 : 1;
        step[axis] = dir[axis] != 0.0f ? fabsf(box->cell_m[axis] / dir[axis]) : INFINITY;
        const float plane = (float)(cell[axis] + (dir[axis] < 0.0f ? 0 : 1)) * box->cell_m[axis];
        next[axis] = dir[axis] != 0.0f ? (plane - from[axis]) / dir[axis] : INFINITY;
    }
    while (t < end) {
        const int axis =
            next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        const float stop = fminf(next[axis], end);
        const size_t at =
            ((size_t)cell[2] * box->size[1] + (size_t)cell[1]) * box->size[0] + (size_t)cell[0];
        depth += four_load(box->extinction + at * CHANNELS) * (fmaxf(stop - t, 0.0f) * length);
        t = fmaxf(t, stop);
        cell[axis] += way[axis];
        next[axis] += step[axis];
        if (cell[axis] < 0 || cell[axis] >= (ptrdiff_t)box->size[axis]) {
            break;
        }
    }
    four_store(out, depth);
}

static void cell_center(const air_beam_box *box, const size_t cell[3], float out[3])
{
    for (int axis = 0; axis < 3; axis++) {
        out[axis] = ((float)(ptrdiff_t)cell[axis] + 0.5f) * box->cell_m[axis];
    }
}

void air_beam_point(const air_beam_box *box, const float position[3], float *out)
{
    size_t cell[3], at = 0;
    for (cell[2] = 0; cell[2] < box->size[2]; cell[2]++) {
        for (cell[1] = 0; cell[1] < box->size[1]; cell[1]++) {
            for (cell[0] = 0; cell[0] < box->size[0]; cell[0]++, at += CHANNELS) {
                float center[3], depth[CHANNELS];
                cell_center(box, cell, center);
                air_beam_depth(box, position, center, depth);
                const four d = four_load(depth);
                four_store(out + at, four_exp(-four_min(d, four_all(BEAM_DEPTH_MOST))));
            }
        }
    }
}

/* Over a ball of the cell's volume about its centre, at distance r from the point: the mean of
 * 1/s^2 is 3/(4 R^3) (2 R + (R^2 - r^2)/r ln((r + R)/|r - R|)) for any r; far away 1/r^2. */
static float ball_mean(double radius, double r)
{
    const double x = r / radius;
    if (x > 6.0) {
        return (float)(1.0 / (r * r) * (1.0 + 0.2 / (x * x)));
    }
    const double near = fabs(x - 1.0) < 1e-9 ? 0.0 : (1.0 - x * x) * log((1.0 + x) / fabs(1.0 - x));
    const double sum = x < 1e-4 ? 4.0 : 2.0 + near / x;
    return (float)(0.75 * sum / (radius * radius));
}

void air_beam_spread(const air_beam_box *box, const float position[3], float *out)
{
    const double volume = (double)box->cell_m[0] * (double)box->cell_m[1] * (double)box->cell_m[2];
    const double radius = cbrt(0.75 / AIR_PI * volume);
    size_t cell[3], at = 0;
    for (cell[2] = 0; cell[2] < box->size[2]; cell[2]++) {
        for (cell[1] = 0; cell[1] < box->size[1]; cell[1]++) {
            for (cell[0] = 0; cell[0] < box->size[0]; cell[0]++, at++) {
                float center[3];
                double square = 0.0;
                cell_center(box, cell, center);
                for (int axis = 0; axis < 3; axis++) {
                    const double d = (double)center[axis] - (double)position[axis];
                    square += d * d;
                }
                out[at] = ball_mean(radius, sqrt(square));
            }
        }
    }
}
