/* volume_lanes.h: the march for the instruction set of the including file, which defines
 * VOLUME_MARCH as the function's name.
 *
 * Lanes are rays, but where voxels are mixed: there they are WAYS rays times the four numbers of a
 * voxel, group by group: ray 4 b + q is block b of group q, so that groups become numbers of all
 * rays by transposing blocks. Neighbours along x are loaded together. */
#include "core/lanes_float.h"
#include "ordinates/volume.h"

enum { NUMBERS = 4, WAYS = LANES / NUMBERS /* rays in a group */ };

/* Less than this of the light is not followed: it could add that much of the largest J. */
#define LEAST_THROUGH 1e-4f

/* ---- blocks of four numbers ---- */

#if defined(__AVX512F__) && defined(__AVX512DQ__)

enum { PAIRED = 1 };

static inline lanes load_group(const float *voxels, const int32_t *base)
{
    const __m256 a = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(voxels + base[0])),
                                          _mm_loadu_ps(voxels + base[4]), 1);
    const __m256 b = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(voxels + base[8])),
                                          _mm_loadu_ps(voxels + base[12]), 1);
    return _mm512_insertf32x8(_mm512_castps256_ps512(a), b, 1);
}

/* Two neighbours along x, of half of a group. */
static inline lanes load_pairs(const float *voxels, const int32_t *base)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(voxels + base[0])),
                              _mm256_loadu_ps(voxels + base[4]), 1);
}

/* Rays' numbers, to the blocks of group q, and to the halves of its pairs. */
static inline lanes spread_group(lanes rays, int q)
{
    const __m512i at = _mm512_setr_epi32(0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12);
    return _mm512_permutexvar_ps(_mm512_add_epi32(at, _mm512_set1_epi32(q)), rays);
}

static inline lanes spread_half(lanes rays, int q, int half)
{
    const __m512i at = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 4, 4, 4, 4, 4, 4, 4, 4);
    return _mm512_permutexvar_ps(_mm512_add_epi32(at, _mm512_set1_epi32(q + 8 * half)), rays);
}

/* Of pairs: all that are low, all that are high. */
static inline lanes low_of_pairs(lanes a, lanes b) { return _mm512_shuffle_f32x4(a, b, 0x88); }
static inline lanes high_of_pairs(lanes a, lanes b) { return _mm512_shuffle_f32x4(a, b, 0xdd); }

/* Of each place four bytes are read. */
static inline lane_ints gather_bytes(const uint8_t *from, lane_ints at)
{
    return (lane_ints)_mm512_and_epi32(_mm512_i32gather_epi32((__m512i)at, from, 1),
                                       _mm512_set1_epi32(255));
}

static inline float least_of(lanes a) { return _mm512_reduce_min_ps(a); }
static inline uint32_t bits_of(lane_mask a) { return a; }

static inline lanes unpack_low(lanes a, lanes b) { return _mm512_unpacklo_ps(a, b); }
static inline lanes unpack_high(lanes a, lanes b) { return _mm512_unpackhi_ps(a, b); }
static inline lanes unpack_low2(lanes a, lanes b)
{
    return _mm512_castpd_ps(_mm512_unpacklo_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
}
static inline lanes unpack_high2(lanes a, lanes b)
{
    return _mm512_castpd_ps(_mm512_unpackhi_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
}

#elif defined(__AVX2__) && defined(__FMA__)

enum { PAIRED = 1 };

static inline lanes load_group(const float *voxels, const int32_t *base)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(voxels + base[0])),
                                _mm_loadu_ps(voxels + base[4]), 1);
}

static inline lanes load_pairs(const float *voxels, const int32_t *base)
{
    return _mm256_loadu_ps(voxels + base[0]);
}

static inline lanes spread_group(lanes rays, int q)
{
    const __m256i at = _mm256_setr_epi32(0, 0, 0, 0, 4, 4, 4, 4);
    return _mm256_permutevar8x32_ps(rays, _mm256_add_epi32(at, _mm256_set1_epi32(q)));
}

static inline lanes spread_half(lanes rays, int q, int half)
{
    return _mm256_permutevar8x32_ps(rays, _mm256_set1_epi32(q + 4 * half));
}

static inline lanes low_of_pairs(lanes a, lanes b) { return _mm256_permute2f128_ps(a, b, 0x20); }
static inline lanes high_of_pairs(lanes a, lanes b) { return _mm256_permute2f128_ps(a, b, 0x31); }

static inline lane_ints gather_bytes(const uint8_t *from, lane_ints at)
{
    return (lane_ints)_mm256_and_si256(
        _mm256_i32gather_epi32((const int *)(const void *)from, (__m256i)at, 1),
        _mm256_set1_epi32(255));
}

static inline uint32_t bits_of(lane_mask a) { return (uint32_t)_mm256_movemask_ps(a); }

static inline float least_of(lanes a)
{
    const __m128 four = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    const __m128 two = _mm_min_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)));
}

static inline lanes unpack_low(lanes a, lanes b) { return _mm256_unpacklo_ps(a, b); }
static inline lanes unpack_high(lanes a, lanes b) { return _mm256_unpackhi_ps(a, b); }
static inline lanes unpack_low2(lanes a, lanes b)
{
    return _mm256_castpd_ps(_mm256_unpacklo_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)));
}
static inline lanes unpack_high2(lanes a, lanes b)
{
    return _mm256_castpd_ps(_mm256_unpackhi_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)));
}

#else

enum { PAIRED = 0 }; /* a vector holds one voxel */

static inline lanes load_group(const float *voxels, const int32_t *base)
{
    return _mm_loadu_ps(voxels + base[0]);
}

static inline lanes load_pairs(const float *voxels, const int32_t *base)
{
    return load_group(voxels, base);
}

static inline lanes spread_group(lanes rays, int q) { return lanes_all(rays[q]); }
static inline lanes spread_half(lanes rays, int q, int half) { return lanes_all(rays[q + half]); }
static inline lanes low_of_pairs(lanes a, lanes b) { return _mm_movelh_ps(a, b); }
static inline lanes high_of_pairs(lanes a, lanes b) { return _mm_movehl_ps(b, a); }
static inline lane_ints gather_bytes(const uint8_t *from, lane_ints at)
{
    return (lane_ints){from[at[0]], from[at[1]], from[at[2]], from[at[3]]};
}

static inline uint32_t bits_of(lane_mask a) { return (uint32_t)_mm_movemask_ps(a); }

static inline float least_of(lanes a)
{
    const __m128 two = _mm_min_ps(a, _mm_movehl_ps(a, a));
    return _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)));
}

static inline lanes unpack_low(lanes a, lanes b) { return _mm_unpacklo_ps(a, b); }
static inline lanes unpack_high(lanes a, lanes b) { return _mm_unpackhi_ps(a, b); }
static inline lanes unpack_low2(lanes a, lanes b) { return _mm_movelh_ps(a, b); }
static inline lanes unpack_high2(lanes a, lanes b) { return _mm_movehl_ps(b, a); }

#endif

/* ---- places ---- */

/* What all rays have in common, and those under way. */
typedef struct march {
    const air_volume *volume;
    float inverse[3], inverse_steps; /* of a voxel, and of their number */
    int32_t stride[3];               /* numbers between neighbours, 0 where there is one voxel */
    bool looking;                    /* ahead, for what is empty: four bytes are read at once */
    lanes last[3];                   /* as far as there are voxels, the last's centre left out */
    lanes start[3], step[3];         /* in voxels, from centres */
    lanes exponent;                  /* -log2(e) times a step's metres */
    lane_mask goes;                  /* rays that have a way to go */
} march;

static inline lanes each_ray(const float *values, size_t ray, size_t end)
{
    float out[LANES];
    if (ray + LANES <= end) {
        return lanes_load(values + ray);
    }
    for (size_t n = 0; n < LANES; n++) {
        out[n] = values[ray + n < end ? ray + n : end - 1];
    }
    return lanes_load(out);
}

/* Do four bytes from each of the lowest corners on lie within the voxels'? */
static bool can_look(const size_t size[3])
{
    size_t last = 0, stride = 1;
    for (int axis = 0; axis < 3; axis++) {
        last += size[axis] > 1 ? (size[axis] - 2) * stride : 0;
        stride *= size[axis];
    }
    return last + 4 <= stride;
}

static void march_make(const air_volume *volume, uint32_t steps, march *out)
{
    int32_t stride = (int32_t)volume_stride(volume);
    out->volume = volume;
    out->inverse_steps = 1.0f / (float)steps;
    out->looking = volume->empty != NULL && can_look(volume->size);
    for (int axis = 0; axis < 3; axis++) {
        const float last = (float)(int32_t)volume->size[axis] - 1.0f;
        out->inverse[axis] = 1.0f / volume->voxel_m[axis];
        out->last[axis] = lanes_all(nextafterf(last, 0.0f));
        out->stride[axis] = volume->size[axis] > 1 ? stride : 0;
        stride *= (int32_t)volume->size[axis];
    }
}

/* Rays from `ray` on. */
static inline void march_aim(const air_volume_rays *rays, size_t ray, size_t end, march *out)
{
    const lanes t0 = each_ray(rays->t0, ray, end), t1 = each_ray(rays->t1, ray, end);
    const lanes none = lanes_all(0.0f);
    const lanes length = lanes_max(t1 - t0, none) * lanes_all(out->inverse_steps);
    const lanes first = lanes_madd(each_ray(rays->jitter, ray, end), length, t0);
    lanes square = none;
    for (int axis = 0; axis < 3; axis++) {
        const lanes dir = each_ray(rays->dir[axis], ray, end);
        const lanes origin = each_ray(rays->origin[axis], ray, end);
        const lanes inverse = lanes_all(out->inverse[axis]);
        square = lanes_madd(dir, dir, square);
        out->start[axis] = lanes_madd(lanes_madd(first, dir, origin), inverse, lanes_all(-0.5f));
        out->step[axis] = length * dir * inverse;
    }
    const lanes log2_e = lanes_all(-1.44269504f);
    out->exponent = length * lanes_root(lanes_max(square, lanes_all(1e-30f))) * log2_e;
    out->goes = lanes_less(none, length);
}

/* Where points lie: the corner below, as a number of the voxels, and the shares of those above. */
typedef struct corner {
    int32_t base[LANES];
    lanes share[3];
} corner;

static inline void find_corner(const march *m, lanes at, bool coloured, corner *out)
{
    lane_ints low[3];
    for (int axis = 0; axis < 3; axis++) {
        const lanes position = lanes_madd(at, m->step[axis], m->start[axis]);
        const lanes held = lanes_min(lanes_max(position, lanes_all(0.0f)), m->last[axis]);
        low[axis] = __builtin_convertvector(held, lane_ints);
        out->share[axis] = held - __builtin_convertvector(low[axis], lanes);
    }
    const int32_t row = (int32_t)m->volume->size[0], slab = (int32_t)m->volume->size[1];
    const lane_ints base = ((low[2] * slab + low[1]) * row + low[0]) << (coloured ? 3 : 2);
    memcpy(out->base, &base, sizeof base);
}

/* ---- voxels ---- */

static inline lanes mix(lanes a, lanes b, lanes share) { return lanes_madd(b - a, share, a); }

/* Half of a group, neighbours along x side by side, mixed along y and z. */
static inline lanes mix_pairs(const march *m, const float *voxels, const corner *c, int q, int half)
{
    const int32_t *const base = c->base + q + half * (LANES / 2);
    const lanes y = spread_half(c->share[1], q, half), z = spread_half(c->share[2], q, half);
    const float *const far = voxels + m->stride[2];
    const lanes a = mix(load_pairs(voxels, base), load_pairs(voxels + m->stride[1], base), y);
    const lanes b = mix(load_pairs(far, base), load_pairs(far + m->stride[1], base), y);
    return mix(a, b, z);
}

static inline lanes sample_pairs(const march *m, const float *voxels, const corner *c, int q)
{
    const lanes a = mix_pairs(m, voxels, c, q, 0), b = mix_pairs(m, voxels, c, q, 1);
    return mix(low_of_pairs(a, b), high_of_pairs(a, b), spread_group(c->share[0], q));
}

static inline lanes sample_group(const march *m, const float *voxels, const corner *c, int q)
{
    const int32_t *const base = c->base + q;
    const lanes x = spread_group(c->share[0], q), y = spread_group(c->share[1], q);
    lanes plane[2];
    for (int z = 0; z < 2; z++) {
        const float *const low = voxels + z * m->stride[2], *const high = low + m->stride[1];
        const lanes a = mix(load_group(low, base), load_group(low + m->stride[0], base), x);
        const lanes b = mix(load_group(high, base), load_group(high + m->stride[0], base), x);
        plane[z] = mix(a, b, y);
    }
    return mix(plane[0], plane[1], spread_group(c->share[2], q));
}

/* Four numbers of all rays. */
static inline void transpose(lanes first, lanes second, lanes third, lanes fourth,
                             lanes out[NUMBERS])
{
    const lanes a = unpack_low(first, second), b = unpack_high(first, second);
    const lanes c = unpack_low(third, fourth), d = unpack_high(third, fourth);
    out[0] = unpack_low2(a, c);
    out[1] = unpack_high2(a, c);
    out[2] = unpack_low2(b, d);
    out[3] = unpack_high2(b, d);
}

static inline void sample(const march *m, const float *voxels, corner *c, bool paired,
                          lanes out[NUMBERS])
{
    /* To be read from there and now: compilers would take lanes out of the vector, or work all
     * addresses out beforehand and have to put them by. */
    __asm__("" : "+m"(c->base));
    if (paired) { /* written out: all of it stays in registers */
        transpose(sample_pairs(m, voxels, c, 0), sample_pairs(m, voxels, c, 1),
                  sample_pairs(m, voxels, c, 2), sample_pairs(m, voxels, c, 3), out);
    } else {
        transpose(sample_group(m, voxels, c, 0), sample_group(m, voxels, c, 1),
                  sample_group(m, voxels, c, 2), sample_group(m, voxels, c, 3), out);
    }
}

/* ---- the way ---- */

typedef struct carried {
    lanes radiance[3], through[3]; /* of one colour: only the first of the latter */
} carried;

static inline lanes left_of(const march *m, lanes sigma_t)
{
    return lanes_exp2(lanes_max(sigma_t * m->exponent, lanes_all(-125.0f)));
}

/* Steps whose bits are worked through together. */
enum { BITS = 64 };

/* Between which planes all rays are at the first and the last step; from step to step between
 * planes on the lines through these: the least of lines lies above its chord. */
typedef struct bounds {
    float low[3], high[3];           /* at the first step, voxels */
    float low_step[3], high_step[3]; /* more with each */
} bounds;

static bounds find_bounds(const march *m, uint32_t steps)
{
    const lanes none = lanes_all(0.0f), far = lanes_all(1e9f), count = lanes_all((float)steps);
    const lane_mask goes = m->goes; /* others may be anywhere */
    bounds out;
    for (int axis = 0; axis < 3; axis++) {
        const lanes first = m->start[axis], last = lanes_madd(count, m->step[axis], first);
        const float margin = 0.01f; /* for roundings */
        out.low[axis] = least_of(lanes_select(goes, first, far)) - margin;
        out.high[axis] = margin - least_of(lanes_select(goes, none - first, far));
        const float low = least_of(lanes_select(goes, last, far)) - margin;
        const float high = margin - least_of(lanes_select(goes, none - last, far));
        out.low_step[axis] = (low - out.low[axis]) / (float)steps;
        out.high_step[axis] = (high - out.high[axis]) / (float)steps;
    }
    return out;
}

/* Of which of LANES steps from `first` on any ray may see what is not empty: the voxels within the
 * bounds and beside them lie in a cube that begins with the lowest. */
static inline uint32_t look_ahead(const march *m, const bounds *around, lanes step)
{
    const lanes none = lanes_all(0.0f), one = lanes_all(1.0f);
    const int32_t row = (int32_t)m->volume->size[0];
    const int32_t strides[3] = {1, row, row * (int32_t)m->volume->size[1]};
    lane_ints lowest = {0};
    lanes across = none;
    for (int axis = 0; axis < 3; axis++) {
        const lanes low =
            lanes_madd(step, lanes_all(around->low_step[axis]), lanes_all(around->low[axis]));
        const lanes high =
            lanes_madd(step, lanes_all(around->high_step[axis]), lanes_all(around->high[axis]));
        const lane_ints from =
            __builtin_convertvector(lanes_min(lanes_max(low, none), m->last[axis]), lane_ints);
        const lane_ints to =
            __builtin_convertvector(lanes_min(lanes_max(high, none), m->last[axis]), lane_ints);
        across = lanes_max(across, __builtin_convertvector(to - from, lanes));
        lowest += from * strides[axis];
    }
    const lane_ints edges = gather_bytes(m->volume->empty, lowest);
    return ~bits_of(lanes_less(across + one, __builtin_convertvector(edges, lanes)));
}

/* Of BITS steps from `first` on; those beyond `steps` are none. */
static uint64_t steps_to_take(const march *m, const bounds *around, uint32_t first, uint32_t steps)
{
    const uint64_t none = 0, all = ~none;
    const bool looking = m->looking;
    uint64_t bits = looking ? none : all;
    float numbers[LANES];
    for (int i = 0; i < LANES; i++) {
        numbers[i] = (float)i;
    }
    for (uint32_t n = 0; n < BITS && looking; n += LANES) {
        const lanes step = lanes_load(numbers) + lanes_all((float)(first + n));
        bits |= (look_ahead(m, around, step) & ((1ull << LANES) - 1)) << n;
    }
    return steps - first < BITS ? bits & (all >> (BITS - (steps - first))) : bits;
}

static inline uint32_t first_of(uint64_t bits) { return (uint32_t)__builtin_ctzll(bits); }

/* One step further; false: nothing of the light is left. */
static inline bool add_grey(const march *m, const lanes voxel[NUMBERS], carried *light)
{
    const lanes through = light->through[0] * left_of(m, voxel[3]);
    const lanes lost = light->through[0] - through;
    for (int i = 0; i < 3; i++) {
        light->radiance[i] = lanes_madd(lost, voxel[i], light->radiance[i]);
    }
    light->through[0] = through;
    return mask_any(lanes_less(lanes_all(LEAST_THROUGH), light->through[0]));
}

static inline void march_grey(const march *m, uint32_t steps, bool paired, carried *out)
{
    const bounds around = find_bounds(m, steps);
    carried light = *out; /* in registers */
    bool going = true;
    for (uint32_t first = 0; first < steps && going; first += BITS) {
        uint64_t bits = steps_to_take(m, &around, first, steps);
        corner c[2];
        if (bits != 0) {
            find_corner(m, lanes_all((float)(first + first_of(bits))), false, &c[0]);
        }
        for (int turn = 0; bits != 0 && going; turn ^= 1) {
            lanes voxel[NUMBERS];
            bits &= bits - 1;
            if (bits != 0) { /* ahead: it takes long */
                find_corner(m, lanes_all((float)(first + first_of(bits))), false, &c[turn ^ 1]);
            }
            sample(m, m->volume->voxels, &c[turn], paired, voxel);
            going = add_grey(m, voxel, &light);
        }
    }
    *out = light;
    out->through[1] = out->through[2] = light.through[0];
}

static inline bool add_coloured(const march *m, corner *c, carried *light)
{
    lanes j[NUMBERS], sigma_t[NUMBERS], most = lanes_all(0.0f);
    sample(m, m->volume->voxels, c, false, j);
    sample(m, m->volume->voxels + NUMBERS, c, false, sigma_t);
    for (int i = 0; i < 3; i++) {
        const lanes through = light->through[i] * left_of(m, sigma_t[i]);
        light->radiance[i] = lanes_madd(light->through[i] - through, j[i], light->radiance[i]);
        light->through[i] = through;
        most = lanes_max(most, light->through[i]);
    }
    return mask_any(lanes_less(lanes_all(LEAST_THROUGH), most));
}

static void march_coloured(const march *m, uint32_t steps, carried *light)
{
    const bounds around = find_bounds(m, steps);
    bool going = true;
    for (uint32_t first = 0; first < steps && going; first += BITS) {
        uint64_t bits = steps_to_take(m, &around, first, steps);
        for (; bits != 0 && going; bits &= bits - 1) {
            corner c;
            find_corner(m, lanes_all((float)(first + first_of(bits))), true, &c);
            going = add_coloured(m, &c, light);
        }
    }
}

static void march_rays(const march *m, uint32_t steps, carried *out)
{
    for (int i = 0; i < 3; i++) {
        out->radiance[i] = lanes_all(0.0f);
        out->through[i] = lanes_all(1.0f);
    }
    if (!mask_any(m->goes)) {
        return;
    }
    if (m->volume->coloured) {
        march_coloured(m, steps, out);
    } else if (PAIRED && m->volume->size[0] > 1) {
        march_grey(m, steps, true, out);
    } else {
        march_grey(m, steps, false, out);
    }
}

static inline void store_some(float *out, lanes values, size_t count)
{
    if (count == LANES) {
        lanes_store(out, values);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        out[i] = values[i];
    }
}

void VOLUME_MARCH(const air_volume *volume, const air_volume_rays *rays, size_t begin, size_t end,
                  uint32_t steps, float *const out_radiance[3], float *const out_transmittance[3])
{
    march m;
    march_make(volume, steps, &m);
    for (size_t ray = begin; ray < end; ray += LANES) {
        march_aim(rays, ray, end, &m);
        const size_t count = end - ray < LANES ? end - ray : LANES;
        carried light;
        march_rays(&m, steps, &light);
        for (int c = 0; c < 3; c++) {
            store_some(out_radiance[c] + ray, light.radiance[c], count);
            store_some(out_transmittance[c] + ray, light.through[c], count);
        }
    }
}
