/* volume_fill_lanes.h: voxels from cells; included by files that have included volume_lanes.h and
 * define VOLUME_FILL as the function's name. Lanes are voxels of a row. */

enum { FILL_RUN = 64 /* voxels of a row at a time, whole vectors */ };

/* Numbers of the cells on one side of each voxel of a run, along x. */
typedef float fill_cells[NUMBERS][FILL_RUN];

/* A run of voxels and their eight corners. */
typedef struct fill_run {
    size_t count;
    int32_t low[FILL_RUN], high[FILL_RUN]; /* cells along x */
    float share[FILL_RUN], sigma_t[FILL_RUN];
    float across[4];      /* weights of rows of cells, by y and z */
    const float *rows[4]; /* whose numbers are in sides */
    fill_cells sides[4][2];
    int place[4]; /* of a row in sides */
} fill_run;

static void fill_find_x(const air_volume *volume, size_t begin, size_t cells, fill_run *run)
{
    for (size_t n = 0; n < FILL_RUN; n++) {
        const bool in = n < run->count;
        const volume_neighbours x =
            volume_find_neighbours(begin + (in ? n : 0), volume->size[0], cells);
        run->low[n] = (int32_t)(x.low * NUMBERS);
        run->high[n] = (int32_t)(x.high * NUMBERS);
        run->share[n] = x.share;
    }
    for (int c = 0; c < 4; c++) {
        run->rows[c] = NULL;
        run->place[c] = c;
    }
}

/* A row of cells, number by number, beside each voxel. */
static void fill_spread(const float *row, const int32_t *at, size_t count, fill_cells out)
{
    for (size_t n = 0; n < count; n += LANES) {
        lanes numbers[NUMBERS];
        transpose(load_group(row, at + n), load_group(row, at + n + 1), load_group(row, at + n + 2),
                  load_group(row, at + n + 3), numbers);
        for (int i = 0; i < NUMBERS; i++) {
            lanes_store(out[i] + n, numbers[i]);
        }
    }
}

/* Rows along y were often those above before. */
static void fill_turn(fill_run *run, const float *const rows[4])
{
    const bool turned = run->rows[1] == rows[0] && run->rows[3] == rows[2];
    for (int c = 0; c < 4 && turned; c += 2) {
        const int place = run->place[c];
        run->place[c] = run->place[c + 1];
        run->place[c + 1] = place;
        run->rows[c] = run->rows[c + 1];
        run->rows[c + 1] = NULL;
    }
}

static void fill_find_rows(const air_volume *volume, const size_t cell_size[3], const float *cell_j,
                           size_t j, size_t k, fill_run *run)
{
    const volume_neighbours y = volume_find_neighbours(j, volume->size[1], cell_size[1]);
    const volume_neighbours z = volume_find_neighbours(k, volume->size[2], cell_size[2]);
    const float *rows[4];
    for (int c = 0; c < 4; c++) {
        const size_t row =
            ((c & 2) != 0 ? z.high : z.low) * cell_size[1] + ((c & 1) != 0 ? y.high : y.low);
        rows[c] = cell_j + row * cell_size[0] * NUMBERS;
        run->across[c] =
            ((c & 1) != 0 ? y.share : 1.0f - y.share) * ((c & 2) != 0 ? z.share : 1.0f - z.share);
    }
    fill_turn(run, rows);
    for (int c = 0; c < 4; c++) {
        if (run->rows[c] != rows[c]) {
            fill_spread(rows[c], run->low, run->count, run->sides[run->place[c]][0]);
            fill_spread(rows[c], run->high, run->count, run->sides[run->place[c]][1]);
            run->rows[c] = rows[c];
        }
    }
}

/* The mean extinction of a run's voxels. */
static void fill_find_sigma(const air_volume *volume, const float *sigma_t, fill_run *run)
{
    for (size_t n = 0; n < run->count; n++) {
        const float *const at = sigma_t + 3 * n;
        run->sigma_t[n] = volume->coloured ? (at[0] + at[1] + at[2]) * (1.0f / 3.0f) : sigma_t[n];
    }
}

/* Sums of the corners' J times weights, and of these, of the voxels from n on; `alike`: weights are
 * less the more a corner's extinction differs. */
static inline lanes fill_sum(const fill_run *run, size_t n, bool alike, float inverse_range,
                             lanes out[3])
{
    /* the root of log2(e) / 2 */
    const lanes scale = lanes_all(inverse_range * 0.84932180f), none = lanes_all(0.0f);
    const lanes high = lanes_load(run->share + n), low = lanes_all(1.0f) - high;
    const lanes sigma_t = lanes_load(run->sigma_t + n);
    lanes total = none;
    out[0] = out[1] = out[2] = none;
    for (int c = 0; c < 8; c++) {
        const fill_cells *const side = &run->sides[run->place[c / 2]][c & 1];
        lanes weight = ((c & 1) != 0 ? high : low) * lanes_all(run->across[c / 2]);
        if (alike) {
            const lanes off = (lanes_load((*side)[3] + n) - sigma_t) * scale;
            weight = weight * lanes_exp2(lanes_max(off * (none - off), lanes_all(-125.0f)));
        }
        for (int i = 0; i < 3; i++) {
            out[i] = lanes_madd(weight, lanes_load((*side)[i] + n), out[i]);
        }
        total = total + weight;
    }
    return total;
}

/* J of the voxels from n on: trilinear where no corner is like the voxel. */
static inline void fill_mix(const fill_run *run, size_t n, bool bilateral, float inverse_range,
                            lanes out[3])
{
    const lanes least = lanes_all(bilateral ? 1e-6f : INFINITY);
    lanes total = lanes_all(0.0f), plain[3];
    out[0] = out[1] = out[2] = total;
    if (bilateral) {
        total = fill_sum(run, n, true, inverse_range, out);
    }
    const lanes inverse = lanes_inverse(lanes_max(total, lanes_all(1e-6f)));
    const lane_mask unlike = lanes_less(total, least);
    for (int i = 0; i < 3; i++) {
        out[i] = out[i] * inverse;
    }
    if (mask_any(unlike)) {
        (void)fill_sum(run, n, false, 0.0f, plain);
        for (int i = 0; i < 3; i++) {
            out[i] = lanes_select(unlike, plain[i], out[i]);
        }
    }
}

/* Voxels from n on, number after number. */
static inline void fill_give(const air_volume *volume, const fill_run *run, size_t n,
                             const lanes j[3], float *out)
{
    const size_t stride = volume_stride(volume);
    const size_t count = run->count - n < LANES ? run->count - n : LANES;
    lanes groups[NUMBERS];
    transpose(j[0], j[1], j[2], volume->coloured ? lanes_all(0.0f) : lanes_load(run->sigma_t + n),
              groups);
    float numbers[NUMBERS][LANES];
    memcpy(numbers, groups, sizeof numbers);
    for (size_t i = 0; i < count; i++) {
        memcpy(out + i * stride, numbers[i % 4] + i / 4 * 4, NUMBERS * sizeof *out);
    }
}

static void fill_give_colours(const float *sigma_t, size_t count, float *out)
{
    for (size_t n = 0; n < count; n++, out += 8) {
        const float *const at = sigma_t + 3 * n;
        memcpy(out + 4, at, 3 * sizeof *out);
        out[7] = float_min(at[0], float_min(at[1], at[2]));
    }
}

static void fill_run_of(const air_volume *volume, const float *sigma_t, bool bilateral,
                        float inverse_range, fill_run *run, float *out)
{
    fill_find_sigma(volume, sigma_t, run);
    for (size_t n = 0; n < run->count; n += LANES) {
        lanes j[3];
        fill_mix(run, n, bilateral, inverse_range, j);
        fill_give(volume, run, n, j, out + n * volume_stride(volume));
    }
    if (volume->coloured) {
        fill_give_colours(sigma_t, run->count, out);
    }
}

void VOLUME_FILL(const air_volume *volume, const float *sigma_t, const size_t cell_size[3],
                 const float *cell_j, bool bilateral, float largest, size_t begin, size_t end)
{
    const size_t *const size = volume->size, numbers = volume->coloured ? 3 : 1;
    const float inverse_range = 1.0f / (0.1f * largest + 1e-6f);
    fill_run run;
    memset(run.sigma_t, 0, sizeof run.sigma_t);
    for (size_t i = 0; i < size[0]; i += FILL_RUN) {
        run.count = size[0] - i < FILL_RUN ? size[0] - i : FILL_RUN;
        fill_find_x(volume, i, cell_size[0], &run);
        for (size_t row = begin * size[1]; row < end * size[1]; row++) {
            const size_t voxel = row * size[0] + i;
            fill_find_rows(volume, cell_size, cell_j, row % size[1], row / size[1], &run);
            fill_run_of(volume, sigma_t + voxel * numbers, bilateral, inverse_range, &run,
                        volume->voxels + voxel * volume_stride(volume));
        }
    }
}
