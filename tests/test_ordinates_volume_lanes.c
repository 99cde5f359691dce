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
    float voxels[8 * VOXELS], empty[VOXELS];
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

static size_t apart(size_t a, size_t b) { return a > b ? a - b : b - a; }

/* Blocks between a block and a voxel along an axis; one on a side belongs to both. */
static size_t blocks_between(size_t block, size_t voxel)
{
    const size_t own = voxel / AIR_VOLUME_BLOCK;
    const size_t before = voxel % AIR_VOLUME_BLOCK == 0 && own > 0 ? own - 1 : own;
    return apart(own, block) < apart(before, block) ? apart(own, block) : apart(before, block);
}

static size_t nearest_of(const float *voxels, size_t x, size_t y, size_t z)
{
    size_t nearest = 255;
    for (size_t i = 0; i < SIDE * SIDE * SIDE; i++) {
        size_t away = blocks_between(x, i % SIDE);
        const size_t along_y = blocks_between(y, i / SIDE % SIDE);
        const size_t along_z = blocks_between(z, i / SIDE / SIDE);
        away = along_y > away ? along_y : away;
        away = along_z > away ? along_z : away;
        nearest = voxels[4 * i + 3] > 0.0f && away < nearest ? away : nearest;
    }
    return nearest;
}

static void empty_blocks_know_the_nearest_that_are_not(void **state)
{
    static float voxels[4 * SIDE * SIDE * SIDE], empty[SIDE * SIDE * SIDE];
    const air_volume volume = {.size = {SIDE, SIDE, SIDE}, .voxels = voxels};
    const size_t blocks = (SIDE + AIR_VOLUME_BLOCK - 1) / AIR_VOLUME_BLOCK;
    air_rng rng = air_rng_from_keys(9, 1);
    (void)state;
    assert_int_equal(air_volume_block_count(&volume), blocks * blocks * blocks);
    for (int round = 0; round < 10; round++) {
        for (size_t i = 0; i < SIDE * SIDE * SIDE; i++) {
            voxels[4 * i + 3] = air_rng_float(&rng) < 0.003f ? 1.0f : 0.0f;
        }
        air_volume_find_empty(&volume, empty);
        for (size_t b = 0; b < blocks * blocks * blocks; b++) {
            const size_t expected =
                nearest_of(voxels, b % blocks, b / blocks % blocks, b / blocks / blocks);
            assert_true(empty[b] == (float)(ptrdiff_t)expected);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(voxels_are_filled_as_plain_c_does),
        cmocka_unit_test(empty_blocks_know_the_nearest_that_are_not),
        cmocka_unit_test(marches_do_what_plain_c_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
