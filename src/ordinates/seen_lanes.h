/* seen_lanes.h: source functions and moments of beams for the instruction set of the including
 * file, which defines SEEN_KERNEL as the table's name. Lanes are cells of a row, or numbers of
 * cells. */
#include "core/harmonics.h"
#include "core/lanes_float.h"
#include "ordinates/four.h"
#include "ordinates/seen.h"

enum {
    CHANNELS = SEEN_CHANNELS,
    RUN = SEEN_RUN,
    WAYS = LANES / CHANNELS,
    SIDE = 4,  /* cells whose moments are in registers */
    BEAMS = 16 /* whose moments are added together */
};

/* ---- four numbers of cells ---- */

#if defined(__AVX512F__) && defined(__AVX512DQ__)
static inline lanes repeat_four(const float *p) { return _mm512_broadcast_f32x4(_mm_loadu_ps(p)); }
static inline lanes each_four(const float *p) /* every number four times */
{
    const __m512i at = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    return _mm512_permutexvar_ps(at, _mm512_castps128_ps512(_mm_loadu_ps(p)));
}
#elif defined(__AVX2__) && defined(__FMA__)
static inline lanes repeat_four(const float *p)
{
    return _mm256_broadcast_ps((const __m128 *)(const void *)p);
}
static inline lanes each_four(const float *p)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_set1_ps(p[0])), _mm_set1_ps(p[1]), 1);
}
#else
static inline lanes repeat_four(const float *p) { return _mm_loadu_ps(p); }
static inline lanes each_four(const float *p) { return _mm_set1_ps(p[0]); }
#endif

/* ---- directions ---- */

/* A run of cells and directions of travel in them. */
typedef struct run {
    size_t i, j, k, cell, count;
    float dir[3][RUN];
} run;

/* From each cell to a position, or away from it. */
static void aim_at(const air_seen_box *box, const float position[3], float sign, const run *at,
                   float out[3][RUN])
{
    const float across = (float)(ptrdiff_t)at->i + 0.5f;
    const float y = position[1] - ((float)(ptrdiff_t)at->j + 0.5f) * box->cell_m[1];
    const float z = position[2] - ((float)(ptrdiff_t)at->k + 0.5f) * box->cell_m[2];
    float steps[LANES];
    for (int n = 0; n < LANES; n++) {
        steps[n] = (float)n;
    }
    for (size_t n = 0; n < at->count; n += LANES) {
        const lanes middle = lanes_load(steps) + lanes_all(across + (float)(ptrdiff_t)n);
        const lanes x = lanes_nmadd(middle, lanes_all(box->cell_m[0]), lanes_all(position[0]));
        const lanes square = lanes_madd(x, x, lanes_all(y * y + z * z));
        const lanes scale =
            lanes_all(sign) * lanes_inverse_root(lanes_max(square, lanes_all(1e-30f)));
        lanes_store(out[0] + n, x * scale);
        lanes_store(out[1] + n, lanes_all(y) * scale);
        lanes_store(out[2] + n, lanes_all(z) * scale);
    }
}

static void aim_along(const float dir[3], const run *at, float out[3][RUN])
{
    const float inverse = 1.0f / sqrtf(vec3_dot(vec3_load(dir), vec3_load(dir)));
    for (int axis = 0; axis < 3; axis++) {
        for (size_t n = 0; n < at->count; n += LANES) {
            lanes_store(out[axis] + n, lanes_all(dir[axis] * inverse));
        }
    }
}

static void look(const air_seen_box *box, run *at)
{
    if (box->distant) {
        aim_along(box->observer, at, at->dir);
    } else {
        aim_at(box, box->observer, 1.0f, at, at->dir);
    }
}

static void set_run(const air_seen_box *box, size_t i, size_t j, size_t k, run *out)
{
    out->i = i;
    out->j = j;
    out->k = k;
    out->count = box->size[0] - i < RUN ? box->size[0] - i : RUN;
    out->cell = (k * box->size[1] + j) * box->size[0] + i;
}

/* ---- harmonics ---- */

/* y_lm of a run's directions at out[(l*l + l + m) * RUN + n]; see air_sh_meridian: here powers of
 * the sine go with those of x + iy. */
static void evaluate(const air_sh_factors *f, float dir[3][RUN], size_t count, float *out)
{
    for (size_t n = 0; n < count; n += LANES) {
        const lanes x = lanes_load(dir[0] + n), y = lanes_load(dir[1] + n);
        const lanes z = lanes_load(dir[2] + n);
        lanes cosine = lanes_all(1.0f), sine = lanes_all(0.0f);
        double sectoral = 1.0;
        for (int m = 0; m < f->order; m++) {
            sectoral *= f->sectoral[m];
            lanes before = lanes_all(0.0f), value = lanes_all((float)sectoral);
            for (int l = m; l < f->order; l++) {
                if (l > m) {
                    const int at = l * (l + 1) / 2 + m;
                    const lanes next = lanes_nmadd(lanes_all((float)f->b[at]), before,
                                                   lanes_all((float)f->a[at]) * z * value);
                    before = value;
                    value = next;
                }
                lanes_store(out + (size_t)(l * l + l - m) * RUN + n, value * sine);
                lanes_store(out + (size_t)(l * l + l + m) * RUN + n, value * cosine);
            }
            const lanes keep = cosine;
            cosine = lanes_nmadd(y, sine, x * cosine);
            sine = lanes_madd(y, keep, x * sine);
        }
    }
}

static void see_moments(const air_seen_box *box, int bands, const float *moments,
                        const double *factors, size_t begin, size_t end, float *out)
{
    const size_t count = (size_t)(bands * bands);
    float weights[AIR_SH_COUNT_MAX], y[AIR_SH_COUNT_MAX * RUN];
    air_sh_factors f;
    run at;
    air_sh_factors_init(bands, &f);
    for (int l = 0, m = 0; l < bands; l++) {
        for (; m < (l + 1) * (l + 1); m++) {
            weights[m] = (float)factors[l];
        }
    }
    for (size_t row = begin * box->size[1]; row < end * box->size[1]; row++) {
        for (size_t i = 0; i < box->size[0]; i += RUN) {
            set_run(box, i, row % box->size[1], row / box->size[1], &at);
            look(box, &at);
            evaluate(&f, at.dir, at.count, y);
            for (size_t n = 0; n < at.count; n++) {
                const float *const from = moments + (at.cell + n) * count * CHANNELS;
                float *const to = out + (at.cell + n) * CHANNELS;
                four sum[2] = {four_load(to), four_all(0.0f)};
                for (size_t m = 0; m < count; m++) {
                    sum[m % 2] += weights[m] * y[m * RUN + n] * four_load(from + m * CHANNELS);
                }
                four_store(to, sum[0] + sum[1]);
            }
        }
    }
}

/* ---- beams ---- */

/* Adds one lobe of a phase function, as a beam of mean cosine `lobe` sees it; see seen.c. */
static inline lanes lobe_value(const air_phase_lobe *from, float lobe, lanes cosine)
{
    const float share = from->weight / (4.0f * AIR_PI_F);
    if (from->kind == AIR_PHASE_RAYLEIGH) {
        const lanes band = lanes_madd(lanes_all(1.5f) * cosine, cosine, lanes_all(-0.5f));
        return lanes_madd(band, lanes_all(0.5f * lobe * lobe * share), lanes_all(share));
    }
    const float g = from->kind == AIR_PHASE_HG ? from->g * lobe : 0.0f;
    const lanes d = lanes_max(lanes_nmadd(cosine, lanes_all(2.0f * g), lanes_all(1.0f + g * g)),
                              lanes_all(1e-12f));
    const lanes root = lanes_inverse_root(d);
    return lanes_all(share * (1.0f - g * g)) * root * root * root;
}

/* Is any above the cap? */
static bool find_values(const seen_lobes *phase, const air_seen_beam *beam, float dir[3][RUN],
                        const run *at, float cap, float cosines[RUN], float value[RUN])
{
    bool above = false;
    for (size_t n = 0; n < at->count; n += LANES) {
        lanes cosine = lanes_load(at->dir[0] + n) * lanes_load(dir[0] + n);
        cosine = lanes_madd(lanes_load(at->dir[1] + n), lanes_load(dir[1] + n), cosine);
        cosine = lanes_madd(lanes_load(at->dir[2] + n), lanes_load(dir[2] + n), cosine);
        lanes sum = lanes_all(0.0f);
        for (size_t i = 0; i < phase->count; i++) {
            sum = sum + lobe_value(&phase->lobes[i], beam->lobe, cosine);
        }
        above = above || mask_any(lanes_less(lanes_all(cap), sum));
        lanes_store(cosines + n, cosine);
        lanes_store(value + n, sum);
    }
    return above;
}

/* (1 - exp(-d)) / d for d >= 0. */
static inline lanes once_of(lanes depth)
{
    const lanes one = lanes_all(1.0f), few = lanes_all(0.05f);
    const lanes bend = lanes_nmadd(depth, lanes_all(1.0f / 24.0f), lanes_all(1.0f / 6.0f));
    const lanes series = lanes_madd(depth * depth, bend, lanes_nmadd(depth, lanes_all(0.5f), one));
    const lanes power = lanes_max(depth * lanes_all(-1.44269504f), lanes_all(-125.0f));
    const lanes all = (one - lanes_exp2(power)) * lanes_inverse(lanes_max(depth, few));
    return lanes_select(lanes_less(depth, few), series, all);
}

/* Optical depth of the peak's events on the way through cells from n of the run on. */
static inline lanes peak_depth(const air_seen_peak *peak, const air_seen_beam *beam, const run *at,
                               size_t n)
{
    float through[LANES], out[LANES];
    for (size_t i = 0; i < LANES; i++) {
        const size_t cell = at->cell + (n + i < at->count ? n + i : n);
        through[i] = beam->fluence[cell * CHANNELS + 3];
        out[i] = peak->depth != NULL ? peak->depth[cell] : 0.0f;
    }
    const lanes held =
        lanes_min(lanes_max(lanes_load(through), lanes_all(1e-30f)), lanes_all(1.0f));
    const lanes depth = lanes_nmadd(lanes_log2(held), lanes_all(0.693147181f), lanes_load(out));
    return lanes_max(depth * lanes_all((float)peak->ratio), lanes_all(0.0f));
}

/* As seen_cap_values. */
static void cap_values(const air_seen_peak *peak, seen_cap begin, const air_seen_beam *beam,
                       const run *at, const float cosines[RUN], float values[RUN])
{
    const lanes cap = lanes_all(begin.value), edge = lanes_all(begin.cosine);
    for (size_t n = 0; n < at->count; n += LANES) {
        const lanes value = lanes_load(values + n);
        const lane_mask above =
            mask_and_not(lanes_less(cap, value), lanes_less(lanes_load(cosines + n), edge));
        if (mask_any(above)) {
            const lanes once =
                beam->peakless ? lanes_all(0.0f) : once_of(peak_depth(peak, beam, at, n));
            lanes_store(values + n, lanes_select(above, lanes_madd(once, value - cap, cap), value));
        }
    }
}

static void add_values(const air_seen_beam *beam, const float value[RUN], const run *at, float *out)
{
    const float power[4] = {beam->power[0], beam->power[1], beam->power[2], 0.0f};
    const float *const fluence = beam->fluence + at->cell * CHANNELS;
    float *const to = out + at->cell * CHANNELS;
    const lanes all = repeat_four(power);
    size_t n = 0;
    for (; n + WAYS <= at->count; n += WAYS) {
        const lanes share = each_four(value + n) * all;
        lanes_store(to + n * CHANNELS, lanes_madd(share, lanes_load(fluence + n * CHANNELS),
                                                  lanes_load(to + n * CHANNELS)));
    }
    for (; n < at->count; n++) {
        four_store(to + n * CHANNELS,
                   four_load(to + n * CHANNELS) +
                       value[n] * four_load(power) * four_load(fluence + n * CHANNELS));
    }
}

static void see_beams(const air_seen_box *box, const air_seen_beam *beams, size_t count,
                      air_phase phase, const air_seen_peak *peak, size_t begin, size_t end,
                      float *out)
{
    float dir[3][RUN], cosine[RUN + LANES], value[RUN + LANES];
    seen_cap cap[BEAMS];
    seen_lobes lobes;
    run at;
    seen_find_lobes(phase, &lobes);
    for (size_t first = 0; first < count; first += BEAMS) {
        const size_t some = count - first < BEAMS ? count - first : BEAMS;
        for (size_t b = 0; b < some; b++) {
            cap[b] = seen_cap_of(&lobes, &beams[first + b], peak);
        }
        for (size_t row = begin * box->size[1]; row < end * box->size[1]; row++) {
            for (size_t i = 0; i < box->size[0]; i += RUN) {
                set_run(box, i, row % box->size[1], row / box->size[1], &at);
                look(box, &at);
                for (size_t b = 0; b < some; b++) {
                    const air_seen_beam *const beam = &beams[first + b];
                    if (beam->local) {
                        aim_at(box, beam->dir, -1.0f, &at, dir);
                    } else {
                        aim_along(beam->dir, &at, dir);
                    }
                    if (find_values(&lobes, beam, dir, &at, cap[b].value, cosine, value)) {
                        cap_values(peak, cap[b], beam, &at, cosine, value);
                    }
                    add_values(beam, value, &at, out);
                }
            }
        }
    }
}

/* ---- moments of beams ---- */

/* Those of BEAMS beams that are the same in all cells: a moment's four numbers for each. */
typedef struct table {
    const float *fluence[BEAMS];
    size_t count, numbers; /* beams; numbers per cell */
    float y[BEAMS][AIR_SH_COUNT_MAX * CHANNELS];
} table;

static void add_to_table(const air_seen_beam *beam, int bands, table *out)
{
    const double dir[3] = {(double)beam->dir[0], (double)beam->dir[1], (double)beam->dir[2]};
    double y[AIR_SH_COUNT_MAX], power = 1.0;
    float *const to = out->y[out->count];
    air_sh_evaluate(bands, dir, y);
    for (int l = 0, m = 0; l < bands; l++) {
        for (; m < (l + 1) * (l + 1); m++) {
            for (int c = 0; c < CHANNELS; c++) {
                to[m * CHANNELS + c] = c < 3 ? (float)(power * y[m]) * beam->power[c] : 0.0f;
            }
        }
        power *= (double)beam->lobe;
    }
    out->fluence[out->count++] = beam->fluence;
}

/* SIDE cells at once, so that what is read of the table serves them all. */
static void add_table_side(const table *from, size_t cell, float *out)
{
    const size_t numbers = from->numbers;
    float *const to = out + cell * numbers;
    size_t m = 0;
    for (; m + LANES <= numbers; m += LANES) {
        lanes a = lanes_load(to + m), b = lanes_load(to + numbers + m);
        lanes c = lanes_load(to + 2 * numbers + m), d = lanes_load(to + 3 * numbers + m);
        for (size_t i = 0; i < from->count; i++) {
            const lanes y = lanes_load(from->y[i] + m);
            const float *const fluence = from->fluence[i] + cell * CHANNELS;
            a = lanes_madd(y, repeat_four(fluence), a);
            b = lanes_madd(y, repeat_four(fluence + CHANNELS), b);
            c = lanes_madd(y, repeat_four(fluence + 2 * CHANNELS), c);
            d = lanes_madd(y, repeat_four(fluence + 3 * CHANNELS), d);
        }
        lanes_store(to + m, a);
        lanes_store(to + numbers + m, b);
        lanes_store(to + 2 * numbers + m, c);
        lanes_store(to + 3 * numbers + m, d);
    }
    for (; m < numbers; m += CHANNELS) {
        for (size_t n = 0; n < SIDE; n++) {
            four sum = four_load(to + n * numbers + m);
            for (size_t i = 0; i < from->count; i++) {
                sum +=
                    four_load(from->y[i] + m) * four_load(from->fluence[i] + (cell + n) * CHANNELS);
            }
            four_store(to + n * numbers + m, sum);
        }
    }
}

static void add_table(const table *from, size_t begin, size_t end, float *out)
{
    size_t cell = begin;
    for (; cell + SIDE <= end; cell += SIDE) {
        add_table_side(from, cell, out);
    }
    for (; cell < end; cell++) {
        for (size_t m = 0; m < from->numbers; m += CHANNELS) {
            float *const to = out + cell * from->numbers + m;
            four sum = four_load(to);
            for (size_t i = 0; i < from->count; i++) {
                sum += four_load(from->y[i] + m) * four_load(from->fluence[i] + cell * CHANNELS);
            }
            four_store(to, sum);
        }
    }
}

/* Of a beam whose direction differs from cell to cell. */
static void add_local(const air_seen_box *box, const air_seen_beam *beam, const air_sh_factors *f,
                      size_t begin, size_t end, float *out)
{
    const size_t count = (size_t)(f->order * f->order);
    const four power = {beam->power[0], beam->power[1], beam->power[2], 0.0f};
    float y[AIR_SH_COUNT_MAX * RUN], scale[AIR_SH_COUNT_MAX];
    double lobe = 1.0;
    run at;
    for (int l = 0, m = 0; l < f->order; l++, lobe *= (double)beam->lobe) {
        for (; m < (l + 1) * (l + 1); m++) {
            scale[m] = (float)lobe;
        }
    }
    for (size_t row = begin * box->size[1]; row < end * box->size[1]; row++) {
        for (size_t i = 0; i < box->size[0]; i += RUN) {
            set_run(box, i, row % box->size[1], row / box->size[1], &at);
            aim_at(box, beam->dir, -1.0f, &at, at.dir);
            evaluate(f, at.dir, at.count, y);
            for (size_t n = 0; n < at.count; n++) {
                const four fluence = power * four_load(beam->fluence + (at.cell + n) * CHANNELS);
                float *const to = out + (at.cell + n) * count * CHANNELS;
                for (size_t m = 0; m < count; m++) {
                    four_store(to + m * CHANNELS,
                               four_load(to + m * CHANNELS) + scale[m] * y[m * RUN + n] * fluence);
                }
            }
        }
    }
}

static void add_beam_moments(const air_seen_box *box, const air_seen_beam *beams, size_t count,
                             int bands, size_t begin, size_t end, float *out)
{
    const size_t slab = box->size[0] * box->size[1];
    air_sh_factors f;
    table even = {.numbers = (size_t)(bands * bands) * CHANNELS};
    air_sh_factors_init(bands, &f);
    for (size_t b = 0; b < count; b++) {
        if (beams[b].local) {
            add_local(box, &beams[b], &f, begin, end, out);
        } else {
            add_to_table(&beams[b], bands, &even);
        }
        if (even.count == BEAMS || (b + 1 == count && even.count > 0)) {
            add_table(&even, begin * slab, end * slab, out);
            even.count = 0;
        }
    }
}

const seen_kernel SEEN_KERNEL = {see_moments, see_beams, add_beam_moments};
