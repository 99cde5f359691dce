/* dom_lanes.h: the solver's kernel for the instruction set of the including file, which defines
 * DOM_KERNEL as its name. Lanes are directions of an octant times four channels. */
#include "core/lanes_float.h"
#include "core/vec.h"
#include "ordinates/dom_channels.h"
#include "ordinates/dom_lanes_sweep.h"

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

/* What a cell's moments scatter, but for g_l where that is uniform. */
static inline void stage_moments(const air_dom *dom, const float *moments, size_t cell, int bands,
                                 float *out)
{
    const size_t count = (size_t)(bands * bands) * CHANNELS;
    const float *const light = dom->light.f + cell * count;
    const float *const phase = dom->phase.f + cell * (size_t)bands * CHANNELS;
    const lanes sigma_s = lanes_repeat(dom->sigma_s.f + cell * CHANNELS);
    const four sigma_s_4 = four_load(dom->sigma_s.f + cell * CHANNELS);
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        lanes_store(out + i, (lanes_load(moments + i) + lanes_load(light + i)) * sigma_s);
    }
    for (; i < count; i += CHANNELS) {
        four_store(out + i, (four_load(moments + i) + four_load(light + i)) * sigma_s_4);
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

/* Sums over the moments of each class, for directions o on and the vector after those: two sums
 * that do not wait for each other, of moments that are fetched once. */
static inline void emit_pair(const air_dom *dom, const float *staged, int bands, size_t o,
                             lanes p[DOM_OCTANTS], lanes q[DOM_OCTANTS])
{
    const int *const begin = dom_class_begin[bands];
    const float *const emitting = dom->emitting.f + o;
#pragma GCC unroll 8
    for (int class = 0; class < DOM_OCTANTS; class ++) {
        lanes a = lanes_all(0.0f), b = a;
        for (int m = begin[class]; m < begin[class + 1]; m++) {
            const lanes moment = lanes_repeat(staged + m * CHANNELS);
            a = lanes_madd(lanes_load(emitting + (size_t)m * dom->row), moment, a);
            b = lanes_madd(lanes_load(emitting + (size_t)m * dom->row + LANES), moment, b);
        }
        p[class] = a;
        q[class] = b;
    }
}

static inline void emit_one(const air_dom *dom, const float *staged, int bands, size_t o,
                            lanes p[DOM_OCTANTS])
{
    const int *const begin = dom_class_begin[bands];
#pragma GCC unroll 8
    for (int class = 0; class < DOM_OCTANTS; class ++) {
        p[class] = lanes_all(0.0f);
        for (int m = begin[class]; m < begin[class + 1]; m++) {
            p[class] = lanes_madd(lanes_load(dom->emitting.f + (size_t)m * dom->row + o),
                                  lanes_repeat(staged + m * CHANNELS), p[class]);
        }
    }
}

/* From classes to octants; returns the least of `least` and all. */
static inline lanes send(air_dom *dom, size_t cell, size_t o, lanes p[DOM_OCTANTS], lanes least)
{
    float *const radiance = dom->radiance.f + dom_radiance(dom, 0, cell) + o;
    transform_octants(p);
#pragma GCC unroll 8
    for (size_t octant = 0; octant < DOM_OCTANTS; octant++) {
        least = lanes_min(least, p[octant]);
        lanes_store(radiance + octant * dom->octant, p[octant]);
    }
    return least;
}

static inline void emit_cell(air_dom *dom, const float *moments, size_t cell, int bands)
{
    float staged[DOM_MOMENTS_MAX * CHANNELS], total[CHANNELS];
    lanes least = lanes_all(0.0f), p[DOM_OCTANTS], q[DOM_OCTANTS];
    size_t o = 0;
    stage_moments(dom, moments, cell, bands, staged);
    for (; o + 2 * LANES <= dom->row; o += 2 * LANES) {
        emit_pair(dom, staged, bands, o, p, q);
        least = send(dom, cell, o, p, least);
        least = send(dom, cell, o + LANES, q, least);
    }
    for (; o < dom->row; o += LANES) {
        emit_one(dom, staged, bands, o, p);
        least = send(dom, cell, o, p, least);
    }
    if (mask_any(lanes_less(least, lanes_all(0.0f)))) {
        for (int c = 0; c < CHANNELS; c++) {
            total[c] = 3.5449077f * staged[c];
        }
        keep_positive(dom, cell, total);
    }
}

/* The usual number of bands is written out, so that its loops have constant bounds. */
static void emit(air_dom *dom, const dom_array *field, size_t k)
{
    const size_t count = (size_t)dom->moments * CHANNELS;
    for (size_t cell = k * dom->slab; cell < (k + 1) * dom->slab; cell++) {
        if (dom->params.bands == 4) {
            emit_cell(dom, field->f + cell * count, cell, 4);
        } else {
            emit_cell(dom, field->f + cell * count, cell, dom->params.bands);
        }
    }
}

/* ---- moments ---- */

/* Vectors of directions that are gathered at once. */
enum { PORTION = 8 };

/* The sums over octants of each class, for directions o on. */
static inline void load_classes(const air_dom *dom, size_t cell, size_t o, lanes p[DOM_OCTANTS])
{
    const float *const radiance = dom->radiance.f + dom_radiance(dom, 0, cell) + o;
#pragma GCC unroll 8
    for (size_t octant = 0; octant < DOM_OCTANTS; octant++) {
        p[octant] = lanes_load(radiance + octant * dom->octant);
    }
    transform_octants(p);
}

/* Numbers of a row of four directions, as four bands have, and its vectors. */
enum { SHORT_ROW = 4 * CHANNELS, SHORT = SHORT_ROW / LANES };

/* Four moments from m on, of such a row. */
static inline void gather_four(const air_dom *dom, int m, const int *class_of,
                               lanes p[SHORT][DOM_OCTANTS], float *out)
{
    const float *const gathering = dom->gathering.f + m * SHORT_ROW;
    lanes sums[4];
#pragma GCC unroll 4
    for (int i = 0; i < 4; i++) {
        const int class = class_of[m + i];
        sums[i] = lanes_load(gathering + i * SHORT_ROW) * p[0][class];
#pragma GCC unroll 4
        for (int v = 1; v < SHORT; v++) {
            sums[i] =
                lanes_madd(lanes_load(gathering + i * SHORT_ROW + v * LANES), p[v][class], sums[i]);
        }
    }
    lanes_fold(sums, out);
}

/* moments: dom's. */
static inline void gather_short_cell(air_dom *dom, size_t cell, int moments, const int *class_of)
{
    float *const next = dom->next.f + cell * (size_t)moments * CHANNELS;
    float folded[4 * CHANNELS];
    lanes p[SHORT][DOM_OCTANTS];
    int m = 0;
#pragma GCC unroll 4
    for (int v = 0; v < SHORT; v++) {
        load_classes(dom, cell, (size_t)(v * LANES), p[v]);
    }
#pragma GCC unroll 4
    for (; m + 4 <= moments; m += 4) {
        gather_four(dom, m, class_of, p, next + m * CHANNELS);
    }
    if (m < moments) {
        gather_four(dom, m, class_of, p, folded);
        memcpy(next + m * CHANNELS, folded, (size_t)(moments - m) * sizeof(four));
    }
}

/* Adds to the sums over directions begin .. end, lane by lane, of a class's moments m .. m + count,
 * up to four: four sums that do not wait for each other, of radiances that are fetched once. */
static inline void gather_moments(const air_dom *dom, int m, int count, size_t begin, size_t end,
                                  lanes p[PORTION][DOM_OCTANTS], lanes *sums)
{
    const size_t row = dom->row;
    const float *const gathering = dom->gathering.f + (size_t)m * row;
    const int class = dom->class_of[m];
    lanes a = sums[0], b = sums[1], c = sums[2], d = sums[3];
    for (size_t o = begin; o < end; o += LANES) {
        const lanes radiance = p[(o - begin) / LANES][class];
        a = lanes_madd(lanes_load(gathering + o), radiance, a);
        b = lanes_madd(lanes_load(gathering + row + o), radiance, b);
        c = lanes_madd(lanes_load(gathering + 2 * row + o), radiance, c);
        d = lanes_madd(lanes_load(gathering + 3 * row + o), radiance, d);
    }
    sums[0] = a;
    sums[1] = count > 1 ? b : sums[1];
    sums[2] = count > 2 ? c : sums[2];
    sums[3] = count > 3 ? d : sums[3];
}

static void gather_cell(air_dom *dom, size_t cell)
{
    const int moments = dom->moments, *const first = dom_class_begin[dom->params.bands];
    lanes p[PORTION][DOM_OCTANTS], sums[DOM_MOMENTS_MAX + 3];
    float folded[4 * CHANNELS];
    float *const next = dom->next.f + cell * (size_t)moments * CHANNELS;
    for (int m = 0; m < moments + 3; m++) {
        sums[m] = lanes_all(0.0f);
    }
    for (size_t begin = 0; begin < dom->row; begin += PORTION * LANES) {
        const size_t left = dom->row - begin;
        const size_t end = begin + (left < PORTION * LANES ? left : PORTION * LANES);
        for (size_t o = begin; o < end; o += LANES) {
            load_classes(dom, cell, o, p[(o - begin) / LANES]);
        }
        for (int class = 0; class < DOM_OCTANTS; class ++) {
            for (int m = first[class]; m < first[class + 1]; m += 4) {
                gather_moments(dom, m, first[class + 1] - m, begin, end, p, sums + m);
            }
        }
    }
    for (int m = 0; m < moments; m += 4) {
        const int count = moments - m < 4 ? moments - m : 4;
        lanes_fold(sums + m, count == 4 ? next + m * CHANNELS : folded);
        if (count < 4) {
            memcpy(next + m * CHANNELS, folded, (size_t)count * sizeof(four));
        }
    }
}

/* Squares of what a sweep changes, and of what it leaves; few enough for floats. */
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

/* Of four bands' moments: constants, so that p stays in registers. */
static const int classes_of_4[16] = {0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 4, 4, 4, 5, 6, 7};

/* Compares line by line, while a line is near. */
static void gather(air_dom *dom, size_t k)
{
    const size_t count = (size_t)dom->moments * CHANNELS, n = dom->params.size[0];
    dom_sums sums = {0.0, 0.0};
    for (size_t line = k * dom->slab; line < (k + 1) * dom->slab; line += n) {
        for (size_t cell = line; cell < line + n; cell++) {
            if (dom->params.bands == 4 && dom->row == SHORT_ROW) {
                gather_short_cell(dom, cell, 16, classes_of_4);
            } else if (dom->row == SHORT_ROW) {
                gather_short_cell(dom, cell, dom->moments, dom->class_of);
            } else {
                gather_cell(dom, cell);
            }
        }
        const dom_sums part = compare(dom, line * count, (line + n) * count);
        sums.change += part.change;
        sums.size += part.size;
    }
    dom->sums[k] = sums;
}

/* ---- vectors: counts are multiples of four ---- */

static double dot(const dom_array *a, const dom_array *b, size_t begin, size_t end)
{
    const lanes zero = lanes_all(0.0f);
    lanes sums[4] = {zero, zero, zero, zero};
    double total = 0.0;
    size_t i = begin;
    for (; i + 4 * LANES <= end; i += 4 * LANES) {
#pragma GCC unroll 4
        for (size_t part = 0; part < 4; part++) {
            const size_t at = i + part * LANES;
            sums[part] = lanes_madd(lanes_load(a->f + at), lanes_load(b->f + at), sums[part]);
        }
    }
    const lanes sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (int lane = 0; lane < LANES; lane++) {
        total += (double)sum[lane];
    }
    for (; i < end; i++) {
        total += (double)a->f[i] * (double)b->f[i];
    }
    return total;
}

static void subtract(const dom_array *a, const dom_array *b, dom_array *out, size_t begin,
                     size_t end)
{
    size_t i = begin;
    for (; i + LANES <= end; i += LANES) {
        lanes_store(out->f + i, lanes_load(a->f + i) - lanes_load(b->f + i));
    }
    for (; i < end; i++) {
        out->f[i] = a->f[i] - b->f[i];
    }
}

static void combine(const dom_array *a, const dom_array *parts, const double *factors, int count,
                    dom_array *out, size_t begin, size_t end)
{
    lanes factor[AIR_DOM_DEPTH_MAX];
    size_t i = begin;
    for (int part = 0; part < count; part++) {
        factor[part] = lanes_all((float)factors[part]);
    }
    for (; i + LANES <= end; i += LANES) {
        lanes sum = lanes_load(a->f + i);
        for (int part = 0; part < count; part++) {
            sum = lanes_nmadd(factor[part], lanes_load(parts[part].f + i), sum);
        }
        lanes_store(out->f + i, sum);
    }
    for (; i < end; i++) {
        float sum = a->f[i];
        for (int part = 0; part < count; part++) {
            sum -= (float)factors[part] * parts[part].f[i];
        }
        out->f[i] = sum;
    }
}

const dom_kernel DOM_KERNEL = {emit, sweep, gather, dot, subtract, combine};
