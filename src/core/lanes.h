/* lanes.h: doubles side by side, as many as the instruction set of the including file has: 8 with
 * AVX-512, 4 with AVX2, 2 with SSE4.2. For kernels compiled once for each set.
 *
 * + - * / work on `lanes` as they stand (vectors of GCC and Clang); here is what those lack. A
 * comparison with NaN is false; of min and max with a NaN the second operand comes out. */
#ifndef AIR_CORE_LANES_H
#define AIR_CORE_LANES_H

#include <immintrin.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__) && defined(__AVX512DQ__)

enum { LANES = 8 };
typedef __m512d lanes;
typedef __mmask8 lane_mask;

static inline lanes lanes_all(double x) { return _mm512_set1_pd(x); }
static inline lanes lanes_load(const double *p) { return _mm512_loadu_pd(p); }
static inline void lanes_store(double *p, lanes a) { _mm512_storeu_pd(p, a); }
static inline lanes lanes_min(lanes a, lanes b) { return _mm512_min_pd(a, b); }
static inline lanes lanes_max(lanes a, lanes b) { return _mm512_max_pd(a, b); }
static inline lanes lanes_abs(lanes a) { return _mm512_abs_pd(a); }
static inline lanes lanes_madd(lanes a, lanes b, lanes c) { return _mm512_fmadd_pd(a, b, c); }
static inline lane_mask lanes_less(lanes a, lanes b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ);
}
static inline lane_mask lanes_equal(lanes a, lanes b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ);
}
static inline lane_mask mask_none(void) { return 0; }
static inline lane_mask mask_and(lane_mask a, lane_mask b) { return (lane_mask)(a & b); }
static inline lane_mask mask_and_not(lane_mask a, lane_mask b) { return (lane_mask)(a & ~b); }
static inline lane_mask mask_or(lane_mask a, lane_mask b) { return (lane_mask)(a | b); }
static inline bool mask_any(lane_mask a) { return a != 0; }
/* mask ? a : b */
static inline lanes lanes_select(lane_mask mask, lanes a, lanes b)
{
    return _mm512_mask_blend_pd(mask, b, a);
}

#elif defined(__AVX2__) && defined(__FMA__)

enum { LANES = 4 };
typedef __m256d lanes;
typedef __m256d lane_mask;

static inline lanes lanes_all(double x) { return _mm256_set1_pd(x); }
static inline lanes lanes_load(const double *p) { return _mm256_loadu_pd(p); }
static inline void lanes_store(double *p, lanes a) { _mm256_storeu_pd(p, a); }
static inline lanes lanes_min(lanes a, lanes b) { return _mm256_min_pd(a, b); }
static inline lanes lanes_max(lanes a, lanes b) { return _mm256_max_pd(a, b); }
static inline lanes lanes_abs(lanes a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
static inline lanes lanes_madd(lanes a, lanes b, lanes c) { return _mm256_fmadd_pd(a, b, c); }
static inline lane_mask lanes_less(lanes a, lanes b) { return _mm256_cmp_pd(a, b, _CMP_LT_OQ); }
static inline lane_mask lanes_equal(lanes a, lanes b) { return _mm256_cmp_pd(a, b, _CMP_EQ_OQ); }
static inline lane_mask mask_none(void) { return _mm256_setzero_pd(); }
static inline lane_mask mask_and(lane_mask a, lane_mask b) { return _mm256_and_pd(a, b); }
static inline lane_mask mask_and_not(lane_mask a, lane_mask b) { return _mm256_andnot_pd(b, a); }
static inline lane_mask mask_or(lane_mask a, lane_mask b) { return _mm256_or_pd(a, b); }
static inline bool mask_any(lane_mask a) { return _mm256_movemask_pd(a) != 0; }
static inline lanes lanes_select(lane_mask mask, lanes a, lanes b)
{
    return _mm256_blendv_pd(b, a, mask);
}

#else

enum { LANES = 2 };
typedef __m128d lanes;
typedef __m128d lane_mask;

static inline lanes lanes_all(double x) { return _mm_set1_pd(x); }
static inline lanes lanes_load(const double *p) { return _mm_loadu_pd(p); }
static inline void lanes_store(double *p, lanes a) { _mm_storeu_pd(p, a); }
static inline lanes lanes_min(lanes a, lanes b) { return _mm_min_pd(a, b); }
static inline lanes lanes_max(lanes a, lanes b) { return _mm_max_pd(a, b); }
static inline lanes lanes_abs(lanes a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a); }
/* Rounds twice: there is no fused instruction. */
static inline lanes lanes_madd(lanes a, lanes b, lanes c) { return a * b + c; }
static inline lane_mask lanes_less(lanes a, lanes b) { return _mm_cmplt_pd(a, b); }
static inline lane_mask lanes_equal(lanes a, lanes b) { return _mm_cmpeq_pd(a, b); }
static inline lane_mask mask_none(void) { return _mm_setzero_pd(); }
static inline lane_mask mask_and(lane_mask a, lane_mask b) { return _mm_and_pd(a, b); }
static inline lane_mask mask_and_not(lane_mask a, lane_mask b) { return _mm_andnot_pd(b, a); }
static inline lane_mask mask_or(lane_mask a, lane_mask b) { return _mm_or_pd(a, b); }
static inline bool mask_any(lane_mask a) { return _mm_movemask_pd(a) != 0; }
static inline lanes lanes_select(lane_mask mask, lanes a, lanes b)
{
    return _mm_blendv_pd(b, a, mask);
}

#endif

/* The bits of as many doubles. */
typedef uint64_t lane_bits __attribute__((vector_size(8 * LANES)));

#endif
