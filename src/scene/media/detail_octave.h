/* detail_octave.h: an octave of detail's noise at many points, for the instruction set of the
 * including file, which defines DETAIL_OCTAVE as the function's name. A loop without branches,
 * which compilers turn into vectors; it rounds as the one point of detail.c does, so all agree to
 * the bit. */
#include <string.h>

#include "core/random.h"
#include "scene/media/detail.h"

static inline float flip_sign(float x, uint32_t sign)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits ^= sign & 0x80000000u;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline float corner_slope(uint32_t key, float x, float y, float z)
{
    const uint32_t hash = air_hash32(key), left_out = ((hash & 0xffffu) * 3u) >> 16;
    const float a = left_out == 0u ? y : x, b = left_out == 2u ? y : z;
    return flip_sign(a, hash) + flip_sign(b, hash << 1);
}

/* Of what fits whole numbers; floorf keeps compilers from vectors. */
static inline int32_t floor_point(float x)
{
    const int32_t cut = (int32_t)x;
    return cut - (int32_t)((float)cut > x);
}

static inline float fade_point(float t) { return t * t * t * (t * (6.0f * t - 15.0f) + 10.0f); }

static inline uint32_t lattice_key(int32_t at, uint32_t factor)
{
    return ((uint32_t)at & (AIR_DETAIL_PERIOD - 1)) * factor;
}

static inline float point_noise(float x, float y, float z, uint32_t seed)
{
    const int32_t i = floor_point(x), j = floor_point(y), k = floor_point(z);
    const float dx = x - (float)i, dy = y - (float)j, dz = z - (float)k;
    const float fx = fade_point(dx), fy = fade_point(dy), fz = fade_point(dz);
    const uint32_t i0 = lattice_key(i, AIR_DETAIL_KEY_X), i1 = lattice_key(i + 1, AIR_DETAIL_KEY_X);
    const uint32_t j0 = lattice_key(j, AIR_DETAIL_KEY_Y), j1 = lattice_key(j + 1, AIR_DETAIL_KEY_Y);
    const uint32_t k0 = lattice_key(k, AIR_DETAIL_KEY_Z) ^ seed;
    const uint32_t k1 = lattice_key(k + 1, AIR_DETAIL_KEY_Z) ^ seed;
    const float s00 = corner_slope(i0 ^ j0 ^ k0, dx, dy, dz) * (1.0f - fz) +
                      corner_slope(i0 ^ j0 ^ k1, dx, dy, dz - 1.0f) * fz;
    const float s10 = corner_slope(i1 ^ j0 ^ k0, dx - 1.0f, dy, dz) * (1.0f - fz) +
                      corner_slope(i1 ^ j0 ^ k1, dx - 1.0f, dy, dz - 1.0f) * fz;
    const float s01 = corner_slope(i0 ^ j1 ^ k0, dx, dy - 1.0f, dz) * (1.0f - fz) +
                      corner_slope(i0 ^ j1 ^ k1, dx, dy - 1.0f, dz - 1.0f) * fz;
    const float s11 = corner_slope(i1 ^ j1 ^ k0, dx - 1.0f, dy - 1.0f, dz) * (1.0f - fz) +
                      corner_slope(i1 ^ j1 ^ k1, dx - 1.0f, dy - 1.0f, dz - 1.0f) * fz;
    return ((1.0f - fx) * (1.0f - fy) * s00 + fx * (1.0f - fy) * s10) +
           ((1.0f - fx) * fy * s01 + fx * fy * s11);
}

void DETAIL_OCTAVE(const air_detail_octave *octave, const air_detail_points *points,
                   float *restrict sum)
{
    const air_detail_octave o = *octave;
    const float *restrict const px = points->x, *restrict const py = points->y;
    const float *restrict const pz = points->z;
    const size_t count = points->count;
    for (size_t i = 0; i < count; i++) {
        const float x = px[i] * o.scale + o.shift[0];
        const float y = py[i] * o.scale + o.shift[1];
        const float z = pz[i] * o.scale + o.shift[2];
        sum[i] += o.amplitude * point_noise(x, y, z, o.seed);
    }
}
