/* denoise_rows.h: the inner loops of the denoiser, compiled once for each instruction set. All
 * operations are those of plain C in the same order, so that all sets give the same bytes.
 *
 * Rows are padded on both sides with pixels that take no part, as far as taps reach, and are worked
 * off in chunks of fixed length: loops without conditions that the compiler turns into vectors. */
#ifndef AIR_IMAGE_DENOISE_ROWS_H
#define AIR_IMAGE_DENOISE_ROWS_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "airlight/denoise.h"
#include "core/exponential.h"
#include "core/vec.h"

enum { AIR_DENOISE_TAPS = 5, AIR_DENOISE_CHUNK = 32 };

/* One level under way. Planes have `height` rows, `stride` floats apart, each of which begins with
 * `pad` floats that take no part; the width is rounded up to whole chunks by more of them. */
typedef struct air_denoise_level {
    size_t height, stride, pad, chunks;
    const float *log_depth; /* NaN: takes no part */
    const float *normal[3]; /* all finite; NULL: nothing is known */
    const float *value;     /* all finite; NULL: nothing is known */
    float *const *planes;   /* read, all finite */
    float *const *out;
    size_t count;
    ptrdiff_t step;
    ptrdiff_t offset[AIR_DENOISE_TAPS]; /* along the row */
    float kernel_x[AIR_DENOISE_TAPS], kernel_y[AIR_DENOISE_TAPS];
    float depth_factor; /* 1 / width in ln depth */
    float normal_power;
    float value_factor; /* 1 / width */
} air_denoise_level;

typedef void air_denoise_row(const air_denoise_level *level, size_t row);

air_denoise_row air_denoise_row_c, air_denoise_row_avx2, air_denoise_row_avx512;

/* -ln z, 0 < z <= 1 and normal; the second half of air_neg_log1m, without its branch: a relative
 * error of 2.4e-7. */
static inline float neg_log(float z)
{
    const uint32_t bits = air_float_bits(z) - 0x3f3504f3u; /* bits of 1/sqrt 2 */
    const float n = (float)((int32_t)bits >> 23);
    const float m = air_float_from_bits((bits & 0x007fffffu) + 0x3f3504f3u);
    const float s = (1.0f - m) / (1.0f + m), q = s * s;
    float p = 2.0f / 9.0f;
    p = p * q + 2.0f / 7.0f;
    p = p * q + 2.0f / 5.0f;
    p = p * q + 2.0f / 3.0f;
    return (p * q * s + 2.0f * s) - n * 0.693147181f;
}

/* Into [1e-30, 1]: above 1 by rounding a high power would grow without bound, and (1e-30)^32 is 0
 * for us. Bits as signed integers put negative numbers first. */
static inline float clamp_cosine(float cosine)
{
    const int32_t bits = (int32_t)air_float_bits(cosine), least = 0x0da24260, most = 0x3f800000;
    const int32_t above = bits > least ? bits : least;
    return air_float_from_bits((uint32_t)(above < most ? above : most));
}

/* kernel exp(-x), x >= 0; 0 where x is NaN or above 40, below 4e-18, of which a pixel's own weight,
 * at least 0.14, leaves nothing. Nearer to the least floats processors become slow. */
static inline float weight_of(float x, float kernel)
{
    /* Bits of floats without sign are in the floats' order, NaN above all. Integers, because
     * compilers make branches of comparisons of floats. */
    const uint32_t bits = air_float_bits(x) & 0x7fffffffu, limit = 0x42200000u; /* 40 */
    const uint32_t within = bits < limit ? bits : limit;
    const uint32_t mask = (uint32_t)((int32_t)(within - limit) >> 31);
    float power;
    const float p = air_exp_parts(-air_float_from_bits(within), &power);
    return air_float_from_bits(air_float_bits(kernel * ((p + 1.0f) * power)) & mask);
}

/* A pixel is like itself. */
static inline void own_weights(const air_denoise_level *self, size_t at, float kernel,
                               float *restrict out)
{
    const float *a = self->log_depth + at;
    for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
        out[i] = a[i] == a[i] ? kernel : 0.0f;
    }
}

/* What the other guides leave of them. */
static inline void limit_by_value(const air_denoise_level *self, size_t at, ptrdiff_t shift,
                                  float *restrict out)
{
    const float *a = self->value + at, *b = a + shift;
    for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
        out[i] *= weight_of(fabsf(a[i] - b[i]) * self->value_factor, 1.0f);
    }
}

static inline void depth_weights(const air_denoise_level *self, size_t at, ptrdiff_t shift,
                                 float kernel, float *restrict out)
{
    const float *a = self->log_depth + at, *b = a + shift;
    for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
        out[i] = weight_of(fabsf(a[i] - b[i]) * self->depth_factor, kernel);
    }
}

/* cos^power exp(-x) = exp(-(power (-ln cos) + x)): one exponential for both. Its argument is off by
 * less than 3e-7 of itself, the weight by 3e-7 times the argument, at most 3e-5 of itself where it
 * is 1e-37, and 1e-6 where it is above 0.05. */
static inline void depth_normal_weights(const air_denoise_level *self, size_t at, ptrdiff_t shift,
                                        float kernel, float *restrict out)
{
    const float *a = self->log_depth + at, *b = a + shift;
    const float *const *n = self->normal;
    const float *ax = n[0] + at, *ay = n[1] + at, *az = n[2] + at;
    const float *bx = ax + shift, *by = ay + shift, *bz = az + shift;
    float apart[AIR_DENOISE_CHUNK]; /* in steps, each of which is a loop without conditions */
    for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
        apart[i] = clamp_cosine(ax[i] * bx[i] + ay[i] * by[i] + az[i] * bz[i]);
    }
    for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
        apart[i] = self->normal_power * neg_log(apart[i]);
    }
    for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
        out[i] = weight_of(fabsf(a[i] - b[i]) * self->depth_factor + apart[i], kernel);
    }
}

/* One row of taps: the sum of weighted values is added. */
static inline void add_row(const float (*restrict w)[AIR_DENOISE_CHUNK], const float *values,
                           const ptrdiff_t *offset, float *restrict sum)
{
    const float *v0 = values + offset[0], *v1 = values + offset[1], *v2 = values + offset[2];
    const float *v3 = values + offset[3], *v4 = values + offset[4];
    for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
        sum[i] += ((w[0][i] * v0[i] + w[1][i] * v1[i]) + (w[3][i] * v3[i] + w[4][i] * v4[i])) +
                  w[2][i] * v2[i];
    }
}

static inline void filter_chunk(const air_denoise_level *self, size_t row, size_t at)
{
    float sums[AIR_DENOISE_MAX_PLANES][AIR_DENOISE_CHUNK];
    float total[AIR_DENOISE_CHUNK] = {0.0f}, w[AIR_DENOISE_TAPS][AIR_DENOISE_CHUNK];
    memset(sums, 0, self->count * sizeof sums[0]);
    for (int j = 0; j < AIR_DENOISE_TAPS; j++) {
        const ptrdiff_t down = self->step * (j - AIR_DENOISE_TAPS / 2);
        const ptrdiff_t y = (ptrdiff_t)row + down;
        if (y < 0 || y >= (ptrdiff_t)self->height || self->kernel_y[j] == 0.0f) {
            continue;
        }
        const ptrdiff_t shift = down * (ptrdiff_t)self->stride;
        for (int i = 0; i < AIR_DENOISE_TAPS; i++) {
            const float kernel = self->kernel_x[i] * self->kernel_y[j];
            if (shift + self->offset[i] == 0) {
                own_weights(self, at, kernel, w[i]);
            } else if (self->normal[0] != NULL) {
                depth_normal_weights(self, at, shift + self->offset[i], kernel, w[i]);
            } else {
                depth_weights(self, at, shift + self->offset[i], kernel, w[i]);
            }
            if (self->value != NULL && shift + self->offset[i] != 0) {
                limit_by_value(self, at, shift + self->offset[i], w[i]);
            }
        }
        for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
            total[i] += ((w[0][i] + w[1][i]) + (w[3][i] + w[4][i])) + w[2][i];
        }
        for (size_t k = 0; k < self->count; k++) {
            add_row((const float(*)[AIR_DENOISE_CHUNK])w, self->planes[k] + (ptrdiff_t)at + shift,
                    self->offset, sums[k]);
        }
    }
    for (size_t k = 0; k < self->count; k++) {
        float *restrict out = self->out[k] + at;
        for (size_t i = 0; i < AIR_DENOISE_CHUNK; i++) {
            out[i] = sums[k][i] / float_max(total[i], 1e-30f); /* 0 / 1e-30: takes no part */
        }
    }
}

static inline void filter_row(const air_denoise_level *self, size_t row)
{
    for (size_t i = 0; i < self->chunks; i++) {
        filter_chunk(self, row, row * self->stride + self->pad + i * AIR_DENOISE_CHUNK);
    }
}

#endif
