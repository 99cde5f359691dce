/* volume.c: voxels with the light of cells; which version of the march is taken. */
#include "ordinates/volume.h"

#include <math.h>

#include "ordinates/four.h"

enum { CHANNELS = 4 };

/* The weighted mean of eight cells; trilinear where none of them is like the voxel. */
static four gather_j(const float *const corners[8], const float weights[8], float sigma_t,
                     float inverse_range, bool bilateral)
{
    four sum = four_all(0.0f), plain = four_all(0.0f);
    float total = 0.0f;
    for (int c = 0; c < 8; c++) {
        const four j = four_load(corners[c]);
        const float difference = (j[3] - sigma_t) * inverse_range;
        const float weight = bilateral ? weights[c] * expf(-0.5f * difference * difference) : 0.0f;
        sum += weight * j;
        total += weight;
        plain += weights[c] * j;
    }
    return total < 1e-6f ? plain : sum * (1.0f / total);
}

static void fill_voxel(const air_volume *volume, const float *sigma_t, size_t voxel, four j)
{
    float *const out = volume->voxels + voxel * volume_stride(volume);
    four_store(out, j);
    out[3] = volume->coloured ? 0.0f : sigma_t[voxel];
    if (volume->coloured) {
        const float *const at = sigma_t + voxel * 3;
        memcpy(out + 4, at, 3 * sizeof *out);
        out[7] = float_min(at[0], float_min(at[1], at[2]));
    }
}

static float mean_sigma(const air_volume *volume, const float *sigma_t, size_t voxel)
{
    const float *const at = sigma_t + voxel * 3;
    return volume->coloured ? (at[0] + at[1] + at[2]) * (1.0f / 3.0f) : sigma_t[voxel];
}

void volume_fill_plain(const air_volume *volume, const float *sigma_t, const size_t cell_size[3],
                       const float *cell_j, bool bilateral, float largest, size_t begin, size_t end)
{
    const size_t *const n = volume->size;
    const float inverse_range = 1.0f / (0.1f * largest + 1e-6f);
    for (size_t k = begin; k < end; k++) {
        const volume_neighbours z = volume_find_neighbours(k, n[2], cell_size[2]);
        for (size_t j = 0; j < n[1]; j++) {
            const volume_neighbours y = volume_find_neighbours(j, n[1], cell_size[1]);
            for (size_t i = 0; i < n[0]; i++) {
                const volume_neighbours x = volume_find_neighbours(i, n[0], cell_size[0]);
                const float *corners[8];
                float weights[8];
                for (int c = 0; c < 8; c++) {
                    const size_t cx = (c & 1) != 0 ? x.high : x.low;
                    const size_t cy = (c & 2) != 0 ? y.high : y.low;
                    const size_t cz = (c & 4) != 0 ? z.high : z.low;
                    corners[c] = cell_j + ((cz * cell_size[1] + cy) * cell_size[0] + cx) * CHANNELS;
                    weights[c] = ((c & 1) != 0 ? x.share : 1.0f - x.share) *
                                 ((c & 2) != 0 ? y.share : 1.0f - y.share) *
                                 ((c & 4) != 0 ? z.share : 1.0f - z.share);
                }
                const size_t voxel = (k * n[1] + j) * n[0] + i;
                const four light = gather_j(corners, weights, mean_sigma(volume, sigma_t, voxel),
                                            inverse_range, bilateral);
                fill_voxel(volume, sigma_t, voxel, light);
            }
        }
    }
}

/* ---- the march ---- */

/* Plain: one ray, channel by channel. */
static void march_ray(const air_volume *volume, const air_volume_rays *rays, size_t ray,
                      uint32_t steps, float radiance[3], float transmittance[3])
{
    const float t0 = rays->t0[ray], length = (rays->t1[ray] - t0) / (float)steps;
    const float x = rays->dir[0][ray], y = rays->dir[1][ray], z = rays->dir[2][ray];
    const float metres = length * sqrtf(x * x + y * y + z * z);
    for (uint32_t step = 0; step < steps; step++) {
        const float t = t0 + ((float)step + rays->jitter[ray]) * length;
        float point[3], sample[8];
        for (int axis = 0; axis < 3; axis++) {
            point[axis] = rays->origin[axis][ray] + t * rays->dir[axis][ray];
        }
        volume_sample(volume, point, sample);
        for (int c = 0; c < 3; c++) {
            const float sigma_t = volume->coloured ? sample[4 + c] : sample[3];
            const float through = expf(-sigma_t * metres);
            radiance[c] += transmittance[c] * (1.0f - through) * sample[c];
            transmittance[c] *= through;
        }
    }
}

void volume_march_plain(const air_volume *volume, const air_volume_rays *rays, size_t begin,
                        size_t end, uint32_t steps, float *const out_radiance[3],
                        float *const out_transmittance[3])
{
    for (size_t ray = begin; ray < end; ray++) {
        float radiance[3] = {0.0f}, transmittance[3] = {1.0f, 1.0f, 1.0f};
        if (rays->t0[ray] < rays->t1[ray]) {
            march_ray(volume, rays, ray, steps, radiance, transmittance);
        }
        for (int c = 0; c < 3; c++) {
            out_radiance[c][ray] = radiance[c];
            out_transmittance[c][ray] = transmittance[c];
        }
    }
}

/* Lanes count a volume's numbers in 32 bits: up to 512 x 512 x 512 voxels with colours. */
static bool fits_lanes(const air_volume *volume)
{
    const size_t most = INT32_MAX / volume_stride(volume);
    return volume->size[0] <= most / volume->size[1] / volume->size[2];
}

typedef struct volume_kernel {
    volume_fill *fill;
    volume_march *march;
} volume_kernel;

static volume_kernel version_of(air_cpu cpu)
{
    switch (cpu) {
#if defined(__x86_64__)
    case AIR_CPU_AVX512:
        return (volume_kernel){volume_fill_avx512, volume_march_avx512};
    case AIR_CPU_AVX2:
        return (volume_kernel){volume_fill_avx2, volume_march_avx2};
    case AIR_CPU_SSE42:
        return (volume_kernel){volume_fill_sse42, volume_march_sse42};
#endif
    default:
        return (volume_kernel){volume_fill_plain, volume_march_plain};
    }
}

void air_volume_fill(const air_context *context, const air_volume *volume, const float *sigma_t,
                     const size_t cell_size[3], const float *cell_j, bool bilateral, float largest,
                     size_t begin, size_t end)
{
    version_of(air_context_cpu(context))
        .fill(volume, sigma_t, cell_size, cell_j, bilateral, largest, begin, end);
}

void air_volume_march(const air_context *context, const air_volume *volume,
                      const air_volume_rays *rays, size_t count, uint32_t steps,
                      float *const out_radiance[3], float *const out_transmittance[3])
{
    const air_cpu cpu = fits_lanes(volume) ? air_context_cpu(context) : AIR_CPU_C;
    version_of(cpu).march(volume, rays, 0, count, steps, out_radiance, out_transmittance);
}
