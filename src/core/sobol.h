/* sobol.h: Owen-scrambled Sobol samples, padded in sets of four dimensions.
 *
 * A sample is keyed by (pixel, sample index, set). Within a set the four dimensions are those of
 * one Sobol sequence; sets are decorrelated by shuffling the index and scrambling anew
 * [Burley2020], so an integral that uses one set converges as (0,2)- or better sequences do.
 * Scrambling is nested uniform (Owen) by hashing [Laine2011] with the constants of [Vegdahl2021].
 * Indices are taken 65,536 at a time; each such run has a scramble of its own. */
#ifndef AIR_CORE_SOBOL_H
#define AIR_CORE_SOBOL_H

#include <stdint.h>

#include "core/random.h"

typedef uint32_t air_u32x4 __attribute__((vector_size(16)));
typedef int32_t air_i32x4 __attribute__((vector_size(16)));
typedef float air_f32x4 __attribute__((vector_size(16)));

/* The first four dimensions with their bits reversed, one lookup per byte of the index. */
typedef struct air_sobol {
    air_u32x4 low[256], high[256];
} air_sobol;

void air_sobol_init(air_sobol *sobol);

typedef struct air_sampler {
    const air_sobol *sobol;
    uint32_t seed;     /* hash of pixel, render seed and scrambling */
    uint32_t index;    /* within the run of 65,536 */
    uint32_t reversed; /* its bits */
} air_sampler;

static inline uint32_t air_reverse_bits(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

static inline air_sampler air_sampler_make(const air_sobol *sobol, uint32_t pixel_seed,
                                           uint32_t index)
{
    const uint32_t within = index & 0xffffu;
    return (air_sampler){sobol, air_hash_combine(pixel_seed, index >> 16), within,
                         air_reverse_bits(within)};
}

static inline air_u32x4 air_reverse_bits4(air_u32x4 x)
{
    x = (x >> 16) | (x << 16);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

/* Nested uniform scramble of bits in reversed order: a bit is flipped depending on those below it.
 */
static inline uint32_t air_owen_reversed(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static inline air_u32x4 air_owen_reversed4(air_u32x4 x, air_u32x4 seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static inline air_u32x4 air_hash32x4(air_u32x4 x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

/* Four numbers in [0, 1). */
static inline air_f32x4 air_sampler_get(const air_sampler *sampler, uint32_t set)
{
    const uint32_t seed = air_hash_combine(sampler->seed, set);
    const uint32_t shuffled =
        air_reverse_bits(air_owen_reversed(sampler->reversed, seed)) & 0xffffu;
    const air_u32x4 point =
        sampler->sobol->low[shuffled & 255u] ^ sampler->sobol->high[shuffled >> 8];
    const air_u32x4 lanes = {0x68bc21ebu, 0x02e5be93u, 0x967a889bu, 0x31848babu};
    const air_u32x4 bits = air_reverse_bits4(air_owen_reversed4(point, air_hash32x4(lanes ^ seed)));
    return __builtin_convertvector((air_i32x4)(bits >> 8), air_f32x4) * 0x1p-24f;
}

/* An independent stream for loops of unknown length. */
static inline air_rng air_sampler_rng(const air_sampler *sampler, uint32_t stream)
{
    return air_rng_from_keys(sampler->seed ^ 0x5bd1e995u, air_hash_combine(sampler->index, stream));
}

#endif
