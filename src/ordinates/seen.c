/* seen.c: source functions towards an observer. */
#include <math.h>

#include "core/harmonics.h"
#include "core/phase.h"
#include "ordinates/four.h"
#include "ordinates/seen.h"

enum { CHANNELS = SEEN_CHANNELS, RUN = SEEN_RUN };

/* Directions of travel from the centres of `count` cells of a row to the observer. */
static void view_directions(const air_seen_box *box, size_t i, size_t j, size_t k, size_t count,
                            float out[3][RUN])
{
    const size_t at[3] = {i, j, k};
    for (size_t n = 0; n < count; n++) {
        float v[3], square = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            const size_t cell = at[axis] + (axis == 0 ? n : 0);
            const float center = ((float)(ptrdiff_t)cell + 0.5f) * box->cell_m[axis];
            v[axis] = box->distant ? box->observer[axis] : box->observer[axis] - center;
            square += v[axis] * v[axis];
        }
        const float scale = 1.0f / sqrtf(float_max(square, 1e-30f));
        for (int axis = 0; axis < 3; axis++) {
            out[axis][n] = v[axis] * scale;
        }
    }
}

static four sum_moments(int bands, const float *moments, const double *factors, float v[3][RUN],
                        size_t n)
{
    const double dir[3] = {(double)v[0][n], (double)v[1][n], (double)v[2][n]};
    double y[AIR_SH_COUNT_MAX];
    four sum = four_all(0.0f);
    air_sh_evaluate(bands, dir, y);
    for (int l = 0, m = 0; l < bands; l++) {
        for (; m < (l + 1) * (l + 1); m++) {
            sum += (float)(factors[l] * y[m]) * four_load(moments + m * CHANNELS);
        }
    }
    return sum;
}

static void see_moments(const air_seen_box *box, int bands, const float *moments,
                        const double *factors, size_t begin, size_t end, float *out)
{
    const size_t stride = (size_t)(bands * bands) * CHANNELS;
    float v[3][RUN];
    for (size_t k = begin; k < end; k++) {
        for (size_t j = 0; j < box->size[1]; j++) {
            for (size_t i = 0; i < box->size[0]; i += RUN) {
                const size_t count = box->size[0] - i < RUN ? box->size[0] - i : RUN;
                const size_t cell = (k * box->size[1] + j) * box->size[0] + i;
                view_directions(box, i, j, k, count, v);
                for (size_t n = 0; n < count; n++) {
                    float *const at = out + (cell + n) * CHANNELS;
                    const four sum =
                        sum_moments(bands, moments + (cell + n) * stride, factors, v, n);
                    four_store(at, four_load(at) + sum);
                }
            }
        }
    }
}

/* One lobe of a phase function, as a beam of mean cosine `lobe` sees it. Rayleigh's is 1 + P_2 / 2,
 * of which lobe^2 is left: share of it, the rest even. */
static void add_lobe(const air_phase_lobe *from, float lobe, float cosine[RUN], size_t count,
                     float value[RUN])
{
    const float quarter = 1.0f / (4.0f * AIR_PI_F);
    if (from->kind == AIR_PHASE_RAYLEIGH) {
        for (size_t n = 0; n < count; n++) {
            const float band = 1.5f * cosine[n] * cosine[n] - 0.5f;
            value[n] += from->weight * quarter * (1.0f + 0.5f * lobe * lobe * band);
        }
        return;
    }
    const float g = from->kind == AIR_PHASE_HG ? from->g * lobe : 0.0f;
    const float top = from->weight * quarter * (1.0f - g * g), base = 1.0f + g * g;
    for (size_t n = 0; n < count; n++) {
        const float d = float_max(base - 2.0f * g * cosine[n], 1e-12f);
        value[n] += top / (d * sqrtf(d));
    }
}

/* Directions of travel of a beam in `count` cells of a row. */
static void beam_directions(const air_seen_box *box, const air_seen_beam *beam, size_t i, size_t j,
                            size_t k, size_t count, float out[3][RUN])
{
    air_seen_box from = *box;
    from.distant = !beam->local;
    memcpy(from.observer, beam->dir, sizeof from.observer);
    view_directions(&from, i, j, k, count, out);
    for (int axis = 0; axis < 3 && beam->local; axis++) { /* away from it */
        for (size_t n = 0; n < count; n++) {
            out[axis][n] = -out[axis][n];
        }
    }
}

/* ---- the peak ---- */

void seen_find_lobes(air_phase phase, seen_lobes *out)
{
    const bool mixture = phase.kind == AIR_PHASE_MIXTURE;
    out->only = (air_phase_lobe){phase.kind, phase.g, 1.0f};
    out->lobes = mixture ? phase.mixture->lobes : &out->only;
    out->count = mixture ? phase.mixture->lobe_count : 1;
}

/* Value at a cosine, and how much lies behind it (of smaller cosine), of a lobe seen in a beam. */
static void lobe_at(const air_phase_lobe *from, double lobe, double cosine, double *value,
                    double *behind)
{
    const double weight = (double)from->weight, quarter = 1.0 / (4.0 * AIR_PI);
    const double g = from->kind == AIR_PHASE_HG ? (double)from->g * lobe : 0.0;
    if (from->kind == AIR_PHASE_RAYLEIGH) {
        const double square = cosine * cosine, half = 0.5 * lobe * lobe;
        *value += weight * quarter * (1.0 + half * (1.5 * square - 0.5));
        *behind += weight * 0.5 * (1.0 + cosine + half * 0.5 * cosine * (square - 1.0));
        return;
    }
    const double s = sqrt(1.0 + g * g - 2.0 * g * cosine);
    *value += weight * quarter * (1.0 - g * g) / (s * s * s);
    /* (1-g^2)/(2g) (1/s - 1/(1+g)), with g divided out */
    *behind += weight * 0.5 * (1.0 - g) * (1.0 + cosine) * 2.0 / (s * (1.0 + g + s));
}

/* Of Henyey and Greenstein's with g > 0. With x = (1 - g) / s, s^2 = 1 + g^2 - 2 g mu, what lies
 * below the value at mu is 1 - share where (3 x - x^3) / 2 = (1 + g - 2 g share) / (1 + g), and
 * sin 3 t = 3 sin t - 4 sin^3 t solves it. */
static seen_cap cap_of_lobe(double g, double share)
{
    const double sine = (1.0 + g - 2.0 * g * share) / (1.0 + g);
    const double x = 2.0 * sin(asin(double_min(sine, 1.0)) / 3.0), s = (1.0 - g) / x;
    const double below = (1.0 - g) * (1.0 - g) * (1.0 / (x * x) - 1.0) / (2.0 * g);
    return (seen_cap){(float)(1.0 - below), (float)((1.0 - g * g) / (4.0 * AIR_PI * s * s * s))};
}

/* Above its value lies `share` of the phase function, which rises ahead. */
static seen_cap find_cap(const seen_lobes *phase, double lobe, double share)
{
    double low = -1.0, high = 1.0, value = 0.0;
    if (phase->count == 1 && phase->lobes->kind == AIR_PHASE_HG && phase->lobes->weight == 1.0f &&
        (double)phase->lobes->g * lobe > 1e-3) {
        return cap_of_lobe((double)phase->lobes->g * lobe, share);
    }
    for (int i = 0; i < 40 && high - low > 1e-7 * (2.0 - low - high); i++) {
        const double cosine = 0.5 * (low + high);
        double behind = 0.0;
        value = 0.0;
        for (size_t n = 0; n < phase->count; n++) {
            lobe_at(&phase->lobes[n], lobe, cosine, &value, &behind);
        }
        const bool more = behind + 2.0 * AIR_PI * (1.0 - cosine) * value > 1.0 - share;
        low = more ? low : cosine;
        high = more ? cosine : high;
    }
    return (seen_cap){(float)low, (float)value};
}

float air_seen_cap(air_phase phase, float lobe, double share)
{
    seen_lobes found;
    seen_find_lobes(phase, &found);
    return find_cap(&found, (double)lobe, share).value;
}

seen_cap seen_cap_of(const seen_lobes *phase, const air_seen_beam *beam, const air_seen_peak *peak)
{
    const bool capped = peak != NULL && peak->share > 0.0;
    return capped ? find_cap(phase, (double)beam->lobe, peak->share) : (seen_cap){-1.0f, INFINITY};
}

void seen_cap_values(const air_seen_peak *peak, seen_cap begin, const air_seen_beam *beam,
                     size_t cell, size_t count, const float cosine[RUN], float value[RUN])
{
    const float cap = begin.value;
    for (size_t n = 0; n < count; n++) {
        if (value[n] <= cap || cosine[n] < begin.cosine) { /* a peak backwards is none */
            continue;
        }
        if (beam->peakless) {
            value[n] = cap;
            continue;
        }
        const float through = float_max(beam->fluence[(cell + n) * CHANNELS + 3], 1e-30f);
        const float out = peak->depth != NULL ? peak->depth[cell + n] : 0.0f;
        const float depth = (float)peak->ratio * (out - logf(float_min(through, 1.0f)));
        const float once = depth > 1e-3f ? -expm1f(-depth) / depth : 1.0f - 0.5f * depth;
        value[n] = cap + once * (value[n] - cap);
    }
}

static void add_beam(const air_seen_beam *beam, const seen_lobes *phase, const air_seen_peak *peak,
                     seen_cap cap, float dir[3][RUN], float v[3][RUN], size_t count, size_t cell,
                     float *out)
{
    const four power = {beam->power[0], beam->power[1], beam->power[2], 0.0f};
    float cosine[RUN], value[RUN];
    for (size_t n = 0; n < count; n++) {
        cosine[n] = dir[0][n] * v[0][n] + dir[1][n] * v[1][n] + dir[2][n] * v[2][n];
        value[n] = 0.0f;
    }
    for (size_t i = 0; i < phase->count; i++) {
        add_lobe(&phase->lobes[i], beam->lobe, cosine, count, value);
    }
    if (peak != NULL && peak->share > 0.0) {
        seen_cap_values(peak, cap, beam, cell, count, cosine, value);
    }
    for (size_t n = 0; n < count; n++) {
        float *const at = out + (cell + n) * CHANNELS;
        const four fluence = four_load(beam->fluence + (cell + n) * CHANNELS);
        four_store(at, four_load(at) + value[n] * power * fluence);
    }
}

static void see_beam(const air_seen_box *box, const air_seen_beam *beam, const seen_lobes *phase,
                     const air_seen_peak *peak, size_t begin, size_t end, float *out)
{
    const seen_cap cap = seen_cap_of(phase, beam, peak);
    float v[3][RUN], dir[3][RUN];
    for (size_t k = begin; k < end; k++) {
        for (size_t j = 0; j < box->size[1]; j++) {
            for (size_t i = 0; i < box->size[0]; i += RUN) {
                const size_t run = box->size[0] - i < RUN ? box->size[0] - i : RUN;
                const size_t cell = (k * box->size[1] + j) * box->size[0] + i;
                view_directions(box, i, j, k, run, v);
                beam_directions(box, beam, i, j, k, run, dir);
                add_beam(beam, phase, peak, cap, dir, v, run, cell, out);
            }
        }
    }
}

static void see_beams(const air_seen_box *box, const air_seen_beam *beams, size_t count,
                      air_phase phase, const air_seen_peak *peak, size_t begin, size_t end,
                      float *out)
{
    seen_lobes found;
    seen_find_lobes(phase, &found);
    for (size_t b = 0; b < count; b++) {
        see_beam(box, &beams[b], &found, peak, begin, end, out);
    }
}

/* ---- moments ---- */

/* Of one beam in one cell: y_lm of its direction, times lobe^l. */
static void beam_harmonics(const air_seen_beam *beam, int bands, const float dir[3], float *out)
{
    const double unit[3] = {(double)dir[0], (double)dir[1], (double)dir[2]};
    double y[AIR_SH_COUNT_MAX], power = 1.0;
    air_sh_evaluate(bands, unit, y);
    for (int l = 0, m = 0; l < bands; l++) {
        for (; m < (l + 1) * (l + 1); m++) {
            out[m] = (float)(power * y[m]);
        }
        power *= (double)beam->lobe;
    }
}

static void add_moments(const air_seen_beam *beam, int bands, float dir[3][RUN], size_t count,
                        size_t cell, float *out)
{
    const size_t moments = (size_t)(bands * bands);
    const four power = {beam->power[0], beam->power[1], beam->power[2], 0.0f};
    float y[AIR_SH_COUNT_MAX];
    for (size_t n = 0; n < count; n++) {
        const float at[3] = {dir[0][n], dir[1][n], dir[2][n]};
        float *const to = out + (cell + n) * moments * CHANNELS;
        const four fluence = power * four_load(beam->fluence + (cell + n) * CHANNELS);
        if (n == 0 || beam->local) {
            beam_harmonics(beam, bands, at, y);
        }
        for (size_t m = 0; m < moments; m++) {
            four_store(to + m * CHANNELS, four_load(to + m * CHANNELS) + y[m] * fluence);
        }
    }
}

static void add_beam_moments(const air_seen_box *box, const air_seen_beam *beams, size_t count,
                             int bands, size_t begin, size_t end, float *out)
{
    float dir[3][RUN];
    for (size_t k = begin; k < end; k++) {
        for (size_t j = 0; j < box->size[1]; j++) {
            for (size_t i = 0; i < box->size[0]; i += RUN) {
                const size_t run = box->size[0] - i < RUN ? box->size[0] - i : RUN;
                const size_t cell = (k * box->size[1] + j) * box->size[0] + i;
                for (size_t b = 0; b < count; b++) {
                    beam_directions(box, &beams[b], i, j, k, run, dir);
                    add_moments(&beams[b], bands, dir, run, cell, out);
                }
            }
        }
    }
}

/* ---- versions ---- */

static const seen_kernel plain = {see_moments, see_beams, add_beam_moments};

static const seen_kernel *version_of(const air_context *context)
{
    switch (air_context_cpu(context)) {
#if defined(__x86_64__)
    case AIR_CPU_AVX512:
        return &seen_avx512;
    case AIR_CPU_AVX2:
        return &seen_avx2;
    case AIR_CPU_SSE42:
        return &seen_sse42;
#endif
    default:
        return &plain;
    }
}

void air_seen_moments(const air_context *context, const air_seen_box *box, int bands,
                      const float *moments, const double *factors, size_t begin, size_t end,
                      float *out)
{
    version_of(context)->moments(box, bands, moments, factors, begin, end, out);
}

void air_seen_beams(const air_context *context, const air_seen_box *box, const air_seen_beam *beams,
                    size_t count, air_phase phase, const air_seen_peak *peak, size_t begin,
                    size_t end, float *out)
{
    version_of(context)->beams(box, beams, count, phase, peak, begin, end, out);
}

void air_beam_moments(const air_context *context, const air_seen_box *box,
                      const air_seen_beam *beams, size_t count, int bands, size_t begin, size_t end,
                      float *out)
{
    version_of(context)->beam_moments(box, beams, count, bands, begin, end, out);
}
