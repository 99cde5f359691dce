/* Filling and marching through voxels, by every instruction set of this machine. */
#include "airlight/ordinates_view.h"
#include "core/random.h"
#include "ordinates_levels.h"

enum { VOXELS = 70 * 9 * 11, CELLS = 7 * 6 * 5, RAYS = 37, ROUNDS = 24 };

/* Rows longer than a run, single voxels, and what does not fill a vector. */
static const size_t sizes[][3] = {{70, 3, 2}, {1, 1, 1}, {1, 5, 3},
                                  {9, 9, 9},  {2, 2, 1}, {8, 7, 11}};
static const size_t cell_sizes[][3] = {{7, 6, 5}, {1, 1, 1}, {3, 1, 2}};

typedef struct smoke {
    air_volume volume;
    size_t count, cell_size[3], numbers; /* voxels, cells, floats per voxel */
    float sigma_t[3 * VOXELS], cell_j[4 * CELLS];
    float voxels[8 * VOXELS];
    uint8_t empty[VOXELS];
} smoke;

static void make(air_rng *rng, int round, smoke *out)
{
    out->volume = (air_volume){.coloured = round % 2 == 1, .voxels = out->voxels};
    out->count = 1;
    for (int axis = 0; axis < 3; axis++) {
        out->volume.size[axis] = sizes[round % 6][axis];
        out->volume.voxel_m[axis] = 0.1f + 0.1f * air_rng_float(rng);
        out->cell_size[axis] = cell_sizes[round % 3][axis];
        out->count *= out->volume.size[axis];
    }
    for (size_t i = 0; i < 3 * out->count; i++) {
        out->sigma_t[i] = air_rng_float(rng) < 0.3f ? 0.0f : 3.0f * air_rng_float(rng);
    }
    for (size_t i = 0; i < 4 * CELLS; i++) {
        out->cell_j[i] = (i % 4 == 3 ? 3.0f : 1.0f) * air_rng_float(rng);
    }
    out->numbers = out->count * (out->volume.coloured ? 8 : 4);
}

/* Sums of eight J up to 1 with weights that sum to 1: a few roundings. An exponent up to 40 (where
 * less than 1e-6 is left nothing is looked at) has an error of 40 roundings, by which weights are
 * off. Where 1e-6 is passed by one and not by the other the voxel is another one: not among these
 * numbers. */
static void voxels_are_filled_as_plain_c_does(void **state)
{
    static smoke fog;
    static float plain[8 * VOXELS];
    levels all = levels_make();
    air_rng rng = air_rng_from_keys(4, 4);
    double worst = 0.0;
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        make(&rng, round, &fog);
        for (int level = 0; level < all.count; level++) {
            for (size_t k = 0; k < fog.volume.size[2]; k++) {
                air_volume_fill(all.contexts[level], &fog.volume, fog.sigma_t, fog.cell_size,
                                fog.cell_j, round % 4 < 2, 3.0f, k, k + 1);
            }
            if (level == 0) {
                memcpy(plain, fog.voxels, sizeof plain);
            }
            worst = fmax(worst, levels_difference(plain, fog.voxels, fog.numbers));
        }
    }
    print_message("filling: %.1e\n", worst);
    assert_true(worst < 1e-5);
    levels_finish(&all);
}

typedef struct rays {
    float numbers[9][RAYS], out[6][RAYS];
} rays;

static void aim(air_rng *rng, const air_volume *volume, rays *out)
{
    for (int i = 0; i < RAYS; i++) {
        for (int axis = 0; axis < 3; axis++) {
            const float side = (float)volume->size[axis] * volume->voxel_m[axis];
            out->numbers[axis][i] = side * (1.5f * air_rng_float(rng) - 0.25f);
            out->numbers[3 + axis][i] = air_rng_float(rng) - 0.5f;
        }
        out->numbers[6][i] = 0.2f * air_rng_float(rng);
        out->numbers[7][i] = air_rng_float(rng) < 0.2f ? 0.1f : 5.0f * air_rng_float(rng);
        out->numbers[8][i] = air_rng_float(rng);
    }
}

static void march(const air_context *context, const air_volume *volume, rays *at)
{
    float(*const n)[RAYS] = at->numbers, (*const out)[RAYS] = at->out;
    const air_volume_rays given = {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], n[7], n[8]};
    float *const radiance[3] = {out[0], out[1], out[2]}, *const left[3] = {out[3], out[4], out[5]};
    air_volume_march(context, volume, &given, RAYS, 50, radiance, left);
}

/* Nothing in most voxels. */
static void thin_out(air_rng *rng, float share, smoke *fog)
{
    for (size_t i = 0; i < fog->count; i++) {
        if (air_rng_float(rng) < share) {
            const size_t numbers = fog->volume.coloured ? 3 : 1;
            memset(fog->sigma_t + i * numbers, 0, numbers * sizeof(float));
        }
    }
}

/* Places are off by some roundings of up to 70 voxels, 1e-5 of one, between which numbers differ by
 * up to 3; what is behind 1e-4 of transmittance may be missing. */
static void marches_do_what_plain_c_does(void **state)
{
    static smoke fog;
    static rays at, plain;
    levels all = levels_make();
    air_rng rng = air_rng_from_keys(4, 5);
    double worst = 0.0;
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        make(&rng, round, &fog);
        if (round % 3 > 0) {
            thin_out(&rng, round % 3 == 1 ? 0.97f : 0.9995f, &fog);
        }
        air_volume_fill(NULL, &fog.volume, fog.sigma_t, fog.cell_size, fog.cell_j, true, 3.0f, 0,
                        fog.volume.size[2]);
        air_volume_find_empty(&fog.volume, fog.empty);
        fog.volume.empty = round % 3 > 0 ? fog.empty : NULL;
        aim(&rng, &fog.volume, &at);
        for (int level = 0; level < all.count; level++) {
            march(all.contexts[level], &fog.volume, &at);
            plain = level == 0 ? at : plain;
            for (int i = 0; i < RAYS && level > 0; i++) {
                if (at.numbers[7][i] <= at.numbers[6][i]) {
                    assert_true(at.out[0][i] == 0.0f && at.out[3][i] == 1.0f);
                }
            }
            worst = fmax(worst, levels_difference(plain.out[0], at.out[0], 6 * RAYS));
        }
    }
    print_message("marching: %.1e\n", worst);
    assert_true(worst < 1.2e-4);
    levels_finish(&all);
}

enum { SIDE = 9 };

/* The widest cube from voxel (x, y, z) on without extinction. */
static size_t widest_from(const air_volume *volume, size_t x, size_t y, size_t z)
{
    const size_t stride = volume->coloured ? 8 : 4, first = volume->coloured ? 4 : 3;
    size_t widest = 255;
    for (size_t i = 0; i < SIDE * SIDE * SIDE; i++) {
        const size_t at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        const float *const voxel = volume->voxels + stride * i + first;
        const bool empty = voxel[0] == 0.0f && (!volume->coloured || voxel[1] + voxel[2] == 0.0f);
        if (!empty && at[0] >= x && at[1] >= y && at[2] >= z) {
            size_t away = at[0] - x;
            away = at[1] - y > away ? at[1] - y : away;
            away = at[2] - z > away ? at[2] - z : away;
            widest = away < widest ? away : widest;
        }
    }
    return widest;
}

static void voxels_know_the_widest_empty_cube_from_them_on(void **state)
{
    enum { ALL = SIDE * SIDE * SIDE };
    static float voxels[8 * ALL];
    static uint8_t empty[ALL];
    air_rng rng = air_rng_from_keys(9, 1);
    (void)state;
    for (int round = 0; round < 10; round++) {
        const air_volume volume = {
            .size = {SIDE, SIDE, SIDE}, .coloured = round % 2 == 1, .voxels = voxels};
        memset(voxels, 0, sizeof voxels);
        for (size_t i = 0; i < ALL; i++) {
            const float sigma_t = air_rng_float(&rng) < 0.003f ? 1.0f : 0.0f;
            voxels[volume.coloured ? 8 * i + 4 + i % 3 : 4 * i + 3] = sigma_t;
        }
        air_volume_find_empty(&volume, empty);
        for (size_t i = 0; i < ALL; i++) {
            assert_int_equal(empty[i],
                             widest_from(&volume, i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE));
        }
    }
}

static void rows_may_be_longer_than_bytes_count(void **state)
{
    enum { LONG = 300 };
    static float voxels[4 * LONG];
    static uint8_t empty[LONG];
    const air_volume volume = {.size = {LONG, 1, 1}, .voxels = voxels};
    (void)state;
    voxels[4 * 290 + 3] = 1.0f;
    air_volume_find_empty(&volume, empty);
    for (size_t i = 0; i < LONG; i++) {
        const size_t away = i <= 290 ? 290 - i : 255;
        assert_int_equal(empty[i], away < 255 ? away : 255);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(voxels_are_filled_as_plain_c_does),
        cmocka_unit_test(voxels_know_the_widest_empty_cube_from_them_on),
        cmocka_unit_test(rows_may_be_longer_than_bytes_count),
        cmocka_unit_test(marches_do_what_plain_c_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
