/* dom_lanes.h: the solver's kernel for the instruction set of the including file, which defines
 * DOM_KERNEL as its name. Lanes are directions of an octant times four channels. */
#include "core/lanes_float.h"
#include "core/vec.h"
#include "ordinates/dom.h"
#include "ordinates/four.h"

enum { CHANNELS = AIR_DOM_STRIDE, WAYS = LANES / CHANNELS /* directions in a vector */ };

#if defined(__AVX512F__) && defined(__AVX512DQ__)

/* Four numbers to every direction. */
static inline lanes lanes_repeat(const float *p) { return _mm512_broadcast_f32x4(_mm_loadu_ps(p)); }

/* The sums over directions of four vectors, one behind the other. */
static inline void lanes_fold(const lanes *a, float *out)
{
    const __m512 ab = _mm512_add_ps(_mm512_shuffle_f32x4(a[0], a[1], 0x44),
                                    _mm512_shuffle_f32x4(a[0], a[1], 0xee));
    const __m512 cd = _mm512_add_ps(_mm512_shuffle_f32x4(a[2], a[3], 0x44),
                                    _mm512_shuffle_f32x4(a[2], a[3], 0xee));
    const __m512 even = _mm512_shuffle_f32x4(ab, cd, 0x88),
                 odd = _mm512_shuffle_f32x4(ab, cd, 0xdd);
    _mm512_storeu_ps(out, _mm512_add_ps(even, odd));
}

#elif defined(__AVX2__) && defined(__FMA__)

static inline lanes lanes_repeat(const float *p) { return _mm256_broadcast_ps((const __m128 *)p); }

static inline void lanes_fold(const lanes *a, float *out)
{
    for (int i = 0; i < 4; i += 2) {
        const __m256 even = _mm256_permute2f128_ps(a[i], a[i + 1], 0x20);
        const __m256 odd = _mm256_permute2f128_ps(a[i], a[i + 1], 0x31);
        _mm256_storeu_ps(out + i * CHANNELS, _mm256_add_ps(even, odd));
    }
}

#else

static inline lanes lanes_repeat(const float *p) { return _mm_loadu_ps(p); }

static inline void lanes_fold(const lanes *a, float *out)
{
    for (int i = 0; i < 4; i++) {
        _mm_storeu_ps(out + i * CHANNELS, a[i]);
    }
}

#endif

/* The sums of all eight, and their differences under mirrorings: its own inverse but for a factor
 * of eight. */
static inline void transform_octants(lanes p[DOM_OCTANTS])
{
    for (int step = 1; step < DOM_OCTANTS; step *= 2) {
        for (int i = 0; i < DOM_OCTANTS; i++) {
            if ((i & step) == 0) {
                const lanes a = p[i], b = p[i | step];
                p[i] = a + b;
                p[i | step] = a - b;
            }
        }
    }
}

/* ---- sources ---- */

/* What a cell's moments scatter, but for sigma_s, and g_l where that is uniform. */
static inline void stage_moments(const air_dom *dom, size_t cell, int bands, float *out)
{
    const size_t count = (size_t)(bands * bands) * CHANNELS;
    const float *const field = dom->field.f + cell * count;
    const float *const light = dom->light.f + cell * count;
    const float *const phase = dom->phase.f + cell * (size_t)bands * CHANNELS;
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        lanes_store(out + i, lanes_load(field + i) + lanes_load(light + i));
    }
    for (; i < count; i += CHANNELS) {
        four_store(out + i, four_load(field + i) + four_load(light + i));
    }
    for (i = 0; i < count && !dom->uniform; i += CHANNELS) {
        const four g = four_load(phase + dom->band_of[i / CHANNELS] * CHANNELS);
        four_store(out + i, four_load(out + i) * g);
    }
}

/* Series of peaked phase functions dip below 0: what is negative goes, and the rest is scaled so
 * that as much is sent as before. total: of each channel. */
static void keep_positive(const air_dom *dom, size_t cell, const float *total)
{
    const lanes zero = lanes_all(0.0f);
    lanes sums[4] = {zero, zero, zero, zero};
    float positive[4 * CHANNELS], factors[CHANNELS];
    for (size_t o = 0; o < dom->row; o += LANES) {
        const lanes weight = lanes_load(dom->weights.f + o);
        for (size_t octant = 0; octant < DOM_OCTANTS; octant++) {
            const float *const at = dom->radiance.f + dom_radiance(dom, octant, cell) + o;
            sums[0] = lanes_madd(weight, lanes_max(lanes_load(at), zero), sums[0]);
        }
    }
    lanes_fold(sums, positive);
    for (int c = 0; c < CHANNELS; c++) {
        factors[c] = positive[c] > 0.0f ? float_max(total[c], 0.0f) / positive[c] : 0.0f;
    }
    const lanes factor = lanes_repeat(factors);
    for (size_t octant = 0; octant < DOM_OCTANTS; octant++) {
        float *const at = dom->radiance.f + dom_radiance(dom, octant, cell);
        for (size_t o = 0; o < dom->row; o += LANES) {
            lanes_store(at + o, lanes_max(lanes_load(at + o), zero) * factor);
        }
    }
}

static inline void emit_cell(air_dom *dom, size_t cell, int bands)
{
    const int *const begin = dom_class_begin[bands];
    float staged[DOM_MOMENTS_MAX * CHANNELS], total[CHANNELS];
    const lanes sigma_s = lanes_repeat(dom->sigma_s.f + cell * CHANNELS), zero = lanes_all(0.0f);
    lanes least = zero;
    stage_moments(dom, cell, bands, staged);
    for (size_t o = 0; o < dom->row; o += LANES) {
        lanes p[DOM_OCTANTS];
#pragma GCC unroll 8
        for (int class = 0; class < DOM_OCTANTS; class ++) {
            p[class] = zero;
            for (int m = begin[class]; m < begin[class + 1]; m++) {
                p[class] = lanes_madd(lanes_load(dom->emitting.f + (size_t)m * dom->row + o),
                                      lanes_repeat(staged + m * CHANNELS), p[class]);
            }
            p[class] = p[class] * sigma_s;
        }
        transform_octants(p);
        for (size_t octant = 0; octant < DOM_OCTANTS; octant++) {
            least = lanes_min(least, p[octant]);
            lanes_store(dom->radiance.f + dom_radiance(dom, octant, cell) + o, p[octant]);
        }
    }
    if (mask_any(lanes_less(least, zero))) {
        for (int c = 0; c < CHANNELS; c++) {
            total[c] = 3.5449077f * staged[c] * dom->sigma_s.f[cell * CHANNELS + (size_t)c];
        }
        keep_positive(dom, cell, total);
    }
}

/* The usual number of bands is written out, so that its loops have constant bounds. */
static void emit(air_dom *dom, size_t k)
{
    for (size_t cell = k * dom->slab; cell < (k + 1) * dom->slab; cell++) {
        if (dom->params.bands == 4) {
            emit_cell(dom, cell, 4);
        } else {
            emit_cell(dom, cell, dom->params.bands);
        }
    }
}

/* ---- sweeps ---- */

typedef struct slopes {
    lanes x, y, z, sum; /* 2 |O| / cell_m */
} slopes;

/* Steps where diamond differences left a negative number. */
static lanes step_instead(const slopes *s, lanes source, lanes sigma_t, lane_mask negative,
                          const lanes in[3], lanes psi, lanes out[3])
{
    const lanes half = lanes_all(0.5f);
    const lanes arrived = lanes_madd(s->x, in[0], lanes_madd(s->y, in[1], s->z * in[2]));
    const lanes step =
        lanes_madd(half, arrived, source) * lanes_inverse(lanes_madd(half, s->sum, sigma_t));
    for (int axis = 0; axis < 3; axis++) {
        out[axis] = lanes_select(negative, step, out[axis]);
    }
    return lanes_select(negative, step, psi);
}

static inline lanes pass_cell(const slopes *s, bool diamond, lanes source, lanes sigma_t, lanes *x,
                              float *y, float *z)
{
    const lanes zero = lanes_all(0.0f), two = lanes_all(2.0f);
    const lanes in[3] = {*x, lanes_load(y), lanes_load(z)};
    const lanes inverse = lanes_inverse(sigma_t + s->sum);
    const lanes rest = lanes_madd(s->y, in[1], lanes_madd(s->z, in[2], source));
    lanes psi = lanes_madd(s->x, in[0], rest) * inverse, out[3];
    lane_mask negative = lanes_less(zero, lanes_all(1.0f));
    for (int axis = 0; axis < 3; axis++) {
        out[axis] = lanes_madd(two, psi, zero - in[axis]);
    }
    if (diamond) {
        negative = lanes_less(lanes_min(out[0], lanes_min(out[1], out[2])), zero);
    }
    if (mask_any(negative)) {
        psi = step_instead(s, source, sigma_t, negative, in, psi, out);
    }
    *x = out[0];
    lanes_store(y, out[1]);
    lanes_store(z, out[2]);
    return psi;
}

/* A row along x, from the side that the octant's light comes from. */
static void sweep_row(air_dom *dom, int octant, size_t j, size_t k)
{
    const size_t n = dom->params.size[0], row = dom->row;
    const bool back = (octant & 1) != 0, diamond = dom->params.diamond;
    const bool lit = (dom->inflow_faces >> (octant & 1)) & 1u;
    const size_t first = k * dom->slab + j * n;
    float *const radiance = dom->radiance.f + dom_radiance(dom, (size_t)octant, first);
    float *const face_x = dom->face_x.f + ((size_t)octant * dom->params.size[1] + j) * row;
    float *const face_y = dom->face_y.f + (size_t)octant * n * row;
    float *const face_z = dom->face_z.f + ((size_t)octant * dom->slab + j * n) * row;
    for (size_t o = 0; o < row; o += LANES) {
        slopes s = {lanes_load(dom->slope[0].f + o), lanes_load(dom->slope[1].f + o),
                    lanes_load(dom->slope[2].f + o), lanes_all(0.0f)};
        lanes x = lit ? lanes_load(dom->inflow.f + (size_t)octant * row + o) : lanes_all(0.0f);
        s.sum = s.x + s.y + s.z;
        for (size_t step = 0; step < n; step++) {
            const size_t i = back ? n - 1 - step : step, at = i * row + o;
            const lanes sigma_t = lanes_repeat(dom->sigma_t.f + (first + i) * CHANNELS);
            const lanes psi = pass_cell(&s, diamond, lanes_load(radiance + at), sigma_t, &x,
                                        face_y + at, face_z + at);
            lanes_store(radiance + at, psi);
        }
        lanes_store(face_x + o, x);
    }
}

/* What enters through a face of the box, or nothing. */
static void enter(const air_dom *dom, int octant, int axis, float *face, size_t places)
{
    const int side = octant >> axis & 1;
    if (((dom->inflow_faces >> (2 * axis + side)) & 1u) == 0) {
        memset(face, 0, places * dom->row * sizeof *face);
        return;
    }
    for (size_t i = 0; i < places; i++) {
        memcpy(face + i * dom->row, dom->inflow.f + (size_t)octant * dom->row,
               dom->row * sizeof *face);
    }
}

/* Adds up what leaves at a line of places, which is short enough for floats. */
static void leave(const air_dom *dom, double *sum, const float *face, size_t places)
{
    for (size_t o = 0; o < dom->row; o += LANES) {
        lanes part = lanes_all(0.0f);
        for (size_t i = 0; i < places; i++) {
            part += lanes_load(face + i * dom->row + o);
        }
        for (int lane = 0; lane < LANES; lane++) {
            sum[o + (size_t)lane] += (double)part[lane];
        }
    }
}

static void sweep(air_dom *dom, int octant)
{
    const size_t *const n = dom->params.size, row = dom->row;
    double *const leaving = dom->leaving + (size_t)octant * 3 * row;
    float *const face_y = dom->face_y.f + (size_t)octant * n[0] * row;
    float *const face_z = dom->face_z.f + (size_t)octant * dom->slab * row;
    memset(leaving, 0, 3 * row * sizeof *leaving);
    enter(dom, octant, 2, face_z, dom->slab);
    for (size_t slab = 0; slab < n[2]; slab++) {
        const size_t k = (octant & 4) != 0 ? n[2] - 1 - slab : slab;
        enter(dom, octant, 1, face_y, n[0]);
        for (size_t line = 0; line < n[1]; line++) {
            sweep_row(dom, octant, (octant & 2) != 0 ? n[1] - 1 - line : line, k);
        }
        leave(dom, leaving, dom->face_x.f + (size_t)octant * n[1] * row, n[1]);
        leave(dom, leaving + row, face_y, n[0]);
    }
    for (size_t j = 0; j < n[1]; j++) {
        leave(dom, leaving + 2 * row, face_z + j * n[0] * row, n[0]);
    }
}

/* ---- moments ---- */

static inline void gather_cell(air_dom *dom, size_t cell, int bands)
{
    const int *const begin = dom_class_begin[bands], moments = bands * bands;
    lanes sums[DOM_MOMENTS_MAX + 3];
    float folded[4 * CHANNELS];
    float *const next = dom->next.f + cell * (size_t)moments * CHANNELS;
    for (int m = 0; m < moments + 3; m++) {
        sums[m] = lanes_all(0.0f);
    }
    for (size_t o = 0; o < dom->row; o += LANES) {
        lanes p[DOM_OCTANTS];
        for (size_t octant = 0; octant < DOM_OCTANTS; octant++) {
            p[octant] = lanes_load(dom->radiance.f + dom_radiance(dom, octant, cell) + o);
        }
        transform_octants(p);
#pragma GCC unroll 8
        for (int class = 0; class < DOM_OCTANTS; class ++) {
            for (int m = begin[class]; m < begin[class + 1]; m++) {
                sums[m] = lanes_madd(lanes_load(dom->gathering.f + (size_t)m * dom->row + o),
                                     p[class], sums[m]);
            }
        }
    }
    int m = 0;
    for (; m + 4 <= moments; m += 4) {
        lanes_fold(sums + m, next + m * CHANNELS);
    }
    if (m < moments) {
        lanes_fold(sums + m, folded);
        memcpy(next + m * CHANNELS, folded, (size_t)(moments - m) * sizeof(four));
    }
}

/* Squares of what a sweep changes in a slab, and of what it leaves; counts are multiples of four.
 */
static dom_sums compare(const air_dom *dom, size_t begin, size_t end)
{
    lanes change = lanes_all(0.0f), size = lanes_all(0.0f);
    dom_sums sums = {0.0, 0.0};
    size_t i = begin;
    for (; i + LANES <= end; i += LANES) {
        const lanes next = lanes_load(dom->next.f + i), d = next - lanes_load(dom->field.f + i);
        change = lanes_madd(d, d, change);
        size = lanes_madd(next, next, size);
    }
    for (int lane = 0; lane < LANES; lane++) {
        sums.change += (double)change[lane];
        sums.size += (double)size[lane];
    }
    for (; i < end; i++) {
        const double next = (double)dom->next.f[i], d = next - (double)dom->field.f[i];
        sums.change += d * d;
        sums.size += next * next;
    }
    return sums;
}

static void gather(air_dom *dom, size_t k)
{
    size_t begin, end;
    dom_slab_range(dom, k, &begin, &end);
    for (size_t cell = k * dom->slab; cell < (k + 1) * dom->slab; cell++) {
        if (dom->params.bands == 4) {
            gather_cell(dom, cell, 4);
        } else {
            gather_cell(dom, cell, dom->params.bands);
        }
    }
    dom->sums[k] = compare(dom, begin, end);
}

/* ---- vectors: counts are multiples of four ---- */

/* In parts, so that what is summed in floats stays short. */
static double dot(const dom_array *a, const dom_array *b, size_t begin, size_t end)
{
    enum { PART = 1024 };
    double total = 0.0;
    for (size_t i = begin; i < end;) {
        const size_t stop = end - i < PART ? end : i + PART;
        four sum = {0.0f};
        for (; i < stop; i += CHANNELS) {
            sum += four_load(a->f + i) * four_load(b->f + i);
        }
        total += (double)((sum[0] + sum[1]) + (sum[2] + sum[3]));
    }
    return total;
}

static void subtract(const dom_array *a, const dom_array *b, dom_array *out, size_t begin,
                     size_t end)
{
    for (size_t i = begin; i < end; i += CHANNELS) {
        four_store(out->f + i, four_load(a->f + i) - four_load(b->f + i));
    }
}

static void combine(const dom_array *a, const dom_array *parts, const double *factors, int count,
                    dom_array *out, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i += CHANNELS) {
        four sum = four_load(a->f + i);
        for (int part = 0; part < count; part++) {
            sum -= (float)factors[part] * four_load(parts[part].f + i);
        }
        four_store(out->f + i, sum);
    }
}

const dom_kernel DOM_KERNEL = {emit, sweep, gather, dot, subtract, combine};
