/* volume_lanes.h: the march for the instruction set of the including file, which defines
 * VOLUME_MARCH as the function's name. Lanes are rays times the four numbers of a voxel. */
#include "core/lanes_float.h"
#include "ordinates/volume.h"

typedef int32_t lane_ints __attribute__((vector_size(4 * LANES)));

enum { NUMBERS = 4, WAYS = LANES / NUMBERS /* rays in a vector */ };

/* exp(x) for x in [-87, 0]; see core/exponential.h. */
static inline lanes march_exp(lanes x)
{
    const lanes magic = lanes_all(0x1.8p23f), one = lanes_all(1.0f);
    const lanes shifted = lanes_madd(x, lanes_all(1.44269504f), magic), n = shifted - magic;
    const lanes r =
        lanes_nmadd(n, lanes_all(-2.12194440e-4f), lanes_nmadd(n, lanes_all(0.693359375f), x));
    const lanes r2 = r * r;
    const lanes p23 = lanes_madd(r, lanes_all(1.0f / 6.0f), lanes_all(0.5f));
    const lanes p45 = lanes_madd(r, lanes_all(1.0f / 120.0f), lanes_all(1.0f / 24.0f));
    const lanes p = lanes_madd(r2, lanes_madd(r2, p45, p23), r);
    const lanes power = (lanes)(((lane_ints)shifted << 23) + (lane_ints)one);
    return lanes_madd(p, power, power);
}

/* A voxel of each ray. */
static inline lanes load_voxels(const float *voxels, const int32_t at[WAYS])
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    const __m256 a = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(voxels + at[0])),
                                          _mm_loadu_ps(voxels + at[1]), 1);
    const __m256 b = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(voxels + at[2])),
                                          _mm_loadu_ps(voxels + at[3]), 1);
    return _mm512_insertf32x8(_mm512_castps256_ps512(a), b, 1);
#elif defined(__AVX2__) && defined(__FMA__)
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(voxels + at[0])),
                                _mm_loadu_ps(voxels + at[1]), 1);
#else
    return _mm_loadu_ps(voxels + at[0]);
#endif
}

/* The fourth number of each voxel to all four. */
static inline lanes repeat_fourth(lanes a)
{
#if defined(__AVX512F__) && defined(__AVX512DQ__)
    return _mm512_permute_ps(a, 0xff);
#elif defined(__AVX2__) && defined(__FMA__)
    return _mm256_permute_ps(a, 0xff);
#else
    return _mm_shuffle_ps(a, a, 0xff);
#endif
}

/* Rays under way. Everything is repeated for the four numbers of a ray. */
typedef struct march {
    const air_volume *volume;
    lanes start[3], step[3]; /* in voxels, from centres */
    lanes last[3], low[3];   /* the last voxel, and the last that has one behind it */
    int32_t stride[3];       /* numbers between neighbours, 0 where there is one voxel */
    lanes metres;            /* of a step */
} march;

static inline lanes each_ray(const float *values, size_t ray, size_t end)
{
    float out[LANES];
    for (size_t n = 0; n < LANES; n++) {
        const size_t at = ray + n / NUMBERS;
        out[n] = values[at < end ? at : end - 1];
    }
    return lanes_load(out);
}

static march march_make(const air_volume *volume, const air_volume_rays *rays, size_t ray,
                        size_t end, uint32_t steps)
{
    const int32_t numbers = (int32_t)volume_stride(volume);
    march m = {.volume = volume};
    const lanes t0 = each_ray(rays->t0, ray, end), t1 = each_ray(rays->t1, ray, end);
    const lanes none = lanes_all(0.0f);
    const lanes length = lanes_max(t1 - t0, none) * lanes_all(1.0f / (float)steps);
    const lanes first = lanes_madd(each_ray(rays->jitter, ray, end), length, t0);
    lanes square = none;
    for (int axis = 0; axis < 3; axis++) {
        const lanes dir = each_ray(rays->dir[axis], ray, end);
        const lanes origin = each_ray(rays->origin[axis], ray, end);
        const lanes inverse = lanes_all(1.0f / volume->voxel_m[axis]);
        square = lanes_madd(dir, dir, square);
        m.start[axis] = lanes_madd(lanes_madd(first, dir, origin), inverse, lanes_all(-0.5f));
        m.step[axis] = length * dir * inverse;
        m.last[axis] = lanes_all((float)(int32_t)volume->size[axis] - 1.0f);
        m.low[axis] = lanes_max(m.last[axis] - lanes_all(1.0f), none);
    }
    m.metres = length * lanes_root(lanes_max(square, lanes_all(1e-30f)));
    int32_t stride = numbers;
    for (int axis = 0; axis < 3; axis++) {
        m.stride[axis] = volume->size[axis] > 1 ? stride : 0;
        stride *= (int32_t)volume->size[axis];
    }
    return m;
}

/* Where points lie: the corner below, as a number of the voxels, and the shares of those above. */
typedef struct corner {
    int32_t base[WAYS];
    lanes share[3];
} corner;

static inline corner find_corner(const march *m, lanes at)
{
    lane_ints base = {0};
    corner out;
    for (int axis = 0; axis < 3; axis++) {
        const lanes position = lanes_madd(at, m->step[axis], m->start[axis]);
        const lanes held = lanes_min(lanes_max(position, lanes_all(0.0f)), m->last[axis]);
        const lane_ints low = __builtin_convertvector(lanes_min(held, m->low[axis]), lane_ints);
        out.share[axis] = held - __builtin_convertvector(low, lanes);
        base += low * m->stride[axis];
    }
    for (int way = 0; way < WAYS; way++) {
        out.base[way] = base[way * NUMBERS];
    }
    return out;
}

static inline lanes mix(lanes a, lanes b, lanes share) { return lanes_madd(b - a, share, a); }

static inline lanes sample(const march *m, const float *voxels, const corner *c)
{
    lanes plane[2];
    for (int z = 0; z < 2; z++) {
        const float *const low = voxels + z * m->stride[2], *const high = low + m->stride[1];
        const lanes a =
            mix(load_voxels(low, c->base), load_voxels(low + m->stride[0], c->base), c->share[0]);
        const lanes b =
            mix(load_voxels(high, c->base), load_voxels(high + m->stride[0], c->base), c->share[0]);
        plane[z] = mix(a, b, c->share[1]);
    }
    return mix(plane[0], plane[1], c->share[2]);
}

static void march_rays(const march *m, uint32_t steps, lanes *out_radiance, lanes *out_through)
{
    const lanes zero = lanes_all(0.0f), one = lanes_all(1.0f), most = lanes_all(87.0f);
    lanes radiance = zero, through = one, at = zero;
    for (uint32_t step = 0; step < steps; step++, at = at + one) {
        const corner c = find_corner(m, at);
        const lanes j = sample(m, m->volume->voxels, &c);
        const lanes sigma_t =
            m->volume->coloured ? sample(m, m->volume->voxels + NUMBERS, &c) : repeat_fourth(j);
        const lanes left = march_exp(zero - lanes_min(sigma_t * m->metres, most));
        radiance = lanes_madd(through * (one - left), j, radiance);
        through = through * left;
        if (!mask_any(lanes_less(lanes_all(1e-5f), through))) {
            break;
        }
    }
    *out_radiance = radiance;
    *out_through = through;
}

void VOLUME_MARCH(const air_volume *volume, const air_volume_rays *rays, size_t begin, size_t end,
                  uint32_t steps, float *const out_radiance[3], float *const out_transmittance[3])
{
    for (size_t ray = begin; ray < end; ray += WAYS) {
        const march m = march_make(volume, rays, ray, end, steps);
        lanes radiance, through;
        march_rays(&m, steps, &radiance, &through);
        for (size_t way = 0; way < WAYS && ray + way < end; way++) {
            for (size_t c = 0; c < 3; c++) {
                out_radiance[c][ray + way] = radiance[way * NUMBERS + c];
                out_transmittance[c][ray + way] = through[way * NUMBERS + c];
            }
        }
    }
}
