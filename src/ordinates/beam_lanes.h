/* beam_lanes.h: a beam's sweep for the instruction set of the including file, which defines
 * BEAM_DIRECTIONAL as the function's name. Lanes are CELLS neighbours of a row times four numbers,
 * or neighbours alone where all numbers of each cell are alike.
 *
 * Stretches are worked through in whole vectors: rows, of single numbers all rows with the border
 * between them. What is behind their end is border, which is set afterwards, or room that nobody
 * looks at. */
#include "core/lanes_float.h"
#include "ordinates/beam.h"
#include "ordinates/four.h"

typedef uint32_t lane_bits __attribute__((vector_size(4 * LANES)));

enum { CELLS = LANES / BEAM_CHANNELS, BYTES = BEAM_CHANNELS * sizeof(float) };

/* exp(x) for x in [-80, 80], beyond which it is anything: see core/exponential.h; relative error
 * 3e-7. */
static inline lanes beam_exp(lanes x)
{
    const lanes magic = lanes_all(0x1.8p23f), one = lanes_all(1.0f);
    const lanes shifted = lanes_madd(x, lanes_all(1.44269504f), magic), n = shifted - magic;
    const lanes r =
        lanes_nmadd(n, lanes_all(-2.12194440e-4f), lanes_nmadd(n, lanes_all(0.693359375f), x));
    const lanes r2 = r * r;
    const lanes p23 = lanes_madd(r, lanes_all(1.0f / 6.0f), lanes_all(0.5f));
    const lanes p45 = lanes_madd(r, lanes_all(1.0f / 120.0f), lanes_all(1.0f / 24.0f));
    const lanes p67 = lanes_madd(r, lanes_all(1.0f / 5040.0f), lanes_all(1.0f / 720.0f));
    const lanes p = lanes_madd(r2, lanes_madd(r2, lanes_madd(r2, p67, p45), p23), r);
    const lanes power = (lanes)(((lane_bits)shifted << 23) + (lane_bits)one);
    return lanes_madd(p, power, power);
}

/* ---- one number for all ---- */

#if defined(__AVX512F__) && defined(__AVX512DQ__)
static inline lanes first_of_four(lanes a) { return _mm512_permute_ps(a, 0); }
#elif defined(__AVX2__) && defined(__FMA__)
static inline lanes first_of_four(lanes a) { return _mm256_permute_ps(a, 0); }
#else
static inline lanes first_of_four(lanes a) { return _mm_shuffle_ps(a, a, 0); }
#endif

/* But for the roundings of a mean of three. */
static inline bool are_alike(lanes fours)
{
    const lanes first = first_of_four(fours);
    return !mask_any(lanes_less(first * lanes_all(3e-7f), lanes_abs(fours - first)));
}

static bool is_grey(const air_beam_box *box)
{
    const size_t count = box->size[0] * box->size[1] * box->size[2] * BEAM_CHANNELS;
    float rest[LANES] = {0.0f};
    size_t n = 0;
    for (; n + LANES <= count; n += LANES) {
        if (!are_alike(lanes_load(box->extinction + n))) {
            return false;
        }
    }
    memcpy(rest, box->extinction + n, (count - n) * sizeof *rest);
    return are_alike(lanes_load(rest));
}

/* ---- planes ---- */

static inline size_t stretches(const beam_sweep *s, size_t numbers)
{
    return numbers == 1 ? 1 : s->count[1];
}

static inline size_t stretch_length(const beam_sweep *s, size_t numbers)
{
    return numbers == 1 ? (s->count[1] - 1) * s->row + s->count[0] : s->count[0] * numbers;
}

/* The extinction of layer w; the border is like the cells beside it. */
static inline void pack_layer(const beam_sweep *s, size_t numbers, size_t w)
{
    const float *const layer = s->box->extinction + w * s->stride[2] * BEAM_CHANNELS;
    const size_t row = s->row * numbers, step = s->stride[0] * BEAM_CHANNELS;
    const size_t bytes = numbers * sizeof(float);
    for (size_t v = 0; v < s->count[1]; v++) {
        const float *const from = layer + v * s->stride[1] * BEAM_CHANNELS;
        float *const to = s->sigma + beam_place(s, 0, v + 1);
        for (size_t u = 0; u < s->count[0]; u++) {
            memcpy(to + (u + 1) * numbers, from + u * step, bytes);
        }
        memcpy(to, to + numbers, bytes);
        memcpy(to + (s->count[0] + 1) * numbers, to + s->count[0] * numbers, bytes);
    }
    memcpy(s->sigma, s->sigma + row, row * sizeof(float));
    float *const last = s->sigma + (s->count[1] + 1) * row;
    memcpy(last, last - row, row * sizeof(float));
}

static inline lanes interpolate(const lanes weight[4], const float *at, ptrdiff_t u, ptrdiff_t v)
{
    const lanes a = lanes_madd(weight[1], lanes_load(at + u), weight[0] * lanes_load(at));
    return lanes_madd(weight[3], lanes_load(at + u + v),
                      lanes_madd(weight[2], lanes_load(at + v), a));
}

/* The optical depths behind a layer from those before it. */
static inline void carry(const beam_sweep *s, size_t numbers, const beam_stencil *up)
{
    const beam_stencil half = beam_stencil_make(0.5f * s->shift[0], 0.5f * s->shift[1]);
    const ptrdiff_t u = up->to_u * (ptrdiff_t)numbers;
    const ptrdiff_t v = up->to_v * (ptrdiff_t)(s->row * numbers);
    const size_t length = stretch_length(s, numbers);
    lanes depths[4], sigmas[4];
    for (int i = 0; i < 4; i++) {
        depths[i] = lanes_all(up->weight[i]);
        sigmas[i] = lanes_all(half.weight[i] * s->length);
    }
    for (size_t j = 0; j < stretches(s, numbers); j++) {
        const size_t begin = beam_place(s, 1, j + 1);
        for (size_t n = begin; n < begin + length; n += LANES) {
            const lanes before = interpolate(depths, s->depth + n, u, v);
            lanes_store(s->next + n, lanes_max(before, lanes_all(0.0f)) +
                                         interpolate(sigmas, s->sigma + n, u, v));
        }
    }
}

/* Beyond the outermost of `count` cells the line through the last two goes on. */
static inline void go_on(float *plane, size_t numbers, size_t step, size_t count)
{
    const size_t by = count > 1 ? step : 0;
    float *const low = plane, *const high = plane + (count + 1) * step;
    for (size_t c = 0; c < numbers; c++) {
        low[c] = 2.0f * low[step + c] - low[step + by + c];
        high[c] = 2.0f * (high - step)[c] - (high - step - by)[c];
    }
}

static inline void sum_depths(const beam_sweep *s, size_t numbers)
{
    const size_t row = s->row * numbers, length = stretch_length(s, numbers);
    for (size_t j = 0; j < stretches(s, numbers); j++) {
        const size_t begin = beam_place(s, 1, j + 1);
        for (size_t n = begin; n < begin + length; n += LANES) {
            lanes_store(s->sum + n, lanes_load(s->depth + n) + lanes_load(s->next + n));
        }
    }
    for (size_t v = 1; v <= s->count[1]; v++) {
        go_on(s->sum + v * row, numbers, numbers, s->count[0]);
    }
    for (size_t u = 1; u <= s->count[0]; u++) {
        go_on(s->sum + u * numbers, numbers, row, s->count[1]);
    }
}

/* ---- means ---- */

/* log(sinh(x) / x) as numerator and denominator; see beam.c. Above 1000 it is more than is looked
 * at. */
static inline lanes spread_above(lanes half, lanes square)
{
    return square * lanes_madd(half, lanes_all(0.1f), lanes_all(1.0f));
}

static inline lanes spread_below(lanes half, lanes square)
{
    return lanes_madd(square, lanes_all(0.2f), lanes_madd(half, lanes_all(0.6f), lanes_all(6.0f)));
}

/* Half of how much the depth changes across the cell; see beam.c. sum: of the depths before and
 * behind it. */
static inline lanes half_slope(const float *sum, size_t step)
{
    const lanes own = lanes_load(sum), none = lanes_all(0.0f), half = lanes_all(0.5f);
    const lanes up = lanes_load(sum + step) - own, down = own - lanes_load(sum - step);
    const lanes least = lanes_min(lanes_min(lanes_abs(up), lanes_abs(down)), own);
    const lanes within = lanes_min(lanes_abs(up + down) * lanes_all(0.125f), least * half);
    const lanes some = lanes_select(lanes_less(none, up * down), within, none);
    return lanes_min(some, lanes_all(1000.0f));
}

/* Of the slopes along u and v together. */
static inline lanes spread_of(const float *sum, size_t numbers, size_t row)
{
    const lanes u = half_slope(sum, numbers), u2 = u * u;
    const lanes v = half_slope(sum, row), v2 = v * v;
    const lanes below_u = spread_below(u, u2), below_v = spread_below(v, v2);
    const lanes above = lanes_madd(spread_above(u, u2), below_v, spread_above(v, v2) * below_u);
    return above * lanes_inverse(below_u * below_v);
}

static inline lanes cell_mean(lanes depth, lanes next, lanes through, lanes next_through,
                              lanes spread)
{
    const lanes one = lanes_all(1.0f), change = next - depth;
    const lane_mask hardly = lanes_less(lanes_abs(change), lanes_all(0.05f));
    const lanes bend = lanes_nmadd(change, lanes_all(1.0f / 24.0f), lanes_all(1.0f / 6.0f));
    const lanes series =
        lanes_madd(change * change, bend, lanes_nmadd(change, lanes_all(0.5f), one));
    const lanes mean =
        lanes_select(hardly, through * series,
                     (through - next_through) * lanes_inverse(lanes_select(hardly, one, change)));
    return lanes_min(mean * beam_exp(lanes_min(spread, lanes_all(BEAM_DEPTH_MOST))), one);
}

/* Numbers from `at` of planes on; transmittances behind replace those before. */
static inline lanes mean_at(const beam_sweep *s, size_t numbers, size_t at)
{
    const lanes next = lanes_load(s->next + at), through = lanes_load(s->through + at);
    const lanes most = lanes_all(BEAM_DEPTH_MOST);
    const lanes behind = beam_exp(lanes_all(0.0f) - lanes_min(next, most));
    lanes_store(s->through + at, behind);
    return cell_mean(lanes_load(s->depth + at), next, through, behind,
                     spread_of(s->sum + at, numbers, s->row * numbers));
}

static inline void give(const beam_sweep *s, lanes mean, size_t u, float *row)
{
    float numbers[LANES];
    lanes_store(numbers, mean);
    for (size_t n = 0; n < CELLS && u + n < s->count[0]; n++) {
        memcpy(row + (u + n) * s->stride[0] * BEAM_CHANNELS, numbers + n * BEAM_CHANNELS, BYTES);
    }
}

/* Cells of a layer. */
static void average(const beam_sweep *s, float *layer)
{
    for (size_t v = 0; v < s->count[1]; v++) {
        float *const to = layer + v * s->stride[1] * BEAM_CHANNELS;
        for (size_t u = 0; u < s->count[0]; u += CELLS) {
            const lanes mean = mean_at(s, BEAM_CHANNELS, beam_place(s, u + 1, v + 1));
            if (s->stride[0] == 1 && u + CELLS <= s->count[0]) {
                lanes_store(to + u * BEAM_CHANNELS, mean);
            } else {
                give(s, mean, u, to);
            }
        }
    }
}

/* The same of single numbers, which take the place of extinctions, that are no longer needed. */
static void average_grey(const beam_sweep *s, float *layer)
{
    const size_t begin = beam_place(s, 1, 1), end = begin + stretch_length(s, 1);
    for (size_t n = begin; n < end; n += LANES) {
        lanes_store(s->sigma + n, mean_at(s, 1, n));
    }
    for (size_t v = 0; v < s->count[1]; v++) {
        const float *const from = s->sigma + beam_place(s, 1, v + 1);
        float *const to = layer + v * s->stride[1] * BEAM_CHANNELS;
        for (size_t u = 0; u < s->count[0]; u++) {
            four_store(to + u * s->stride[0] * BEAM_CHANNELS, four_all(from[u]));
        }
    }
}

static inline void sweep(const air_beam_box *box, const float dir[3], size_t numbers, void *scratch,
                         float *out)
{
    beam_sweep s = beam_sweep_make(box, dir, numbers, scratch);
    const beam_stencil up = beam_stencil_make(s.shift[0], s.shift[1]);
    for (size_t layer = 0; layer < s.count[2]; layer++) {
        const size_t w = s.back ? s.count[2] - 1 - layer : layer;
        pack_layer(&s, numbers, w);
        carry(&s, numbers, &up);
        beam_close_sides(&s, &up, w);
        sum_depths(&s, numbers);
        (numbers == 1 ? average_grey : average)(&s, out + w * s.stride[2] * BEAM_CHANNELS);
        float *const keep = s.depth;
        s.depth = s.next;
        s.next = keep;
    }
}

void BEAM_DIRECTIONAL(const air_beam_box *box, const float dir[3], void *scratch,
                      float *out_fluence)
{
    if (is_grey(box)) {
        sweep(box, dir, 1, scratch, out_fluence);
    } else {
        sweep(box, dir, BEAM_CHANNELS, scratch, out_fluence);
    }
}
