/* Unscattered light in cells, against sums over rays through them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_beam.h"
#include "cmocka_test.h"
#include "core/vec.h"
#include "random_geometry.h"

enum { CHANNELS = 4 };

/* A box with room for its coefficients. */
typedef struct fog {
    air_beam_box box;
    float *extinction;
    size_t cells;
} fog;

static fog fog_make(size_t x, size_t y, size_t z, float dx, float dy, float dz)
{
    fog self = {.box = {{x, y, z}, {dx, dy, dz}, NULL}, .cells = x * y * z};
    self.extinction = calloc(self.cells * CHANNELS, sizeof(float));
    assert_non_null(self.extinction);
    self.box.extinction = self.extinction;
    return self;
}

static void fog_finish(fog *self) { free(self->extinction); }

typedef enum filling {
    EVEN,   /* everywhere alike */
    SMOOTH, /* waves, to a half more or less */
    BLOB,   /* a ball that fades outwards in air */
    RANDOM  /* every cell its own: from 0 to twice the mean */
} filling;

/* sigma: the mean; channels differ by a factor. */
static void fill(fog *self, filling kind, float sigma, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, 5);
    const size_t *const n = self->box.size;
    for (size_t cell = 0; cell < self->cells; cell++) {
        const size_t at[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
        double x[3], square = 0.0, value = 1.0;
        for (int k = 0; k < 3; k++) {
            x[k] = ((double)at[k] + 0.5) / (double)n[k];
            square += (x[k] - 0.5) * (x[k] - 0.5);
        }
        const double waves = sin(5.0 * x[0] + 1.0) * cos(4.0 * x[1]) * sin(6.0 * x[2] + 2.0);
        value = kind == SMOOTH   ? 1.0 + 0.5 * waves
                : kind == BLOB   ? fmax(0.0, 4.0 - 8.0 * sqrt(square))
                : kind == RANDOM ? random_between(&rng, 0.0, 2.0)
                                 : 1.0;
        for (size_t c = 0; c < CHANNELS; c++) {
            const float factor = 1.0f - 0.25f * (float)c;
            self->extinction[cell * CHANNELS + c] = sigma * factor * (float)value;
        }
    }
}

static float *numbers(size_t count)
{
    float *const out = calloc(count, sizeof *out);
    assert_non_null(out);
    return out;
}

static float *directional(const fog *self, const double dir[3])
{
    void *const scratch = malloc(air_beam_scratch(self->box.size));
    float *const out = numbers(self->cells * CHANNELS);
    const float unit[3] = {(float)dir[0], (float)dir[1], (float)dir[2]};
    assert_non_null(scratch);
    air_beam_directional(NULL, &self->box, unit, scratch, out);
    free(scratch);
    return out;
}

/* Mean transmittance of a cell over looks^3 points in it, along rays from outside. */
static void brute_cell(const fog *self, const double dir[3], size_t cell, int looks,
                       double out[CHANNELS])
{
    const size_t *const n = self->box.size;
    const size_t at[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
    double far = 0.0;
    for (int k = 0; k < 3; k++) {
        far += (double)n[k] * (double)self->box.cell_m[k];
    }
    memset(out, 0, CHANNELS * sizeof *out);
    for (int i = 0; i < looks * looks * looks; i++) {
        const int sub[3] = {i % looks, i / looks % looks, i / looks / looks};
        float to[3], from[3], depth[CHANNELS];
        for (int k = 0; k < 3; k++) {
            const double share = ((double)sub[k] + 0.5) / looks;
            const double place = ((double)at[k] + share) * (double)self->box.cell_m[k];
            to[k] = (float)place;
            from[k] = (float)(place - far * dir[k]);
        }
        air_beam_depth(&self->box, from, to, depth);
        for (int c = 0; c < CHANNELS; c++) {
            out[c] += exp(-(double)depth[c]) / (looks * looks * looks);
        }
    }
}

/* How far a sweep is from rays: over all cells of the first channel. */
typedef struct error {
    double rms, bias; /* over the mean */
    double most;      /* of one cell, absolute */
} error;

static error measure(const fog *self, const double dir[3])
{
    float *const found = directional(self, dir);
    const size_t stride = self->cells > 2000 ? 7 : 1;
    size_t count = 0;
    double square = 0.0, sum = 0.0, mean = 0.0;
    error out = {0.0, 0.0, 0.0};
    for (size_t cell = 0; cell < self->cells; cell += stride, count++) {
        double expected[CHANNELS];
        brute_cell(self, dir, cell, 4, expected);
        const double off = (double)found[cell * CHANNELS] - expected[0];
        square += off * off;
        sum += off;
        mean += expected[0];
        out.most = fmax(out.most, fabs(off));
    }
    out.rms = sqrt(square / (double)count) / (mean / (double)count);
    out.bias = sum / mean;
    free(found);
    return out;
}

/* Along axes, near them, at random, along diagonals, and grazing: unit. */
enum { DIRECTIONS = 14 };
static const double directions[DIRECTIONS][3] = {
    {1, 0, 0},       {0, -1, 0},     {0, 0, 1},       {0.1, 1, 0.05},  {0.3, -0.2, -1},
    {-1, 0.4, 0.7},  {1, 1, 0},      {1, -1, 1},      {-0.5, 0.9, 1},  {0.02, 0.01, -1},
    {1, 0.999, 0.5}, {-1, 1, 0.001}, {0.49, 1, 0.49}, {0.51, 0.51, -1}};

static void direction(int n, double out[3])
{
    memcpy(out, directions[n], 3 * sizeof *out);
    normalise(out);
}

/* ---- from infinity ---- */

/* The sum of what is measured over all directions: the worst. */
static error worst(const fog *self)
{
    error out = {0.0, 0.0, 0.0};
    for (int n = 0; n < DIRECTIONS; n++) {
        double dir[3];
        direction(n, dir);
        const error e = measure(self, dir);
        out.rms = fmax(out.rms, e.rms);
        out.bias = fmax(out.bias, fabs(e.bias));
        out.most = fmax(out.most, e.most);
    }
    return out;
}

static void check_worst(const fog *self, const char *name, double rms, double bias, double most)
{
    const error e = worst(self);
    print_message("%s: rms %.4f, bias %.4f, worst cell %.4f\n", name, e.rms, e.bias, e.most);
    assert_true(e.rms <= rms);
    assert_true(e.bias <= bias);
    assert_true(e.most <= most);
}

/* Optical depth 8 from face to face in 20 cells: measured, and a tenth more. Depths between centres
 * are bilinear, so borders of shadows spread as they go on: most where a ball is alone in air, for
 * grazing light, and where every cell is its own. */
static void sweeps_are_near_rays(void **state)
{
    (void)state;
    static const char *const names[] = {"even", "smooth", "ball", "random"};
    static const double bounds[4][3] = {
        {0.097, 0.020, 0.14}, {0.096, 0.020, 0.18}, {0.09, 0.031, 0.38}, {0.185, 0.041, 0.26}};
    for (int kind = EVEN; kind <= RANDOM; kind++) {
        fog self = fog_make(20, 20, 20, 0.05f, 0.05f, 0.05f);
        fill(&self, (filling)kind, 8.0f, 1);
        check_worst(&self, names[kind], bounds[kind][0], bounds[kind][1], bounds[kind][2]);
        fog_finish(&self);
    }
}

/* Slabs and rods, too, whose cells are no cubes, and one cell. Where there is one cell across, it
 * has no neighbours to tell how the light that enters by its sides falls off in it: it is too dark.
 */
static void boxes_of_any_shape_are_near_rays(void **state)
{
    (void)state;
    static const size_t sizes[5][3] = {
        {12, 20, 9}, {1, 20, 20}, {20, 1, 20}, {15, 1, 1}, {1, 1, 1}};
    static const double bounds[5][3] = {{0.126, 0.030, 0.13},
                                        {0.272, 0.200, 0.11},
                                        {0.134, 0.126, 0.11},
                                        {0.116, 0.110, 0.11},
                                        {0.042, 0.042, 0.04}};
    for (int n = 0; n < 5; n++) {
        char name[64];
        const size_t *const size = sizes[n];
        fog self = fog_make(size[0], size[1], size[2], 0.08f, 0.05f, 0.06f);
        fill(&self, SMOOTH, 8.0f, 1);
        (void)snprintf(name, sizeof name, "%zu x %zu x %zu", size[0], size[1], size[2]);
        check_worst(&self, name, bounds[n][0], bounds[n][1], bounds[n][2]);
        fog_finish(&self);
    }
}

/* Layers across an axis: in a cell from depth a to b the mean is (e^-a - e^-b) / (b - a). Sums of
 * 12 floats, the difference of exponentials over a change of at least 0.05: 2^-24 x 40. */
static void along_an_axis_layers_are_exact(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(9, 9);
    for (int n = 0; n < 6; n++) {
        fog self = fog_make(12, 11, 10, 0.1f, 0.2f, 0.3f);
        const int axis = n / 2;
        const bool back = n % 2 == 1;
        const size_t count = self.box.size[axis], strides[3] = {1, 12, 132};
        double layer[12], dir[3] = {0.0, 0.0, 0.0}, depth = 0.0;
        dir[axis] = back ? -1.0 : 1.0;
        for (size_t i = 0; i < count; i++) {
            layer[i] = random_between(&rng, 0.0, 1.0) > 0.3 ? random_between(&rng, 0.0, 9.0) : 0.0;
        }
        for (size_t cell = 0; cell < self.cells; cell++) {
            for (size_t c = 0; c < CHANNELS; c++) {
                const double value = layer[cell / strides[axis] % count];
                self.extinction[cell * CHANNELS + c] = (float)(value * (1.0 + (double)c));
            }
        }
        float *const found = directional(&self, dir);
        for (size_t i = 0; i < count; i++) {
            const size_t w = back ? count - 1 - i : i;
            const double change = layer[w] * 2.0 * (double)self.box.cell_m[axis];
            const double mean = change > 0.0 ? -expm1(-change) / change : 1.0;
            for (size_t cell = 0; cell < self.cells; cell++) {
                if (cell / strides[axis] % count == w) {
                    const double off = (double)found[cell * CHANNELS + 1] - exp(-depth) * mean;
                    assert_true(fabs(off) < 3e-6);
                }
            }
            depth += change;
        }
        free(found);
        fog_finish(&self);
    }
}

/* ---- mirrors ---- */

/* The box with axes exchanged: axis k of the new is axis from[k] of the old. */
static fog turned(const fog *old, const int from[3])
{
    const size_t *const n = old->box.size;
    const float *const edge = old->box.cell_m;
    return fog_make(n[from[0]], n[from[1]], n[from[2]], edge[from[0]], edge[from[1]],
                    edge[from[2]]);
}

/* Where a cell of the new box was. */
static size_t origin_of(const fog *old, const fog *self, size_t cell, const int from[3],
                        const bool mirror[3])
{
    const size_t *const n = self->box.size;
    const size_t at[3] = {cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]};
    size_t was[3];
    for (int k = 0; k < 3; k++) {
        was[from[k]] = mirror[k] ? n[k] - 1 - at[k] : at[k];
    }
    return (was[2] * old->box.size[1] + was[1]) * old->box.size[0] + was[0];
}

/* Directions have one longest part, so that the main axis turns along. Weights of interpolation
 * are summed up in another order: some 2^-24 of depths up to 20 in each of 24 layers. */
static void turned_boxes_have_turned_light(void **state)
{
    (void)state;
    static const int turns[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    air_rng rng = air_rng_from_keys(4, 4);
    fog old = fog_make(9, 7, 8, 0.1f, 0.13f, 0.07f);
    fill(&old, RANDOM, 8.0f, 3);
    for (int n = 0; n < 48; n++) {
        const int *const from = turns[n % 6];
        const bool mirror[3] = {(n / 6 & 1) != 0, (n / 6 & 2) != 0, (n / 6 & 4) != 0};
        fog self = turned(&old, from);
        double dir[3], now[3];
        random_direction(&rng, dir);
        for (int k = 0; k < 3; k++) {
            now[k] = mirror[k] ? -dir[from[k]] : dir[from[k]];
        }
        for (size_t cell = 0; cell < self.cells; cell++) {
            memcpy(self.extinction + cell * CHANNELS,
                   old.extinction + origin_of(&old, &self, cell, from, mirror) * CHANNELS,
                   CHANNELS * sizeof(float));
        }
        float *const a = directional(&old, dir), *const b = directional(&self, now);
        for (size_t cell = 0; cell < self.cells; cell++) {
            const size_t was = origin_of(&old, &self, cell, from, mirror);
            for (size_t c = 0; c < CHANNELS; c++) {
                const float off = a[was * CHANNELS + c] - b[cell * CHANNELS + c];
                assert_true(fabsf(off) < 2e-5f);
            }
        }
        free(a);
        free(b);
        fog_finish(&self);
    }
    fog_finish(&old);
}

/* ---- limits ---- */

static void without_fog_all_light_is_everywhere(void **state)
{
    (void)state;
    fog self = fog_make(7, 5, 6, 0.1f, 0.3f, 0.2f);
    for (int n = 0; n < DIRECTIONS; n++) {
        double dir[3];
        direction(n, dir);
        float *const found = directional(&self, dir);
        for (size_t i = 0; i < self.cells * CHANNELS; i++) {
            assert_true(found[i] == 1.0f);
        }
        free(found);
    }
    fog_finish(&self);
}

/* From air to what lets nothing through, cell by cell. */
static void transmittances_are_shares(void **state)
{
    (void)state;
    air_rng rng = air_rng_from_keys(6, 2);
    fog self = fog_make(11, 12, 13, 0.1f, 0.05f, 0.2f);
    for (int round = 0; round < 40; round++) {
        double dir[3];
        for (size_t i = 0; i < self.cells * CHANNELS; i++) {
            const bool fogged = random_unit(&rng) > 0.4;
            const double power = random_between(&rng, -3.0, round % 4 == 0 ? 9.0 : 3.0);
            self.extinction[i] = fogged ? (float)pow(10.0, power) : 0.0f;
        }
        if (round < DIRECTIONS) {
            direction(round, dir);
        } else {
            random_direction(&rng, dir);
        }
        float *const found = directional(&self, dir);
        for (size_t i = 0; i < self.cells * CHANNELS; i++) {
            assert_true(found[i] >= 0.0f && found[i] <= 1.0f);
        }
        free(found);
    }
    fog_finish(&self);
}

/* Power that a homogeneous unit cube takes from a beam: over each lit face the integral of
 * (1 - exp(-sigma chord)) cos, by midpoints. */
static double taken(double sigma, const double dir[3])
{
    enum { POINTS = 64 };
    double sum = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int n = 0; n < POINTS * POINTS; n++) {
            const double at[2] = {(n % POINTS + 0.5) / POINTS, (n / POINTS + 0.5) / POINTS};
            double chord = dir[axis] != 0.0 ? 1.0 / fabs(dir[axis]) : 0.0;
            const int across[2] = {u, v};
            for (int k = 0; k < 2; k++) {
                const double d = dir[across[k]];
                const double left = d > 0.0 ? 1.0 - at[k] : at[k];
                chord = d != 0.0 ? fmin(chord, left / fabs(d)) : chord;
            }
            sum -= expm1(-sigma * chord) * fabs(dir[axis]) / (POINTS * POINTS);
        }
    }
    return sum;
}

/* A white sky of radiance 1, as directions on a spiral: what the cells take, sum of sigma fluence
 * volume, is what enters by the faces, pi for each, less what leaves: measured, and a tenth more.
 * At 4 per cell the outermost have nearly all of it, in layers thinner than they are, and get too
 * little: why skies enter such boxes by the solver's faces (src/render/ordinates/inflow.c). */
static void a_white_sky_gives_cubes_what_enters_by_their_faces(void **state)
{
    (void)state;
    enum { COUNT = 96 };
    static const double sigmas[3] = {4.0, 8.0, 80.0}, bounds[3] = {0.012, 0.005, 0.138};
    for (int n = 0; n < 3; n++) {
        double entered = 0.0, expected = 0.0, found = 0.0;
        fog self = fog_make(20, 20, 20, 0.05f, 0.05f, 0.05f);
        fill(&self, EVEN, (float)sigmas[n], 0);
        for (int i = 0; i < COUNT; i++) {
            const double z = 1.0 - (2.0 * i + 1.0) / COUNT, phi = 2.39996323 * i;
            const double r = sqrt(1.0 - z * z), dir[3] = {r * cos(phi), r * sin(phi), z};
            const double share = 4.0 * AIR_PI / COUNT;
            float *const light = directional(&self, dir);
            entered += share * (fabs(dir[0]) + fabs(dir[1]) + fabs(dir[2]));
            expected += share * taken(sigmas[n], dir);
            for (size_t cell = 0; cell < self.cells; cell++) {
                found += share * sigmas[n] * (double)light[cell * CHANNELS] / (double)self.cells;
            }
            free(light);
        }
        print_message("sigma %g: enters %.4f of 6 pi, stays %.4f, found %.4f of that\n", sigmas[n],
                      entered / (6.0 * AIR_PI), expected / entered, found / expected);
        assert_true(fabs(entered / (6.0 * AIR_PI) - 1.0) < 0.002); /* the spiral's */
        assert_true(fabs(found / expected - 1.0) < bounds[n]);
        fog_finish(&self);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sweeps_are_near_rays),
        cmocka_unit_test(boxes_of_any_shape_are_near_rays),
        cmocka_unit_test(along_an_axis_layers_are_exact),
        cmocka_unit_test(turned_boxes_have_turned_light),
        cmocka_unit_test(without_fog_all_light_is_everywhere),
        cmocka_unit_test(transmittances_are_shares),
        cmocka_unit_test(a_white_sky_gives_cubes_what_enters_by_their_faces)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
