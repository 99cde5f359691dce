/* lanes_float.h: floats side by side, 16 with AVX-512, 8 with AVX2, 4 with SSE4.2, under the names
 * of lanes.h and lanes_double.h, instead of which a file includes it. */
#ifndef AIR_CORE_LANES_FLOAT_H
#define AIR_CORE_LANES_FLOAT_H

#include <immintrin.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef float lane_real;

/* Arguments of roots and inverses stay within these. */
#define LANES_LEAST    1e-36
#define LANES_GREATEST 1e36

#if defined(__AVX512F__) && defined(__AVX512DQ__)

enum { LANES = 16 };
typedef __m512 lanes;
typedef __mmask16 lane_mask;

static inline lanes lanes_all(float x) { return _mm512_set1_ps(x); }
static inline lanes lanes_load(const float *p) { return _mm512_loadu_ps(p); }
static inline void lanes_store(float *p, lanes a) { _mm512_storeu_ps(p, a); }
static inline lanes lanes_min(lanes a, lanes b) { return _mm512_min_ps(a, b); }
static inline lanes lanes_max(lanes a, lanes b) { return _mm512_max_ps(a, b); }
static inline lanes lanes_abs(lanes a) { return _mm512_abs_ps(a); }
static inline lanes lanes_madd(lanes a, lanes b, lanes c) { return _mm512_fmadd_ps(a, b, c); }
static inline lanes lanes_nmadd(lanes a, lanes b, lanes c) { return _mm512_fnmadd_ps(a, b, c); }
static inline lane_mask lanes_less(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
static inline lane_mask lanes_equal(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ);
}
static inline lane_mask mask_none(void) { return 0; }
static inline lane_mask mask_and(lane_mask a, lane_mask b) { return (lane_mask)(a & b); }
static inline lane_mask mask_and_not(lane_mask a, lane_mask b) { return (lane_mask)(a & ~b); }
static inline lane_mask mask_or(lane_mask a, lane_mask b) { return (lane_mask)(a | b); }
static inline bool mask_any(lane_mask a) { return a != 0; }
static inline lanes lanes_select(lane_mask mask, lanes a, lanes b)
{
    return _mm512_mask_blend_ps(mask, b, a);
}

/* 14 bits from the processor, doubled by Newton's rule. */
static inline lanes lanes_inverse_root(lanes x)
{
    const lanes half = lanes_all(0.5f), y = _mm512_rsqrt14_ps(x);
    return lanes_madd(y, lanes_nmadd(x * half * y, y, half), y);
}

static inline lanes lanes_root(lanes x) { return x * lanes_inverse_root(x); }

static inline lanes lanes_inverse(lanes x)
{
    const lanes y = _mm512_rcp14_ps(x);
    return lanes_madd(y, lanes_nmadd(x, y, lanes_all(1.0f)), y);
}

/* As the processor has them: to 4e-4 at worst, which differ from one to the next. */
static inline lanes lanes_rough_inverse_root(lanes x) { return _mm512_rsqrt14_ps(x); }
static inline lanes lanes_rough_inverse(lanes x) { return _mm512_rcp14_ps(x); }

#elif defined(__AVX2__) && defined(__FMA__)

enum { LANES = 8 };
typedef __m256 lanes;
typedef __m256 lane_mask;

static inline lanes lanes_all(float x) { return _mm256_set1_ps(x); }
static inline lanes lanes_load(const float *p) { return _mm256_loadu_ps(p); }
static inline void lanes_store(float *p, lanes a) { _mm256_storeu_ps(p, a); }
static inline lanes lanes_min(lanes a, lanes b) { return _mm256_min_ps(a, b); }
static inline lanes lanes_max(lanes a, lanes b) { return _mm256_max_ps(a, b); }
static inline lanes lanes_abs(lanes a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a); }
static inline lanes lanes_madd(lanes a, lanes b, lanes c) { return _mm256_fmadd_ps(a, b, c); }
static inline lanes lanes_nmadd(lanes a, lanes b, lanes c) { return _mm256_fnmadd_ps(a, b, c); }
static inline lane_mask lanes_less(lanes a, lanes b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
static inline lane_mask lanes_equal(lanes a, lanes b) { return _mm256_cmp_ps(a, b, _CMP_EQ_OQ); }
static inline lane_mask mask_none(void) { return _mm256_setzero_ps(); }
static inline lane_mask mask_and(lane_mask a, lane_mask b) { return _mm256_and_ps(a, b); }
static inline lane_mask mask_and_not(lane_mask a, lane_mask b) { return _mm256_andnot_ps(b, a); }
static inline lane_mask mask_or(lane_mask a, lane_mask b) { return _mm256_or_ps(a, b); }
static inline bool mask_any(lane_mask a) { return _mm256_movemask_ps(a) != 0; }
static inline lanes lanes_select(lane_mask mask, lanes a, lanes b)
{
    return _mm256_blendv_ps(b, a, mask);
}
static inline lanes lanes_root(lanes x) { return _mm256_sqrt_ps(x); }
static inline lanes lanes_inverse_root(lanes x) { return lanes_all(1.0f) / _mm256_sqrt_ps(x); }
static inline lanes lanes_inverse(lanes x) { return lanes_all(1.0f) / x; }
static inline lanes lanes_rough_inverse_root(lanes x) { return _mm256_rsqrt_ps(x); }
static inline lanes lanes_rough_inverse(lanes x) { return _mm256_rcp_ps(x); }

#else

enum { LANES = 4 };
typedef __m128 lanes;
typedef __m128 lane_mask;

static inline lanes lanes_all(float x) { return _mm_set1_ps(x); }
static inline lanes lanes_load(const float *p) { return _mm_loadu_ps(p); }
static inline void lanes_store(float *p, lanes a) { _mm_storeu_ps(p, a); }
static inline lanes lanes_min(lanes a, lanes b) { return _mm_min_ps(a, b); }
static inline lanes lanes_max(lanes a, lanes b) { return _mm_max_ps(a, b); }
static inline lanes lanes_abs(lanes a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a); }
/* Rounds twice: there is no fused instruction. */
static inline lanes lanes_madd(lanes a, lanes b, lanes c) { return a * b + c; }
static inline lanes lanes_nmadd(lanes a, lanes b, lanes c) { return c - a * b; }
static inline lane_mask lanes_less(lanes a, lanes b) { return _mm_cmplt_ps(a, b); }
static inline lane_mask lanes_equal(lanes a, lanes b) { return _mm_cmpeq_ps(a, b); }
static inline lane_mask mask_none(void) { return _mm_setzero_ps(); }
static inline lane_mask mask_and(lane_mask a, lane_mask b) { return _mm_and_ps(a, b); }
static inline lane_mask mask_and_not(lane_mask a, lane_mask b) { return _mm_andnot_ps(b, a); }
static inline lane_mask mask_or(lane_mask a, lane_mask b) { return _mm_or_ps(a, b); }
static inline bool mask_any(lane_mask a) { return _mm_movemask_ps(a) != 0; }
static inline lanes lanes_select(lane_mask mask, lanes a, lanes b)
{
    return _mm_blendv_ps(b, a, mask);
}
static inline lanes lanes_root(lanes x) { return _mm_sqrt_ps(x); }
static inline lanes lanes_inverse_root(lanes x) { return lanes_all(1.0f) / _mm_sqrt_ps(x); }
static inline lanes lanes_inverse(lanes x) { return lanes_all(1.0f) / x; }
static inline lanes lanes_rough_inverse_root(lanes x) { return _mm_rsqrt_ps(x); }
static inline lanes lanes_rough_inverse(lanes x) { return _mm_rcp_ps(x); }

#endif

typedef int32_t lane_ints __attribute__((vector_size(4 * LANES)));

/* 2^x for x in [-125, 0]: about the nearest integer the polynomial whose greatest relative error is
 * least, 9e-8; with roundings 1.8e-7 (tests/test_core_lanes_angle.c). */
static inline lanes lanes_exp2(lanes x)
{
    const lanes magic = lanes_all(0x1.8p23f), one = lanes_all(1.0f);
    const lanes shifted = x + magic, r = x - (shifted - magic);
    lanes p = lanes_madd(r, lanes_all(1.32647273e-3f), lanes_all(9.67151299e-3f));
    p = lanes_madd(p, r, lanes_all(5.55073358e-2f));
    p = lanes_madd(p, r, lanes_all(2.40222424e-1f));
    p = lanes_madd(p, r, lanes_all(6.93147004e-1f));
    p = lanes_madd(p, r, one);
    return (lanes)(((lane_ints)shifted << 23) + (lane_ints)p);
}

/* log2(x) for normal x > 0: of x = 2^n m, m in [1/sqrt 2, sqrt 2), n + 2 log2(e) artanh(s), s =
 * (m - 1)/(m + 1), whose series to s^7 leaves out s^8/9 < 9e-8 of it;
 * with roundings 2.4e-7. */
static inline lanes lanes_log2(lanes x)
{
    const lanes one = lanes_all(1.0f);
    const lane_ints root = (lane_ints)lanes_all(0.70710678f);
    const lane_ints bits = (lane_ints)x + ((lane_ints)one - root);
    const lanes m = (lanes)((bits & 0x007fffff) + root);
    const lanes n = __builtin_convertvector(bits >> 23, lanes) - lanes_all(127.0f);
    const lanes s = (m - one) * lanes_inverse(m + one), s2 = s * s;
    lanes p = lanes_madd(s2, lanes_all(2.88539008f / 7.0f), lanes_all(2.88539008f / 5.0f));
    p = lanes_madd(s2, p, lanes_all(2.88539008f / 3.0f));
    p = lanes_madd(s2, p, lanes_all(2.88539008f));
    return lanes_madd(s, p, n);
}

#endif
