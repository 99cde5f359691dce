/* volume.h: what the versions of filling and marching share. */
#ifndef AIR_ORDINATES_VOLUME_H
#define AIR_ORDINATES_VOLUME_H

#include "airlight/ordinates_view.h"
#include "core/vec.h"

typedef void volume_march(const air_volume *volume, const air_volume_rays *rays, size_t begin,
                          size_t end, uint32_t steps, float *const out_radiance[3],
                          float *const out_transmittance[3]);

volume_march volume_march_plain, volume_march_sse42, volume_march_avx2, volume_march_avx512;

typedef void volume_fill(const air_volume *volume, const float *sigma_t, const size_t cell_size[3],
                         const float *cell_j, bool bilateral, float largest, size_t begin,
                         size_t end);

volume_fill volume_fill_plain, volume_fill_sse42, volume_fill_avx2, volume_fill_avx512;

/* Neighbouring cells of a voxel's centre along one axis. */
typedef struct volume_neighbours {
    size_t low, high;
    float share; /* of high */
} volume_neighbours;

static inline volume_neighbours volume_find_neighbours(size_t voxel, size_t voxels, size_t cells)
{
    const float at =
        ((float)(ptrdiff_t)voxel + 0.5f) * (float)(ptrdiff_t)cells / (float)(ptrdiff_t)voxels -
        0.5f;
    const float last = (float)(ptrdiff_t)cells - 1.0f;
    const float held = float_min(float_max(at, 0.0f), last);
    const size_t low = (size_t)held;
    return (volume_neighbours){low, low + 1 < cells ? low + 1 : low, held - (float)(ptrdiff_t)low};
}

/* Floats per voxel. */
static inline size_t volume_stride(const air_volume *volume) { return volume->coloured ? 8 : 4; }

/* Trilinear. */
static inline void volume_sample(const air_volume *volume, const float point[3], float *out)
{
    const size_t stride = volume_stride(volume);
    size_t low[3], high[3];
    float share[3];
    for (int axis = 0; axis < 3; axis++) {
        const float last = (float)(ptrdiff_t)volume->size[axis] - 1.0f;
        const float at = point[axis] / volume->voxel_m[axis] - 0.5f;
        const float held = float_min(float_max(at, 0.0f), last);
        low[axis] = (size_t)held;
        high[axis] = low[axis] + 1 < volume->size[axis] ? low[axis] + 1 : low[axis];
        share[axis] = held - (float)(ptrdiff_t)low[axis];
    }
    for (size_t n = 0; n < stride; n++) {
        out[n] = 0.0f;
    }
    for (int c = 0; c < 8; c++) {
        const size_t x = (c & 1) != 0 ? high[0] : low[0], y = (c & 2) != 0 ? high[1] : low[1];
        const size_t z = (c & 4) != 0 ? high[2] : low[2];
        const float weight = ((c & 1) != 0 ? share[0] : 1.0f - share[0]) *
                             ((c & 2) != 0 ? share[1] : 1.0f - share[1]) *
                             ((c & 4) != 0 ? share[2] : 1.0f - share[2]);
        const float *const at =
            volume->voxels + ((z * volume->size[1] + y) * volume->size[0] + x) * stride;
        for (size_t n = 0; n < stride; n++) {
            out[n] += weight * at[n];
        }
    }
}

#endif
