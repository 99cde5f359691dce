/* random.h: hashes and a small generator, for numbers that need no stratification. */
#ifndef AIR_CORE_RANDOM_H
#define AIR_CORE_RANDOM_H

#include <stdint.h>

/* A bijection of 32 bits with good avalanche: the "lowbias32" constants of [Wellons2018]. */
static inline uint32_t air_hash32(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

static inline uint32_t air_hash_combine(uint32_t seed, uint32_t value)
{
    return air_hash32(seed ^ (value * 0x9e3779b9u + 0x7f4a7c15u));
}

/* A 64-bit linear congruential state with a permuted 32-bit output, PCG-XSH-RR [ONeill2014]. */
typedef struct air_rng {
    uint64_t state;
} air_rng;

static inline uint32_t air_rng_next(air_rng *rng)
{
    const uint64_t old = rng->state;
    rng->state = old * 6364136223846793005ull + 1442695040888963407ull;
    const uint32_t mixed = (uint32_t)(((old >> 18) ^ old) >> 27);
    const uint32_t turn = (uint32_t)(old >> 59);
    return (mixed >> turn) | (mixed << ((32u - turn) & 31u));
}

/* Two keys give independent streams. */
static inline air_rng air_rng_from_keys(uint32_t a, uint32_t b)
{
    air_rng rng = {((uint64_t)air_hash32(a) << 32) | air_hash_combine(a, b)};
    (void)air_rng_next(&rng);
    return rng;
}

/* [0, 1), multiples of 2^-24. */
static inline float air_uint_to_float(uint32_t x) { return (float)(x >> 8) * 0x1p-24f; }
static inline float air_rng_float(air_rng *rng) { return air_uint_to_float(air_rng_next(rng)); }

#endif
