/* volume_empty.c: where marches need not look. */
#include <string.h>

#include "ordinates/volume.h"

enum { MOST = 255, RUN = 64 /* voxels of a row at a time */ };

static inline unsigned lesser(unsigned a, unsigned b) { return a < b ? a : b; }

/* out becomes the lesser of it and of each number and its successor. */
static void lessen(const uint8_t *row, size_t count, bool last, uint8_t *out)
{
    const size_t pairs = count - (last ? 1 : 0);
    for (size_t i = 0; i < pairs; i++) {
        const uint8_t both = row[i] < row[i + 1] ? row[i] : row[i + 1];
        out[i] = both < out[i] ? both : out[i];
    }
    if (last) {
        out[pairs] = row[pairs] < out[pairs] ? row[pairs] : out[pairs];
    }
}

static void find_free(const air_volume *volume, size_t voxel, size_t count, uint8_t *out)
{
    const float *const grey = volume->voxels + 4 * voxel + 3;
    const float *const coloured = volume->voxels + 8 * voxel + 4;
    for (size_t i = 0; i < count && !volume->coloured; i++) {
        out[i] = grey[4 * i] <= 0.0f ? 1 : 0;
    }
    for (size_t i = 0; i < count && volume->coloured; i++) {
        const float *const at = coloured + 8 * i;
        out[i] = float_max(at[0], float_max(at[1], at[2])) <= 0.0f ? 1 : 0;
    }
}

/* A run of a row, of which all above is known: an empty voxel's cube is by one wider than the least
 * of its seven neighbours'. `next`: the one behind the run. */
static unsigned grow_run(const air_volume *volume, size_t voxel, size_t count, bool last,
                         const bool above[2], unsigned next, uint8_t *out)
{
    const size_t line = volume->size[0], slab = line * volume->size[1];
    uint8_t least[RUN], free[RUN] = {0};
    memset(least, MOST, sizeof least);
    find_free(volume, voxel, count, free);
    if (above[0]) {
        lessen(out + line, count, last, least);
    }
    if (above[1]) {
        lessen(out + slab, count, last, least);
    }
    if (above[0] && above[1]) {
        lessen(out + slab + line, count, last, least);
    }
    for (size_t i = 0; i < RUN; i++) {
        const uint8_t wider = least[i] < MOST ? (uint8_t)(least[i] + 1) : MOST;
        least[i] = free[i] != 0 ? wider : 0;
    }
    for (size_t i = count; i-- > 0;) {
        next = lesser(next + 1, least[i]);
        out[i] = (uint8_t)next;
    }
    return next;
}

void air_volume_find_empty(const air_volume *volume, uint8_t *out)
{
    const size_t *const size = volume->size;
    for (size_t row = size[1] * size[2]; row-- > 0;) {
        const bool above[2] = {(row + 1) % size[1] != 0, row / size[1] + 1 < size[2]};
        unsigned next = MOST;
        for (size_t run = (size[0] + RUN - 1) / RUN; run-- > 0;) {
            const size_t begin = run * RUN, voxel = row * size[0] + begin;
            const bool last = begin + RUN >= size[0];
            next = grow_run(volume, voxel, last ? size[0] - begin : RUN, last, above, next,
                            out + voxel);
        }
    }
}
