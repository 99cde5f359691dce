#include "scene/media/detail.h"

#include "core/random.h"

/* Lattice points along an axis before they repeat; a power of two. */
enum { PERIOD = 4096 };

/* Lattice coordinates have no fractions worth the name from here on. */
#define TOO_FINE 0x1p20f

/* Standard deviation of one octave over a cell. Its corners' gradients are independent, with
 * E[g g^T] = 2/3 I, so its square is 8 * 2/3 * 3 W2 W0^2, W0 and W2 the integrals over [0, 1] of
 * w^2 and of w^2 t^2, w = 1 - fade(t). */
static const float octave_deviation = 0.270035f;

/* Four corners of a cell: x in the lowest bit, y in the next. */
typedef float corner_floats __attribute__((vector_size(16)));
typedef uint32_t corner_bits __attribute__((vector_size(16)));

void air_detail_make(const air_detail *detail, air_detail_field *out)
{
    const double stretch = cbrt(fabs(affine_determinant(detail->to_world)));
    const float inverse = 1.0f / detail->scale;
    float variance = 0.0f;
    *out = (air_detail_field){.strength = detail->strength,
                              .feature_m = detail->scale * (float)stretch,
                              .octaves = detail->octaves,
                              .seed = air_hash32(detail->seed)};
    if (affine_invert(detail->to_world, out->to_lattice)) {
        for (int i = 0; i < 12; i++) {
            out->to_lattice[i] *= inverse;
        }
    }
    for (uint32_t k = 0; k < detail->octaves; k++) {
        variance = 0.25f * variance + 1.0f;
    }
    out->amplitude = 0.5f / (octave_deviation * sqrtf(variance));
}

static inline float fade(float t) { return t * t * t * (t * (6.0f * t - 15.0f) + 10.0f); }

/* air_hash32, of four. */
static inline corner_bits hash_corners(corner_bits x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

static inline corner_floats choose(corner_bits mask, corner_floats yes, corner_floats no)
{
    return (corner_floats)((mask & (corner_bits)yes) | (~mask & (corner_bits)no));
}

/* Gradients times the way from each corner: the hash's low half leaves one axis out, its highest
 * bits are signs of the two others. */
static inline corner_floats slopes(corner_bits hash, corner_floats dx, corner_floats dy, float z)
{
    const corner_floats dz = {z, z, z, z};
    const corner_bits left_out = ((hash & 0xffffu) * 3u) >> 16;
    const corner_floats a = choose((corner_bits)(left_out == 0u), dy, dx);
    const corner_floats b = choose((corner_bits)(left_out == 2u), dy, dz);
    return (corner_floats)((corner_bits)a ^ (hash & 0x80000000u)) +
           (corner_floats)((corner_bits)b ^ ((hash << 1) & 0x80000000u));
}

static inline uint32_t lattice_key(uint32_t at, uint32_t factor)
{
    return (at & (PERIOD - 1)) * factor;
}

/* One octave at lattice coordinates, below TOO_FINE. */
static float octave_noise(air_vec3 at, uint32_t seed)
{
    const uint32_t of_x = 0x9e3779b1u, of_y = 0x85ebca77u, of_z = 0xc2b2ae3du;
    const float x0 = floorf(at.x), y0 = floorf(at.y), z0 = floorf(at.z);
    const float x = at.x - x0, y = at.y - y0, z = at.z - z0;
    const float fx = fade(x), fy = fade(y), fz = fade(z);
    const uint32_t i = (uint32_t)(int32_t)x0, j = (uint32_t)(int32_t)y0, k = (uint32_t)(int32_t)z0;
    const uint32_t i0 = lattice_key(i, of_x), i1 = lattice_key(i + 1, of_x);
    const uint32_t j0 = lattice_key(j, of_y) ^ seed, j1 = lattice_key(j + 1, of_y) ^ seed;
    const corner_bits plane = {i0 ^ j0, i1 ^ j0, i0 ^ j1, i1 ^ j1};
    const corner_floats dx = {x, x - 1.0f, x, x - 1.0f}, dy = {y, y, y - 1.0f, y - 1.0f};
    const corner_floats wx = {1.0f - fx, fx, 1.0f - fx, fx};
    const corner_floats wy = {1.0f - fy, 1.0f - fy, fy, fy};
    const corner_floats low = slopes(hash_corners(plane ^ lattice_key(k, of_z)), dx, dy, z);
    const corner_floats high =
        slopes(hash_corners(plane ^ lattice_key(k + 1, of_z)), dx, dy, z - 1.0f);
    const corner_floats sum = wx * wy * (low * (1.0f - fz) + high * fz);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* Where an octave's lattice begins, a share of its spacing. */
static inline air_vec3 octave_shift(uint32_t seed)
{
    return vec3((float)(seed & 0x3ffu) * 0x1p-10f, (float)(seed >> 10 & 0x3ffu) * 0x1p-10f,
                (float)(seed >> 20 & 0x3ffu) * 0x1p-10f);
}

float air_detail_noise(const air_detail_field *field, air_vec3 point, float width_m)
{
    const air_vec3 at = affine_point(field->to_lattice, point);
    float sum = 0.0f, amplitude = field->amplitude, spacing = field->feature_m, scale = 1.0f;
    for (uint32_t k = 0; k < field->octaves; k++) {
        const uint32_t seed = air_hash_combine(field->seed, k);
        const air_vec3 place = vec3_madd(octave_shift(seed), scale, at);
        const float share = float_min(2.0f - width_m / spacing, 1.0f);
        const float far = float_max(fabsf(place.x), float_max(fabsf(place.y), fabsf(place.z)));
        if (!(share > 0.0f) || !(far < TOO_FINE)) {
            break;
        }
        sum += amplitude * share * octave_noise(place, seed);
        amplitude *= 0.5f;
        spacing *= 0.5f;
        scale *= 2.0f;
    }
    const float x = float_min(float_max(sum, -1.0f), 1.0f);
    return x * (1.5f - 0.5f * x * x);
}
