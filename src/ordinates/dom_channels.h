/* dom_channels.h: lanes that are directions times four channels. For files that have included
 * lanes_float.h. */
#ifndef AIR_ORDINATES_DOM_CHANNELS_H
#define AIR_ORDINATES_DOM_CHANNELS_H

#include "ordinates/dom.h"

typedef float four __attribute__((vector_size(16)));

enum { CHANNELS = AIR_DOM_STRIDE, WAYS = LANES / CHANNELS /* directions in a vector */ };

static inline four four_load(const float *p)
{
    four v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void four_store(float *p, four v) { memcpy(p, &v, sizeof v); }

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

#endif
