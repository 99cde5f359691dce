#include "scene/media/detail.h"

#include <string.h>

#include "core/random.h"
#include "core/sobol.h"

/* Standard deviation of one octave over a cell. Its corners' gradients are independent, with
 * E[g g^T] = 2/3 I, so its square is 8 * 2/3 * 3 W2 W0^2, W0 and W2 the integrals over [0, 1] of
 * w^2 and of w^2 t^2, w = 1 - fade(t). */
static const float octave_deviation = 0.270035f;

/* Four corners of a cell: x in the lowest bit, y in the next. */
typedef float corner_floats __attribute__((vector_size(16)));
typedef air_u32x4 corner_bits;

static air_detail_kernel *choose_kernel(air_cpu cpu)
{
#if defined(__x86_64__)
    if (cpu == AIR_CPU_AVX512) {
        return air_detail_octave_avx512;
    }
    if (cpu == AIR_CPU_AVX2) {
        return air_detail_octave_avx2;
    }
#endif
    (void)cpu;
    return air_detail_octave_plain;
}

void air_detail_make(const air_detail *detail, air_cpu cpu, air_detail_field *out)
{
    const double stretch = cbrt(fabs(affine_determinant(detail->to_world)));
    const float inverse = 1.0f / detail->scale;
    float variance = 0.0f;
    *out = (air_detail_field){.strength = detail->strength,
                              .feature_m = detail->scale * (float)stretch,
                              .octaves = detail->octaves,
                              .kernel = choose_kernel(cpu)};
    if (affine_invert(detail->to_world, out->to_lattice)) {
        for (int i = 0; i < 12; i++) {
            out->to_lattice[i] *= inverse;
        }
    }
    for (uint32_t k = 0; k < detail->octaves; k++) {
        variance = 0.25f * variance + 1.0f;
        out->seeds[k] = air_hash_combine(air_hash32(detail->seed), k);
        for (uint32_t axis = 0; axis < 3; axis++) {
            out->shifts[k][axis] = (float)(out->seeds[k] >> (10 * axis) & 0x3ffu) * 0x1p-10f;
        }
    }
    out->amplitude = 0.5f / (octave_deviation * sqrtf(variance));
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

/* x, y and z of something; the fourth is of no use. */
typedef corner_floats axis_floats;
typedef int32_t axis_whole __attribute__((vector_size(16)));

/* Of places that fit whole numbers. */
static inline axis_whole floor_axes(axis_floats x)
{
    const axis_whole cut = __builtin_convertvector(x, axis_whole);
    return cut + (axis_whole)(__builtin_convertvector(cut, axis_floats) > x);
}

static inline axis_floats fade(axis_floats t)
{
    return t * t * t * (t * (6.0f * t - 15.0f) + 10.0f);
}

/* One octave at lattice coordinates, below AIR_DETAIL_TOO_FINE. */
static inline float octave_noise(axis_floats at, uint32_t seed)
{
    const corner_bits factors = {AIR_DETAIL_KEY_X, AIR_DETAIL_KEY_Y, AIR_DETAIL_KEY_Z, 0u};
    const axis_whole low = floor_axes(at);
    const axis_floats rest = at - __builtin_convertvector(low, axis_floats);
    const axis_floats up = fade(rest), down = 1.0f - up;
    const corner_bits key = ((corner_bits)low & (AIR_DETAIL_PERIOD - 1)) * factors;
    const corner_bits next = ((corner_bits)(low + 1) & (AIR_DETAIL_PERIOD - 1)) * factors;
    const corner_bits of_x = {key[0], next[0], key[0], next[0]};
    const corner_bits of_y = {key[1], key[1], next[1], next[1]};
    const corner_bits plane = of_x ^ of_y ^ seed;
    const float x = rest[0], y = rest[1], z = rest[2];
    const corner_floats dx = {x, x - 1.0f, x, x - 1.0f}, dy = {y, y, y - 1.0f, y - 1.0f};
    const corner_floats wx = {down[0], up[0], down[0], up[0]};
    const corner_floats wy = {down[1], down[1], up[1], up[1]};
    const corner_floats bottom = slopes(air_hash32x4(plane ^ key[2]), dx, dy, z);
    const corner_floats top = slopes(air_hash32x4(plane ^ next[2]), dx, dy, z - 1.0f);
    const corner_floats sum = wx * wy * (bottom * down[2] + top * up[2]);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static inline float bend(float sum)
{
    const float x = float_min(float_max(sum, -1.0f), 1.0f);
    return x * (1.5f - 0.5f * x * x);
}

float air_detail_noise(const air_detail_field *field, air_vec3 point, float width_m)
{
    const air_vec3 place = affine_point(field->to_lattice, point);
    const float far = float_max(fabsf(place.x), float_max(fabsf(place.y), fabsf(place.z)));
    float sum = 0.0f, amplitude = field->amplitude, spacing = field->feature_m, scale = 1.0f;
    if (!(far < AIR_DETAIL_TOO_FINE)) {
        return 0.0f;
    }
    const axis_floats at = {place.x, place.y, place.z, 0.0f};
    for (uint32_t k = 0; k < field->octaves && far * scale < AIR_DETAIL_TOO_FINE; k++) {
        const float share = float_min(2.0f - width_m / spacing, 1.0f);
        const float *shift = field->shifts[k];
        const axis_floats from = {shift[0], shift[1], shift[2], 0.0f};
        if (!(share > 0.0f)) {
            break;
        }
        sum += amplitude * share * octave_noise(at * scale + from, field->seeds[k]);
        amplitude *= 0.5f;
        spacing *= 0.5f;
        scale *= 2.0f;
    }
    return bend(sum);
}

enum { POINTS = 64 };

/* Octaves at POINTS points at most, none too far for the finest. */
static void noise_of_block(const air_detail_field *field, const air_detail_points *places,
                           float width_m, float *sum)
{
    air_detail_octave octave = {.scale = 1.0f};
    float amplitude = field->amplitude, spacing = field->feature_m;
    for (uint32_t k = 0; k < field->octaves; k++) {
        const float share = float_min(2.0f - width_m / spacing, 1.0f);
        if (!(share > 0.0f)) {
            break;
        }
        octave.amplitude = amplitude * share;
        octave.seed = field->seeds[k];
        memcpy(octave.shift, field->shifts[k], sizeof octave.shift);
        field->kernel(&octave, places, sum);
        amplitude *= 0.5f;
        spacing *= 0.5f;
        octave.scale *= 2.0f;
    }
}

static void factors_of_block(const air_detail_field *field, const air_vec3 *points, size_t count,
                             float width_m, float *out)
{
    const float most = AIR_DETAIL_TOO_FINE / (float)(1u << (field->octaves - 1));
    float x[POINTS], y[POINTS], z[POINTS], sum[POINTS];
    bool near = true;
    for (size_t i = 0; i < count; i++) {
        const air_vec3 place = affine_point(field->to_lattice, points[i]);
        near = near && fabsf(place.x) < most && fabsf(place.y) < most && fabsf(place.z) < most;
        x[i] = place.x;
        y[i] = place.y;
        z[i] = place.z;
        sum[i] = 0.0f;
    }
    if (near) {
        const air_detail_points places = {x, y, z, count};
        noise_of_block(field, &places, width_m, sum);
    }
    for (size_t i = 0; i < count; i++) {
        out[i] = near ? 1.0f + field->strength * bend(sum[i])
                      : air_detail_factor(field, points[i], width_m);
    }
}

void air_detail_factors(const air_detail_field *field, const air_vec3 *points, size_t count,
                        float width_m, float *out)
{
    for (size_t i = 0; i < count; i += POINTS) {
        const size_t rest = count - i < POINTS ? count - i : POINTS;
        factors_of_block(field, points + i, rest, width_m, out + i);
    }
}
