/* volume_fill_lanes.h: voxels from cells; included by files that have included volume_lanes.h and
 * define VOLUME_FILL as the function's name. Lanes are voxels of a row while corners are weighed,
 * then numbers. */
#include "ordinates/four.h"

enum { FILL_RUN = 64 /* voxels of a row at a time */ };

/* A run of voxels and their eight corners. */
typedef struct fill_run {
    size_t count;
    int32_t low[FILL_RUN + LANES], high[FILL_RUN + LANES]; /* cells along x */
    float share[FILL_RUN + LANES], sigma_t[FILL_RUN + LANES];
    const float *rows[4]; /* of cells, by y and z */
    float across[4];      /* their weights */
    float weight[8][FILL_RUN + LANES];
} fill_run;

static void fill_find_x(const air_volume *volume, size_t begin, size_t cells, fill_run *run)
{
    for (size_t n = 0; n < FILL_RUN + LANES; n++) {
        const bool in = n < run->count;
        const volume_neighbours x =
            volume_find_neighbours(begin + (in ? n : 0), volume->size[0], cells);
        run->low[n] = (int32_t)(x.low * NUMBERS);
        run->high[n] = (int32_t)(x.high * NUMBERS);
        run->share[n] = x.share;
    }
}

static void fill_find_rows(const air_volume *volume, const size_t cell_size[3], const float *cell_j,
                           size_t j, size_t k, fill_run *run)
{
    const volume_neighbours y = volume_find_neighbours(j, volume->size[1], cell_size[1]);
    const volume_neighbours z = volume_find_neighbours(k, volume->size[2], cell_size[2]);
    for (int c = 0; c < 4; c++) {
        const size_t row =
            ((c & 2) != 0 ? z.high : z.low) * cell_size[1] + ((c & 1) != 0 ? y.high : y.low);
        run->rows[c] = cell_j + row * cell_size[0] * NUMBERS;
        run->across[c] =
            ((c & 1) != 0 ? y.share : 1.0f - y.share) * ((c & 2) != 0 ? z.share : 1.0f - z.share);
    }
}

/* The mean extinction of a run's voxels. */
static void fill_find_sigma(const air_volume *volume, const float *sigma_t, fill_run *run)
{
    for (size_t n = 0; n < run->count; n++) {
        const float *const at = sigma_t + 3 * n;
        run->sigma_t[n] = volume->coloured ? (at[0] + at[1] + at[2]) * (1.0f / 3.0f) : sigma_t[n];
    }
    for (size_t n = run->count; n < run->count + LANES; n++) {
        run->sigma_t[n] = 0.0f;
    }
}

/* Weights of the corners that sum to 1; trilinear where none of them is like the voxel. */
static void fill_weigh(float inverse_range, bool bilateral, fill_run *run)
{
    /* the root of log2(e) / 2 */
    const lanes scale = lanes_all(inverse_range * 0.84932180f), one = lanes_all(1.0f);
    for (size_t n = 0; n < run->count; n += LANES) {
        const lanes share = lanes_load(run->share + n), sigma_t = lanes_load(run->sigma_t + n);
        const lanes rest = one - share;
        lanes total = lanes_all(0.0f), plain[8], like[8];
        for (int c = 0; c < 8; c++) {
            const int32_t *const cell = (c & 1) != 0 ? run->high + n : run->low + n;
            float fourth[LANES];
            for (int i = 0; i < LANES; i++) {
                fourth[i] = run->rows[c / 2][cell[i] + 3];
            }
            const lanes off = (lanes_load(fourth) - sigma_t) * scale;
            plain[c] = ((c & 1) != 0 ? share : rest) * lanes_all(run->across[c / 2]);
            like[c] =
                plain[c] * march_exp2(lanes_max(off * (lanes_all(0.0f) - off), lanes_all(-125.0f)));
            total = total + like[c];
        }
        const lane_mask found = lanes_less(lanes_all(bilateral ? 1e-6f : INFINITY), total);
        const lanes inverse = lanes_inverse(lanes_select(found, total, one));
        for (int c = 0; c < 8; c++) {
            lanes_store(run->weight[c] + n, lanes_select(found, like[c] * inverse, plain[c]));
        }
    }
}

static void fill_write(const air_volume *volume, const float *sigma_t, const fill_run *run,
                       float *out)
{
    const size_t stride = volume_stride(volume);
    for (size_t n = 0; n < run->count; n++, out += stride) {
        four sum = four_all(0.0f);
        for (int c = 0; c < 8; c++) {
            const int32_t cell = (c & 1) != 0 ? run->high[n] : run->low[n];
            sum += run->weight[c][n] * four_load(run->rows[c / 2] + cell);
        }
        sum[3] = volume->coloured ? 0.0f : sigma_t[n];
        four_store(out, sum);
        if (volume->coloured) {
            const float *const at = sigma_t + 3 * n;
            memcpy(out + 4, at, 3 * sizeof *out);
            out[7] = float_min(at[0], float_min(at[1], at[2]));
        }
    }
}

void VOLUME_FILL(const air_volume *volume, const float *sigma_t, const size_t cell_size[3],
                 const float *cell_j, bool bilateral, float largest, size_t begin, size_t end)
{
    const size_t *const size = volume->size, numbers = volume->coloured ? 3 : 1;
    const float inverse_range = 1.0f / (0.1f * largest + 1e-6f);
    fill_run run;
    for (size_t i = 0; i < size[0]; i += FILL_RUN) {
        run.count = size[0] - i < FILL_RUN ? size[0] - i : FILL_RUN;
        fill_find_x(volume, i, cell_size[0], &run);
        for (size_t row = begin * size[1]; row < end * size[1]; row++) {
            const size_t voxel = row * size[0] + i;
            fill_find_rows(volume, cell_size, cell_j, row % size[1], row / size[1], &run);
            fill_find_sigma(volume, sigma_t + voxel * numbers, &run);
            fill_weigh(inverse_range, bilateral, &run);
            fill_write(volume, sigma_t + voxel * numbers, &run,
                       volume->voxels + voxel * volume_stride(volume));
        }
    }
}
