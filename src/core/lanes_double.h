/* lanes_double.h: lanes.h under names that lanes_float.h has too, for kernels written once for both
 * precisions: such a kernel's file includes one or the other. */
#ifndef AIR_CORE_LANES_DOUBLE_H
#define AIR_CORE_LANES_DOUBLE_H

#include "core/lanes.h"

typedef double lane_real;

/* Arguments of roots and inverses stay within these. */
#define LANES_LEAST    1e-300
#define LANES_GREATEST 1e300

/* lanes_nmadd is c - a b. */

#if defined(__AVX512F__) && defined(__AVX512DQ__)

static inline lanes lanes_nmadd(lanes a, lanes b, lanes c) { return _mm512_fnmadd_pd(a, b, c); }

/* 14 bits from the processor, doubled twice by Newton's rule: a third of the time of a division and
 * a root. */
static inline lanes lanes_inverse_root(lanes x)
{
    const lanes half = lanes_all(0.5), x2 = x * half;
    lanes y = _mm512_rsqrt14_pd(x);
    y = lanes_madd(y, lanes_nmadd(x2 * y, y, half), y);
    return lanes_madd(y, lanes_nmadd(x2 * y, y, half), y);
}

static inline lanes lanes_root(lanes x) { return x * lanes_inverse_root(x); }

static inline lanes lanes_inverse(lanes x)
{
    const lanes one = lanes_all(1.0);
    lanes y = _mm512_rcp14_pd(x);
    y = lanes_madd(y, lanes_nmadd(x, y, one), y);
    return lanes_madd(y, lanes_nmadd(x, y, one), y);
}

#elif defined(__AVX2__) && defined(__FMA__)

static inline lanes lanes_nmadd(lanes a, lanes b, lanes c) { return _mm256_fnmadd_pd(a, b, c); }
static inline lanes lanes_root(lanes x) { return _mm256_sqrt_pd(x); }
static inline lanes lanes_inverse_root(lanes x) { return lanes_all(1.0) / _mm256_sqrt_pd(x); }
static inline lanes lanes_inverse(lanes x) { return lanes_all(1.0) / x; }

#else

static inline lanes lanes_nmadd(lanes a, lanes b, lanes c) { return c - a * b; }
static inline lanes lanes_root(lanes x) { return _mm_sqrt_pd(x); }
static inline lanes lanes_inverse_root(lanes x) { return lanes_all(1.0) / _mm_sqrt_pd(x); }
static inline lanes lanes_inverse(lanes x) { return lanes_all(1.0) / x; }

#endif

#endif
