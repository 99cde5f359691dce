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

/* One more than the least of three of a row that came before. */
static void spread_row(const float *before, size_t count, float *row)
{
    for (size_t i = 0; i < count; i++) {
        const float low = before[i > 0 ? i - 1 : i], high = before[i + 1 < count ? i + 1 : i];
        row[i] = float_min(row[i], float_min(before[i], float_min(low, high)) + 1.0f);
    }
}

/* Chessboard distances from what came before in the order of `way` [Rosenfeld1966]: a row of
 * blocks from its like one slab before and that one's neighbours, from the row before in its slab,
 * and along itself. */
static void spread(const ptrdiff_t count[3], ptrdiff_t way, float *out)
{
    for (ptrdiff_t n = 0; n < count[1] * count[2]; n++) {
        const ptrdiff_t at = way > 0 ? n : count[1] * count[2] - 1 - n;
        const ptrdiff_t y = at % count[1], z = at / count[1], line = count[0];
        float *const row = out + at * line;
        for (ptrdiff_t side = -1; side <= 1; side++) {
            if (z - way >= 0 && z - way < count[2] && y + side >= 0 && y + side < count[1]) {
                spread_row(row + (side - way * count[1]) * line, (size_t)line, row);
            }
        }
        if (y - way >= 0 && y - way < count[1]) {
            spread_row(row - way * line, (size_t)line, row);
        }
        for (ptrdiff_t i = 1; i < line; i++) {
            float *const next = way > 0 ? row + i : row + line - 1 - i;
            *next = float_min(*next, next[-way] + 1.0f);
        }
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
