/* Volumes: light of cells in voxels, and the march through them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_view.h"
#include "cmocka_test.h"
#include "random_geometry.h"

enum { CHANNELS = 4, RAYS = 37 };

static float *numbers(size_t count)
{
    float *const out = calloc(count, sizeof *out);
    assert_non_null(out);
    return out;
}

static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance)) {
        fail_msg("%.9g, expected %.9g within %g", found, expected, tolerance);
    }
}

static size_t count_of(const size_t size[3]) { return size[0] * size[1] * size[2]; }

static size_t stride_of(const air_volume *volume) { return volume->coloured ? 8 : 4; }

/* ---- filling ---- */

/* Cells of a light that rises evenly, of extinction sigma. */
static float *linear_cells(const size_t size[3], float sigma)
{
    float *const cells = numbers(count_of(size) * CHANNELS);
    for (size_t cell = 0; cell < count_of(size); cell++) {
        const double x = ((double)(cell % size[0]) + 0.5) / (double)size[0];
        const double y = ((double)(cell / size[0] % size[1]) + 0.5) / (double)size[1];
        const double z = ((double)(cell / size[0] / size[1]) + 0.5) / (double)size[2];
        for (int c = 0; c < 3; c++) {
            cells[cell * CHANNELS + (size_t)c] = (float)(1.0 + x + 2.0 * y * (1.0 + c) - z);
        }
        cells[cell * CHANNELS + 3] = sigma;
    }
    return cells;
}

static air_volume make_volume(size_t x, size_t y, size_t z, bool coloured)
{
    air_volume out = {
        {x, y, z}, {1.0f / (float)x, 1.0f / (float)y, 1.0f / (float)z}, coloured, NULL, NULL};
    out.voxels = numbers(x * y * z * 8);
    return out;
}

/* Where a voxel's centre is along an axis, held where the outermost cells' are. */
static double held(size_t at, size_t voxels, size_t cells)
{
    const double x = ((double)at + 0.5) / (double)voxels, half = 0.5 / (double)cells;
    return fmin(fmax(x, half), 1.0 - half);
}

/* Of sums of up to 8, in float. */
static void lines_stay_lines(void **state)
{
    (void)state;
    static const size_t cell_sizes[3][3] = {{5, 4, 3}, {16, 1, 2}, {1, 1, 1}};
    for (int n = 0; n < 6; n++) {
        const size_t *const cell_size = cell_sizes[n / 2];
        const bool bilateral = n % 2 == 1; /* the same where all extinctions are */
        air_volume volume = make_volume(12, 7, 9, false);
        float *const cells = linear_cells(cell_size, 2.0f);
        float *const sigma = numbers(12 * 7 * 9);
        for (size_t i = 0; i < count_of(volume.size); i++) {
            sigma[i] = 2.0f;
        }
        air_volume_fill(NULL, &volume, sigma, cell_size, cells, bilateral, 5.0f, 0, 4);
        air_volume_fill(NULL, &volume, sigma, cell_size, cells, bilateral, 5.0f, 4, 9);
        for (size_t i = 0; i < count_of(volume.size); i++) {
            const double x = held(i % 12, 12, cell_size[0]);
            const double y = held(i / 12 % 7, 7, cell_size[1]);
            const double z = held(i / 84, 9, cell_size[2]);
            for (int c = 0; c < 3; c++) {
                assert_near((double)volume.voxels[i * 4 + (size_t)c],
                            1.0 + x + 2.0 * y * (1.0 + c) - z, 3e-6);
            }
            assert_true(volume.voxels[i * 4 + 3] == 2.0f);
        }
        free(cells);
        free(sigma);
        free(volume.voxels);
    }
}

/* Whatever the extinctions are; far from all of them it is trilinear. */
static void constants_stay_constant(void **state)
{
    (void)state;
    const size_t cell_size[3] = {4, 5, 3};
    air_rng rng = air_rng_from_keys(1, 4);
    for (int n = 0; n < 4; n++) {
        const bool coloured = n % 2 == 1;
        air_volume volume = make_volume(9, 8, 7, coloured);
        float *const cells = numbers(count_of(cell_size) * CHANNELS);
        float *const sigma = numbers(count_of(volume.size) * 3);
        for (size_t i = 0; i < count_of(cell_size); i++) {
            for (size_t c = 0; c < 3; c++) {
                cells[i * CHANNELS + c] = 3.0f + (float)c;
            }
            cells[i * CHANNELS + 3] = (float)random_between(&rng, 0.0, 10.0);
        }
        for (size_t i = 0; i < count_of(volume.size) * 3; i++) {
            sigma[i] = (float)random_between(&rng, 0.0, n < 2 ? 10.0 : 1000.0);
        }
        air_volume_fill(NULL, &volume, sigma, cell_size, cells, true, 10.0f, 0, 7);
        for (size_t i = 0; i < count_of(volume.size); i++) {
            const float *const voxel = volume.voxels + i * stride_of(&volume);
            for (size_t c = 0; c < 3; c++) {
                assert_near((double)voxel[c], 3.0 + (double)c, 5e-6);
                assert_true(!coloured || voxel[4 + c] == sigma[i * 3 + c]);
            }
            assert_true(coloured ? voxel[3] == 0.0f &&
                                       voxel[7] == fminf(voxel[4], fminf(voxel[5], voxel[6]))
                                 : voxel[3] == sigma[i]);
        }
        free(cells);
        free(sigma);
        free(volume.voxels);
    }
}

/* Between a dense and a thin cell, voxels have the light of the one that they are like. */
static void voxels_take_the_light_of_their_like(void **state)
{
    (void)state;
    const size_t cell_size[3] = {2, 1, 1};
    const float cells[8] = {1, 1, 1, 10, 5, 5, 5, 0};
    const float sigma[4] = {10, 10, 0, 0};
    air_volume volume = make_volume(4, 1, 1, false);
    air_volume_fill(NULL, &volume, sigma, cell_size, cells, true, 10.0f, 0, 1);
    for (int i = 0; i < 4; i++) {
        assert_near((double)volume.voxels[i * 4], i < 2 ? 1.0 : 5.0, 1e-6);
    }
    free(volume.voxels);
}

/* ---- marching ---- */

/* Rays and what came of them. */
typedef struct marching {
    float numbers[9][RAYS];
    air_volume_rays rays;
    float light[3][RAYS], through[3][RAYS];
} marching;

static void point_at(marching *self)
{
    self->rays = (air_volume_rays){{self->numbers[0], self->numbers[1], self->numbers[2]},
                                   {self->numbers[3], self->numbers[4], self->numbers[5]},
                                   self->numbers[6],
                                   self->numbers[7],
                                   self->numbers[8]};
}

/* From one point of the unit cube to another, dir of lengths from 0.1 to 10. */
static void random_rays(marching *self, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, 2);
    for (int i = 0; i < RAYS; i++) {
        const double length = pow(10.0, random_between(&rng, -1.0, 1.0)), t0 = 0.5;
        double way[3], square = 0.0;
        for (int k = 0; k < 3; k++) {
            const double a = random_unit(&rng), b = random_unit(&rng);
            way[k] = b - a;
            square += way[k] * way[k];
            self->numbers[k][i] = (float)a;
        }
        for (int k = 0; k < 3; k++) { /* begin at t = 1/2 */
            const double d = way[k] / sqrt(square) * length;
            self->numbers[k][i] -= (float)(t0 * d);
            self->numbers[3 + k][i] = (float)d;
        }
        self->numbers[6][i] = (float)t0;
        self->numbers[7][i] = (float)(t0 + sqrt(square) / length);
        self->numbers[8][i] = (float)random_unit(&rng);
    }
}

static air_context *make_context(air_cpu cpu)
{
    air_context_params params;
    air_context *context = NULL;
    air_context_params_default(&params);
    params.cpu = cpu;
    return air_context_create(&params, &context) == AIR_OK ? context : NULL;
}

static void march(air_context *context, const air_volume *volume, marching *self, uint32_t steps)
{
    float *const light[3] = {self->light[0], self->light[1], self->light[2]};
    float *const through[3] = {self->through[0], self->through[1], self->through[2]};
    memset(self->light, 0x7f, sizeof self->light);
    point_at(self);
    air_volume_march(context, volume, &self->rays, RAYS, steps, light, through);
}

static double length_of(const marching *self, int ray)
{
    double square = 0.0;
    for (int k = 0; k < 3; k++) {
        square += (double)self->numbers[3 + k][ray] * (double)self->numbers[3 + k][ray];
    }
    return sqrt(square) * ((double)self->numbers[7][ray] - (double)self->numbers[6][ray]);
}

/* Voxels alike. */
static air_volume even_volume(size_t x, size_t y, size_t z, bool coloured)
{
    air_volume volume = make_volume(x, y, z, coloured);
    for (size_t i = 0; i < x * y * z; i++) {
        float *const voxel = volume.voxels + i * stride_of(&volume);
        for (size_t c = 0; c < 3; c++) {
            voxel[c] = 1.0f + (float)c;
            voxel[(coloured ? 4 : 3) + c * (coloured ? 1 : 0)] = coloured ? 1.0f + (float)c : 2.0f;
        }
        voxel[coloured ? 7 : 3] = coloured ? 1.0f : 2.0f;
    }
    return volume;
}

static void assert_even_light(const marching *self, bool coloured)
{
    for (int i = 0; i < RAYS; i++) {
        for (int c = 0; c < 3; c++) {
            const double sigma = coloured ? 1.0 + c : 2.0;
            const double through = exp(-sigma * length_of(self, i));
            /* 64 products in float, and exponentials to 2e-6 */
            assert_near((double)self->through[c][i], through, 1e-5);
            assert_near((double)self->light[c][i], (1.0 + c) * (1.0 - through), 3e-5);
        }
    }
}

static const air_cpu cpus[4] = {AIR_CPU_C, AIR_CPU_SSE42, AIR_CPU_AVX2, AIR_CPU_AVX512};

/* J (1 - exp(-sigma s)) whatever the steps; and where there are as few voxels as one. */
static void even_volumes_have_their_closed_form(void **state)
{
    (void)state;
    static const size_t sizes[5][3] = {{4, 5, 6}, {1, 1, 1}, {1, 8, 3}, {2, 1, 9}, {7, 2, 1}};
    for (int n = 0; n < 4; n++) {
        air_context *context = make_context(cpus[n]);
        for (int k = 0; context != NULL && k < 10; k++) {
            const size_t *const size = sizes[k / 2];
            air_volume volume = even_volume(size[0], size[1], size[2], k % 2 == 1);
            marching self;
            random_rays(&self, (uint32_t)k);
            for (uint32_t steps = 1; steps <= 64; steps *= 4) {
                march(context, &volume, &self, steps);
                assert_even_light(&self, k % 2 == 1);
            }
            free(volume.voxels);
        }
        air_context_destroy(context);
    }
}

/* Rays that miss, as slab tests tell it, with any sign. */
static void rays_that_end_before_they_begin_see_nothing(void **state)
{
    (void)state;
    for (int n = 0; n < 4; n++) {
        air_context *context = make_context(cpus[n]);
        if (context != NULL) {
            air_volume volume = even_volume(4, 5, 6, n % 2 == 1);
            marching self;
            random_rays(&self, 3);
            for (int i = 0; i < RAYS; i += 2) {
                const bool endless = i % 4 == 0;
                self.numbers[6][i] = endless ? INFINITY : 2.0f;
                self.numbers[7][i] = i % 8 == 2 ? 2.0f : endless ? -INFINITY : -1.0f;
                self.numbers[3][i] = i % 3 == 0 ? 0.0f : self.numbers[3][i];
            }
            march(context, &volume, &self, 8);
            for (int i = 0; i < RAYS; i += 2) {
                for (int c = 0; c < 3; c++) {
                    assert_true(self.light[c][i] == 0.0f);
                    assert_true(self.through[c][i] == 1.0f);
                }
            }
            assert_true(self.light[0][1] > 0.0f && self.through[0][1] < 1.0f);
            free(volume.voxels);
        }
        air_context_destroy(context);
    }
}

/* Smooth, with a void. */
static air_volume wavy_volume(bool coloured, float sigma)
{
    air_volume volume = make_volume(13, 11, 12, coloured);
    for (size_t i = 0; i < count_of(volume.size); i++) {
        float *const voxel = volume.voxels + i * stride_of(&volume);
        const double x = (double)(i % 13), y = (double)(i / 13 % 11), z = (double)(i / 143);
        const float density = (float)fmax(0.0, 1.0 + sin(0.5 * x) + cos(0.4 * y + 0.2 * z));
        for (size_t c = 0; c < 3; c++) {
            voxel[c] = (float)(2.0 + sin(0.3 * x + 0.7 * (double)c) * cos(0.5 * z));
        }
        voxel[3] = coloured ? 0.0f : sigma * density;
        for (size_t c = 4; coloured && c < 8; c++) {
            voxel[c] = sigma * density * (c < 7 ? 1.0f + 0.5f * (float)(c - 4) : 1.0f);
        }
    }
    return volume;
}

static void a_colour_that_is_grey_is_as_grey(void **state)
{
    (void)state;
    for (int n = 0; n < 4; n++) {
        air_context *context = make_context(cpus[n]);
        if (context != NULL) {
            air_volume grey = wavy_volume(false, 3.0f), coloured = make_volume(13, 11, 12, true);
            marching a, b;
            for (size_t i = 0; i < count_of(grey.size); i++) {
                memcpy(coloured.voxels + i * 8, grey.voxels + i * 4, 3 * sizeof(float));
                for (size_t c = 4; c < 8; c++) {
                    coloured.voxels[i * 8 + c] = grey.voxels[i * 4 + 3];
                }
            }
            random_rays(&a, 5);
            random_rays(&b, 5);
            march(context, &grey, &a, 20);
            march(context, &coloured, &b, 20);
            for (int i = 0; i < RAYS; i++) { /* as below: where they end may differ */
                for (int c = 0; c < 3; c++) {
                    assert_near((double)a.light[c][i], (double)b.light[c][i], 3e-4);
                    assert_near((double)a.through[c][i], (double)b.through[c][i], 1e-4);
                }
            }
            free(grey.voxels);
            free(coloured.voxels);
        }
        air_context_destroy(context);
    }
}

/* Rounding of 24 steps in float; exponentials to 2e-6; the lanes end at a transmittance of 1e-4,
 * beyond which is no more than 3 times that. */
static void instruction_sets_agree(void **state)
{
    (void)state;
    air_context *plain = make_context(AIR_CPU_C);
    for (int n = 1; n < 4; n++) {
        air_context *context = make_context(cpus[n]);
        for (int k = 0; context != NULL && k < 8; k++) {
            air_volume volume = wavy_volume(k % 2 == 1, k / 2 % 2 == 1 ? 100.0f : 2.0f);
            marching a, b;
            random_rays(&a, (uint32_t)k);
            random_rays(&b, (uint32_t)k);
            march(plain, &volume, &a, 24);
            march(context, &volume, &b, 24);
            for (int i = 0; i < RAYS; i++) {
                for (int c = 0; c < 3; c++) {
                    assert_near((double)a.light[c][i], (double)b.light[c][i], 3e-4);
                    assert_near((double)a.through[c][i], (double)b.through[c][i], 1e-4);
                }
            }
            free(volume.voxels);
        }
        air_context_destroy(context);
    }
    air_context_destroy(plain);
}

/* With looks in the middle of steps the error falls as the square of their length: a quarter, until
 * float's rounding. Twice as many steps in a smooth volume: at most 0.4 of it. */
static void more_steps_are_nearer(void **state)
{
    (void)state;
    air_context *context = make_context(AIR_CPU_C);
    air_volume volume = wavy_volume(true, 3.0f);
    marching fine, self;
    double last = 0.0;
    random_rays(&fine, 11);
    random_rays(&self, 11);
    for (int i = 0; i < RAYS; i++) {
        fine.numbers[8][i] = self.numbers[8][i] = 0.5f;
    }
    march(context, &volume, &fine, 1024);
    for (uint32_t steps = 8; steps <= 64; steps *= 2) {
        double square = 0.0;
        march(context, &volume, &self, steps);
        for (int i = 0; i < RAYS; i++) {
            square += pow((double)(self.light[0][i] - fine.light[0][i]), 2.0);
        }
        const double rms = sqrt(square / RAYS);
        print_message("%u steps: rms %.2g\n", steps, rms);
        assert_true(steps == 8 || rms < 0.4 * last);
        last = rms;
    }
    free(volume.voxels);
    air_context_destroy(context);
}

/* From no fog at all to what ends in a voxel. */
static void void_and_walls_are_what_they_are(void **state)
{
    (void)state;
    for (int n = 0; n < 4; n++) {
        air_context *context = make_context(cpus[n]);
        for (int wall = 0; context != NULL && wall < 2; wall++) {
            air_volume volume = wavy_volume(false, 0.0f);
            marching self;
            for (size_t i = 0; wall == 1 && i < count_of(volume.size); i++) {
                volume.voxels[i * 4 + 3] = 1e30f;
                volume.voxels[i * 4] = 5.0f;
            }
            random_rays(&self, 2);
            march(context, &volume, &self, 16);
            for (int i = 0; i < RAYS; i++) {
                assert_near((double)self.light[0][i], wall == 1 ? 5.0 : 0.0, 1e-5);
                assert_near((double)self.through[0][i], wall == 1 ? 0.0 : 1.0, 1e-5);
            }
            free(volume.voxels);
        }
        air_context_destroy(context);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_stay_lines),
        cmocka_unit_test(constants_stay_constant),
        cmocka_unit_test(voxels_take_the_light_of_their_like),
        cmocka_unit_test(even_volumes_have_their_closed_form),
        cmocka_unit_test(rays_that_end_before_they_begin_see_nothing),
        cmocka_unit_test(a_colour_that_is_grey_is_as_grey),
        cmocka_unit_test(instruction_sets_agree),
        cmocka_unit_test(more_steps_are_nearer),
        cmocka_unit_test(void_and_walls_are_what_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
