/* volume_empty.c: where marches need not look. */
#include "ordinates/volume.h"

enum { BLOCK = AIR_VOLUME_BLOCK, MOST = 255 };

size_t air_volume_block_count(const air_volume *volume)
{
    return volume_blocks(volume->size[0]) * volume_blocks(volume->size[1]) *
           volume_blocks(volume->size[2]);
}

static bool is_row_empty(const air_volume *volume, const float *row, size_t count)
{
    const size_t stride = volume_stride(volume);
    float most = 0.0f;
    for (size_t i = 0; i < count; i++, row += stride) {
        most = float_max(most,
                         volume->coloured ? float_max(row[4], float_max(row[5], row[6])) : row[3]);
    }
    return most <= 0.0f;
}

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* Points of block b lie between voxels BLOCK b and BLOCK (b + 1) along each axis. */
static bool is_block_empty(const air_volume *volume, size_t x, size_t y, size_t z)
{
    const size_t *const size = volume->size;
    const size_t count = least(size[0] - x * BLOCK, BLOCK + 1);
    for (size_t k = z * BLOCK; k < least(size[2], z * BLOCK + BLOCK + 1); k++) {
        for (size_t j = y * BLOCK; j < least(size[1], y * BLOCK + BLOCK + 1); j++) {
            const size_t voxel = (k * size[1] + j) * size[0] + x * BLOCK;
            if (!is_row_empty(volume, volume->voxels + voxel * volume_stride(volume), count)) {
                return false;
            }
        }
    }
    return true;
}

/* One more than the least of the 13 neighbours that come before in the order of `way`. */
static float from_before(const float *out, const ptrdiff_t count[3], const ptrdiff_t at[3],
                         ptrdiff_t way)
{
    float nearest = MOST;
    for (ptrdiff_t n = 0; n < 13; n++) {
        const ptrdiff_t x = at[0] + way * (n % 3 - 1), y = at[1] + way * (n / 3 % 3 - 1);
        const ptrdiff_t z = at[2] + way * (n / 9 - 1);
        if (x >= 0 && x < count[0] && y >= 0 && y < count[1] && z >= 0 && z < count[2]) {
            const float there = out[(z * count[1] + y) * count[0] + x] + 1.0f;
            nearest = there < nearest ? there : nearest;
        }
    }
    return nearest;
}

/* Chessboard distances, forth and back [Rosenfeld1966]. */
static void spread(const ptrdiff_t count[3], ptrdiff_t way, float *out)
{
    const ptrdiff_t all = count[0] * count[1] * count[2];
    for (ptrdiff_t n = 0; n < all; n++) {
        const ptrdiff_t i = way > 0 ? n : all - 1 - n;
        const ptrdiff_t at[3] = {i % count[0], i / count[0] % count[1], i / count[0] / count[1]};
        const float found = out[i] > 0.0f ? from_before(out, count, at, way) : 0.0f;
        out[i] = found < out[i] ? found : out[i];
    }
}

void air_volume_find_empty(const air_volume *volume, float *out)
{
    const ptrdiff_t count[3] = {(ptrdiff_t)volume_blocks(volume->size[0]),
                                (ptrdiff_t)volume_blocks(volume->size[1]),
                                (ptrdiff_t)volume_blocks(volume->size[2])};
    float *to = out;
    for (ptrdiff_t z = 0; z < count[2]; z++) {
        for (ptrdiff_t y = 0; y < count[1]; y++) {
            for (ptrdiff_t x = 0; x < count[0]; x++) {
                *to++ = is_block_empty(volume, (size_t)x, (size_t)y, (size_t)z) ? MOST : 0.0f;
            }
        }
    }
    spread(count, 1, out);
    spread(count, -1, out);
}
