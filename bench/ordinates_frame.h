/* ordinates_frame.h: a picture of smoke under a sky, stage by stage as [Elek2014] has them, with
 * the kernels alone: no scene, no surfaces. */
#ifndef AIR_BENCH_ORDINATES_FRAME_H
#define AIR_BENCH_ORDINATES_FRAME_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "airlight/ordinates_beam.h"
#include "airlight/ordinates_dom.h"
#include "airlight/ordinates_lights.h"
#include "airlight/ordinates_view.h"
#include "core/host.h"
#include "core/random.h"

enum {
    FRAME_VOXELS = 64,
    FRAME_SKY_WIDTH = 512,
    FRAME_SKY_HEIGHT = 256,
    FRAME_THREADS = 2,
    FRAME_BLOCK = 16, /* beams whose fluences are in memory at a time */
    FRAME_TILE = 32,  /* pixels */
    FRAME_MARCH = 64,
    FRAME_RAYS = FRAME_TILE * FRAME_TILE
};

enum {
    STAGE_IMPORTANCE,
    STAGE_ORDINATES,
    STAGE_CELLS,
    STAGE_BEAMS,
    STAGE_MOMENTS,
    STAGE_SOLVE,
    STAGE_SEEN,
    STAGE_FILL,
    STAGE_MARCH,
    STAGES
};

static const float frame_side = 2.0f, frame_albedo = 0.95f, frame_g = 0.5f;
static const float frame_distance = 4.4f; /* of the camera: the box is half of the picture */

typedef struct frame_ray_tile {
    float numbers[9][FRAME_RAYS], out[6][FRAME_RAYS];
} frame_ray_tile;

typedef struct frame {
    air_context *context;
    size_t side, cells, count, width, height; /* cells along an axis and all, ordinates, picture */
    size_t first[2], last[2];                 /* pixels between which the box lies */
    uint32_t sweeps;
    int bands;
    bool cold;
    float *density[2], *half; /* two moments of the smoke, 1/m; a mip level of it */
    unsigned turn;            /* which of the two */
    float *sky;
    air_environment_ordinates *chooser;
    void *importance_scratch, *beam_scratch[FRAME_THREADS];
    float importance[AIR_IMPORTANCE_TEXELS];
    air_ordinate ordinates[AIR_ORDINATES_LIGHTS_MAX];
    float *sigma_s, *sigma_a, *g, *extinction; /* three planes each; of beams, 4 a cell */
    float *fluence;                            /* of a block */
    air_seen_beam beams[FRAME_BLOCK];
    size_t begin, block; /* first and number of a block's */
    float *moments, *light, *solved;
    air_dom *dom;
    air_dom_report report;
    air_seen_box box;
    double factors[AIR_DOM_BANDS_MAX], peak;
    air_volume volume;
    uint8_t *empty;
    frame_ray_tile *tiles[FRAME_THREADS];
    float *picture, *through;      /* three planes each */
    double seconds[STAGES], whole; /* of the last frame */
    size_t hits;
} frame;

/* Where others use the machine, the processor's time of one thread says more than wall time. */
static clockid_t frame_clock = CLOCK_MONOTONIC;

static inline double frame_now(void)
{
    struct timespec time;
    (void)clock_gettime(frame_clock, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* ---- what is given ---- */

/* Puffs, rough at their sides. */
static inline void frame_fill_density(float *out, float shift)
{
    enum { PUFFS = 24, N = FRAME_VOXELS };
    air_rng rng = air_rng_from_keys(3, 1);
    float puff[PUFFS][4];
    for (int i = 0; i < PUFFS; i++) {
        for (int axis = 0; axis < 4; axis++) {
            puff[i][axis] = air_rng_float(&rng);
        }
    }
    for (size_t v = 0; v < N * N * N; v++) {
        const float p[3] = {((float)(v % N) + 0.5f) / N, ((float)(v / N % N) + 0.5f) / N,
                            ((float)(v / N / N) + 0.5f) / N};
        float sum = 0.0f;
        for (int i = 0; i < PUFFS; i++) {
            float square = 0.0f;
            for (int axis = 0; axis < 3; axis++) {
                const float middle = 0.2f + 0.6f * puff[i][axis] + (axis == 1 ? shift : 0.0f);
                square += (p[axis] - middle) * (p[axis] - middle);
            }
            const float radius = 0.08f + 0.12f * puff[i][3];
            sum += fmaxf(0.0f, 1.0f - square / (radius * radius));
        }
        const float noise = sinf(31.0f * p[0] + 9.0f * sinf(17.0f * p[1])) *
                            sinf(29.0f * p[1] + 7.0f * sinf(23.0f * p[2])) *
                            sinf(37.0f * p[2] + 5.0f * sinf(19.0f * p[0]));
        out[v] = 6.0f * fmaxf(0.0f, sum * (1.0f + 0.8f * noise));
    }
}

/* Blue above, brown below, a sun of 1 degree that sends half of the light. */
static inline void frame_fill_sky(float *out)
{
    const float sun[3] = {0.48f, 0.64f, 0.6f};
    for (size_t p = 0; p < FRAME_SKY_WIDTH * FRAME_SKY_HEIGHT; p++) {
        const float theta = 3.14159265f * ((float)(p / FRAME_SKY_WIDTH) + 0.5f) / FRAME_SKY_HEIGHT;
        const float phi =
            6.2831853f * (((float)(p % FRAME_SKY_WIDTH) + 0.5f) / FRAME_SKY_WIDTH - 0.5f);
        const float w[3] = {sinf(theta) * sinf(phi), cosf(theta), -sinf(theta) * cosf(phi)};
        const float cosine = w[0] * sun[0] + w[1] * sun[1] + w[2] * sun[2];
        const float up = fmaxf(w[1], 0.0f), glow = powf(fmaxf(cosine, 0.0f), 32.0f);
        const float disc = cosine > 0.99985f ? 4000.0f : 0.0f;
        const float low[3] = {0.25f, 0.2f, 0.15f}, high[3] = {0.3f, 0.55f, 1.0f};
        for (int c = 0; c < 3; c++) {
            const float base = w[1] > 0.0f ? 0.6f + (high[c] - 0.6f) * up : low[c];
            out[3 * p + (size_t)c] = base + glow * (1.5f - 0.3f * (float)c) + disc;
        }
    }
}

static inline float *frame_floats(size_t count)
{
    float *const out = aligned_alloc(64, (count * sizeof(float) + 63) / 64 * 64);
    if (out == NULL) {
        abort();
    }
    return memset(out, 0, count * sizeof *out);
}

static inline void frame_make_volume(frame *self)
{
    for (int axis = 0; axis < 3; axis++) {
        self->volume.size[axis] = FRAME_VOXELS;
        self->volume.voxel_m[axis] = frame_side / FRAME_VOXELS;
        self->box.size[axis] = self->side;
        self->box.cell_m[axis] = frame_side / (float)self->side;
        self->box.observer[axis] = 0.5f * frame_side;
    }
    self->box.observer[2] += frame_distance;
    self->volume.voxels = frame_floats((size_t)4 * FRAME_VOXELS * FRAME_VOXELS * FRAME_VOXELS);
    self->empty = (uint8_t *)frame_floats((size_t)FRAME_VOXELS * FRAME_VOXELS * FRAME_VOXELS / 4);
    self->volume.empty = self->empty;
}

static inline void frame_make_solver(frame *self)
{
    air_dom_params params;
    air_dom_params_default(&params);
    for (int axis = 0; axis < 3; axis++) {
        params.size[axis] = self->side;
        params.cell_m[axis] = self->box.cell_m[axis];
    }
    params.bands = self->bands;
    self->peak = air_dom_peak(&params, pow((double)frame_g, self->bands));
    for (int l = 0; l < self->bands; l++) {
        self->factors[l] = pow((double)frame_g, l) - self->peak;
    }
    if (air_dom_create(self->context, &params, &self->dom) != AIR_OK) {
        abort();
    }
}

static inline void frame_make(air_context *context, size_t side, size_t count, size_t width,
                              size_t height, frame *self)
{
    const size_t voxels = (size_t)FRAME_VOXELS * FRAME_VOXELS * FRAME_VOXELS;
    *self = (frame){.context = context, .side = side, .cells = side * side * side, .count = count};
    self->width = width;
    self->height = height;
    self->bands = 4;
    self->sweeps = 8;
    const size_t moments = self->cells * (size_t)(4 * self->bands * self->bands);
    for (int i = 0; i < 2; i++) {
        self->density[i] = frame_floats(voxels);
        frame_fill_density(self->density[i], 0.01f * (float)i);
    }
    self->half = frame_floats(voxels / 8);
    self->sky = frame_floats((size_t)3 * FRAME_SKY_WIDTH * FRAME_SKY_HEIGHT);
    frame_fill_sky(self->sky);
    air_environment_map map;
    air_environment_map_default(&map);
    map.pixels = self->sky;
    map.width = FRAME_SKY_WIDTH;
    map.height = FRAME_SKY_HEIGHT;
    map.pixel_stride = 3;
    map.row_stride = (size_t)3 * FRAME_SKY_WIDTH;
    if (air_environment_ordinates_create(context, &map, &self->chooser) != AIR_OK) {
        abort();
    }
    self->importance_scratch = frame_floats(air_importance_scratch() / sizeof(float) + 1);
    self->sigma_s = frame_floats(3 * self->cells);
    self->sigma_a = frame_floats(3 * self->cells);
    self->g = frame_floats(3 * self->cells);
    self->extinction = frame_floats(4 * self->cells);
    self->fluence = frame_floats(FRAME_BLOCK * 4 * self->cells);
    self->moments = frame_floats(moments);
    self->solved = frame_floats(moments);
    self->light = frame_floats(4 * self->cells);
    self->picture = frame_floats(3 * width * height);
    self->through = frame_floats(3 * width * height);
    frame_make_volume(self);
    frame_make_solver(self);
    const size_t size[3] = {side, side, side};
    for (int i = 0; i < FRAME_THREADS; i++) {
        self->beam_scratch[i] = frame_floats(air_beam_scratch(size) / sizeof(float) + 1);
        self->tiles[i] = (frame_ray_tile *)(void *)frame_floats(sizeof(frame_ray_tile) / 4);
    }
}

static inline void frame_finish(frame *self)
{
    void *const all[] = {self->density[0],
                         self->density[1],
                         self->half,
                         self->sky,
                         self->sigma_s,
                         self->sigma_a,
                         self->g,
                         self->extinction,
                         self->fluence,
                         self->moments,
                         self->solved,
                         self->light,
                         self->picture,
                         self->through,
                         self->importance_scratch,
                         self->beam_scratch[0],
                         self->beam_scratch[1],
                         self->tiles[0],
                         self->tiles[1],
                         self->volume.voxels};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        free(all[i]);
    }
    air_environment_ordinates_destroy(self->chooser);
    air_dom_destroy(self->dom);
}

/* ---- stages ---- */

/* The mip level, trilinear, at a point in metres of the box; 0 outside. */
static inline float frame_density_at(const frame *self, const float point[3])
{
    enum { N = FRAME_VOXELS / 2 };
    size_t low[3];
    float share[3], sum = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        if (!(point[axis] >= 0.0f && point[axis] <= frame_side)) {
            return 0.0f;
        }
        const float at = fminf(fmaxf(point[axis] * (N / frame_side) - 0.5f, 0.0f), N - 1.001f);
        low[axis] = (size_t)at;
        share[axis] = at - (float)(ptrdiff_t)low[axis];
    }
    for (size_t c = 0; c < 8; c++) {
        const float weight = ((c & 1) != 0 ? share[0] : 1.0f - share[0]) *
                             ((c & 2) != 0 ? share[1] : 1.0f - share[1]) *
                             ((c & 4) != 0 ? share[2] : 1.0f - share[2]);
        sum +=
            weight * self->half[((low[2] + c / 4) * N + low[1] + c / 2 % 2) * N + low[0] + c % 2];
    }
    return sum;
}

static inline void frame_importance(frame *self)
{
    enum { ALL = AIR_IMPORTANCE_CELLS_ALL };
    static float points[3 * ALL], numbers[3][ALL];
    float next[AIR_IMPORTANCE_TEXELS];
    const air_importance_camera camera = {.position = {0.0f, 0.0f, frame_distance},
                                          .right = {1.0f, 0.0f, 0.0f},
                                          .up = {0.0f, 1.0f, 0.0f},
                                          .forward = {0.0f, 0.0f, -1.0f},
                                          .tan_half = {0.48f, 0.36f},
                                          .near_m = 3.4f,
                                          .far_m = 5.4f};
    const air_importance_medium medium = {numbers[0], numbers[1], numbers[2]};
    (void)air_importance_points(self->context, &camera, points);
    for (size_t i = 0; i < ALL; i++) {
        const float middle = 0.5f * frame_side;
        const float at[3] = {points[3 * i] + middle, points[3 * i + 1] + middle,
                             points[3 * i + 2] + middle};
        const float density = frame_density_at(self, at);
        numbers[0][i] = frame_albedo * density;
        numbers[1][i] = (1.0f - frame_albedo) * density;
        numbers[2][i] = frame_g;
    }
    if (air_importance_propagate(self->context, &camera, &medium, self->importance_scratch, next,
                                 NULL) != AIR_OK) {
        abort();
    }
    air_importance_smooth(next, 0.1f, next);
    air_importance_blend(self->importance, next, self->turn == 0 ? 0.0f : 0.8f, self->importance);
}

static inline void frame_choose(frame *self)
{
    air_environment_choice choice;
    air_environment_choice_default(&choice);
    choice.count = self->count;
    choice.importance = self->importance;
    if (air_environment_ordinates_choose(self->context, self->chooser, &choice, self->ordinates) !=
        AIR_OK) {
        abort();
    }
}

static inline void frame_mip_slab(void *user, size_t k, size_t worker)
{
    enum { N = FRAME_VOXELS, H = FRAME_VOXELS / 2 };
    frame *const self = user;
    const float *const from = self->density[self->turn % 2] + 2 * k * N * N;
    (void)worker;
    for (size_t j = 0; j < H; j++) {
        const float *const a = from + 2 * j * N, *const b = a + N;
        const float *const c = a + N * N, *const d = c + N;
        float *const out = self->half + (k * H + j) * H;
        for (size_t i = 0; i < H; i++) {
            out[i] = 0.125f * (((a[2 * i] + a[2 * i + 1]) + (b[2 * i] + b[2 * i + 1])) +
                               ((c[2 * i] + c[2 * i + 1]) + (d[2 * i] + d[2 * i + 1])));
        }
    }
}

static inline void frame_cells_slab(void *user, size_t k, size_t worker)
{
    frame *const self = user;
    const float edge = self->box.cell_m[0];
    const float scaled = frame_albedo * (float)(1.0 - self->peak) + (1.0f - frame_albedo);
    (void)worker;
    for (size_t cell = k * self->side * self->side; cell < (k + 1) * self->side * self->side;
         cell++) {
        const float at[3] = {((float)(cell % self->side) + 0.5f) * edge,
                             ((float)(cell / self->side % self->side) + 0.5f) * edge,
                             ((float)(cell / self->side / self->side) + 0.5f) * edge};
        const float density = frame_density_at(self, at);
        for (size_t c = 0; c < 3; c++) {
            self->sigma_s[c * self->cells + cell] = frame_albedo * density;
            self->sigma_a[c * self->cells + cell] = (1.0f - frame_albedo) * density;
            self->g[c * self->cells + cell] = frame_g;
        }
        for (size_t c = 0; c < 4; c++) {
            self->extinction[cell * 4 + c] = scaled * density;
        }
    }
}

static inline void frame_cells(frame *self)
{
    const air_dom_phase phase = {.g = self->g};
    air_parallel_for(self->context, self->side, frame_cells_slab, self);
    if (air_dom_set_medium(self->dom, self->sigma_s, self->sigma_a, &phase) != AIR_OK) {
        abort();
    }
    memset(self->moments, 0,
           self->cells * (size_t)(4 * self->bands * self->bands) * sizeof *self->moments);
    memset(self->light, 0, 4 * self->cells * sizeof *self->light);
}

static inline void frame_beam(void *user, size_t index, size_t worker)
{
    frame *const self = user;
    const air_ordinate *const from = &self->ordinates[self->begin + index];
    const air_beam_box box = {{self->side, self->side, self->side},
                              {self->box.cell_m[0], self->box.cell_m[1], self->box.cell_m[2]},
                              self->extinction};
    air_seen_beam *const beam = &self->beams[index];
    float *const out = self->fluence + index * 4 * self->cells;
    *beam = (air_seen_beam){.lobe = (float)from->lobe, .fluence = out};
    for (int axis = 0; axis < 3; axis++) {
        beam->dir[axis] = (float)from->travel[axis];
        beam->power[axis] = (float)from->irradiance[axis];
    }
    air_beam_directional(self->context, &box, beam->dir, self->beam_scratch[worker], out);
}

static inline void frame_beam_moments(void *user, size_t k, size_t worker)
{
    frame *const self = user;
    (void)worker;
    air_beam_moments(self->context, &self->box, self->beams, self->block, self->bands, k, k + 1,
                     self->moments);
}

static inline void frame_beam_seen(void *user, size_t k, size_t worker)
{
    frame *const self = user;
    const air_phase phase = {.kind = AIR_PHASE_HG, .g = frame_g};
    const air_seen_peak peak = {self->peak, self->peak / (1.0 - self->peak), NULL};
    (void)worker;
    air_seen_beams(self->context, &self->box, self->beams, self->block, phase, &peak, k, k + 1,
                   self->light);
}

/* Block by block; three stages. */
static inline void frame_beams(frame *self)
{
    for (self->begin = 0; self->begin < self->count; self->begin += self->block) {
        const size_t rest = self->count - self->begin;
        self->block = rest < FRAME_BLOCK ? rest : FRAME_BLOCK;
        const double start = frame_now();
        air_parallel_for(self->context, self->block, frame_beam, self);
        const double swept = frame_now();
        air_parallel_for(self->context, self->side, frame_beam_moments, self);
        const double summed = frame_now();
        air_parallel_for(self->context, self->side, frame_beam_seen, self);
        self->seconds[STAGE_BEAMS] += swept - start;
        self->seconds[STAGE_MOMENTS] += summed - swept;
        self->seconds[STAGE_SEEN] += frame_now() - summed;
    }
    const double start = frame_now();
    if (air_dom_set_light(self->dom, self->moments) != AIR_OK) {
        abort();
    }
    self->seconds[STAGE_MOMENTS] += frame_now() - start;
}

static inline void frame_solve(frame *self)
{
    air_dom_solve_params params;
    air_dom_solve_params_default(&params);
    params.sweeps = self->sweeps;
    params.change = 0.0;
    params.depth = 0;
    params.cold = self->cold;
    if (air_dom_solve(self->dom, &params, &self->report) != AIR_OK) {
        abort();
    }
}

static inline void frame_seen_slab(void *user, size_t k, size_t worker)
{
    frame *const self = user;
    const size_t slab = self->side * self->side;
    (void)worker;
    air_seen_moments(self->context, &self->box, self->bands, self->solved, self->factors, k, k + 1,
                     self->light);
    for (size_t cell = k * slab; cell < (k + 1) * slab; cell++) { /* J; sigma_s / sigma_t is even */
        float *const at = self->light + cell * 4;
        for (int c = 0; c < 3; c++) {
            at[c] = at[c] > 0.0f ? frame_albedo * at[c] : 0.0f;
        }
        at[3] = self->sigma_s[cell] + self->sigma_a[cell];
    }
}

static inline void frame_fill_slab(void *user, size_t k, size_t worker)
{
    frame *const self = user;
    const size_t size[3] = {self->side, self->side, self->side};
    (void)worker;
    air_volume_fill(self->context, &self->volume, self->density[self->turn % 2], size, self->light,
                    true, 40.0f, k, k + 1);
}

/* Where rays along dir enter and leave the box along one axis, as far as that is later and earlier
 * than before. */
static inline void frame_clip(float observer, const float *dir, float *t0, float *t1)
{
    for (int n = 0; n < 16; n++) {
        const float inverse = 1.0f / dir[n];
        const float a = -observer * inverse, b = (frame_side - observer) * inverse;
        const float low = a < b ? a : b, high = a < b ? b : a;
        t0[n] = t0[n] > low ? t0[n] : low;
        t1[n] = t1[n] < high ? t1[n] : high;
    }
}

/* Pixels between which the box lies: of its corners, [first, last). */
static inline void frame_bound(frame *self)
{
    const float unit = 0.72f / (float)self->height;
    const float size[2] = {(float)self->width, (float)self->height};
    float low[2] = {1e9f, 1e9f}, high[2] = {-1e9f, -1e9f};
    for (int corner = 0; corner < 8; corner++) {
        float to[3];
        for (int axis = 0; axis < 3; axis++) {
            to[axis] = (float)(corner >> axis & 1) * frame_side - self->box.observer[axis];
        }
        for (int axis = 0; axis < 2; axis++) {
            const float sign = axis == 0 ? 1.0f : -1.0f; /* rows go down */
            const float at = 0.5f * (size[axis] - 1.0f) - sign * to[axis] / (to[2] * unit);
            low[axis] = fminf(low[axis], floorf(at));
            high[axis] = fmaxf(high[axis], ceilf(at) + 1.0f);
        }
    }
    for (int axis = 0; axis < 2; axis++) {
        self->first[axis] = (size_t)fmaxf(low[axis], 0.0f);
        self->last[axis] = (size_t)fminf(fmaxf(high[axis], 0.0f), size[axis]);
    }
}

/* Rays of 4 x 4 pixels at entry `at` of a tile; false: none meets the box. */
static inline bool frame_aim_block(const frame *self, uint32_t column, uint32_t row,
                                   frame_ray_tile *tile, size_t at)
{
    const float unit = 0.72f / (float)self->height;
    const float left = 0.5f - 0.5f * (float)self->width, top = 0.5f * (float)self->height - 0.5f;
    float *const t0 = tile->numbers[6] + at, *const t1 = tile->numbers[7] + at;
    bool any = false;
    for (uint32_t n = 0; n < 16; n++) {
        const uint32_t x = column + n % 4, y = row + n / 4;
        tile->numbers[3][at + n] = ((float)x + left) * unit;
        tile->numbers[4][at + n] = (top - (float)y) * unit;
        tile->numbers[5][at + n] = -1.0f;
        tile->numbers[8][at + n] = 0.0625f * (float)((x * 5 + y * 7) % 16);
        t0[n] = 0.0f;
        t1[n] = 1e30f;
    }
    for (int axis = 0; axis < 3; axis++) {
        frame_clip(self->box.observer[axis], tile->numbers[3 + axis] + at, t0, t1);
        for (int n = 0; n < 16; n++) {
            tile->numbers[axis][at + (size_t)n] = self->box.observer[axis];
        }
    }
    for (int n = 0; n < 16; n++) {
        any = any || t1[n] > t0[n];
    }
    return any;
}

/* Blocks of a tile that meet the box. */
static inline size_t frame_aim(const frame *self, size_t column, size_t row, frame_ray_tile *tile,
                               uint32_t *first)
{
    enum { ACROSS = FRAME_TILE / 4 };
    size_t count = 0;
    for (uint32_t block = 0; block < ACROSS * ACROSS; block++) {
        const uint32_t x = (uint32_t)column + block % ACROSS * 4;
        const uint32_t y = (uint32_t)row + block / ACROSS * 4;
        const bool in = x < self->last[0] && x + 4 > self->first[0] && y < self->last[1] &&
                        y + 4 > self->first[1];
        if (in && frame_aim_block(self, x, y, tile, count * 16)) {
            first[count++] = y * (uint32_t)self->width + x;
        }
    }
    return count;
}

/* Of a block, whose first pixel is `first`; width and height are multiples of 4. */
static inline size_t frame_show_block(frame *self, const frame_ray_tile *tile, size_t at,
                                      size_t first)
{
    const size_t pixels = self->width * self->height;
    const float *const t0 = tile->numbers[6] + at, *const t1 = tile->numbers[7] + at;
    uint32_t hits = 0;
    for (size_t c = 0; c < 3; c++) {
        for (size_t row = 0; row < 4; row++) {
            const size_t to = c * pixels + first + row * self->width, from = at + 4 * row;
            memcpy(self->picture + to, tile->out[c] + from, 4 * sizeof(float));
            memcpy(self->through + to, tile->out[3 + c] + from, 4 * sizeof(float));
        }
    }
    for (size_t n = 0; n < 16; n++) {
        hits += t1[n] > t0[n] ? 1 : 0;
    }
    return hits;
}

static inline void frame_march_tile(void *user, size_t index, size_t worker)
{
    frame *const self = user;
    frame_ray_tile *const tile = self->tiles[worker];
    uint32_t first[FRAME_RAYS / 16];
    const size_t across = (self->width + FRAME_TILE - 1) / FRAME_TILE;
    const size_t count =
        frame_aim(self, index % across * FRAME_TILE, index / across * FRAME_TILE, tile, first);
    float(*const n)[FRAME_RAYS] = tile->numbers, (*const out)[FRAME_RAYS] = tile->out;
    const air_volume_rays rays = {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], n[7], n[8]};
    float *const radiance[3] = {out[0], out[1], out[2]}, *const left[3] = {out[3], out[4], out[5]};
    size_t hits = 0;
    air_volume_march(self->context, &self->volume, &rays, count * 16, FRAME_MARCH, radiance, left);
    for (size_t i = 0; i < count; i++) {
        hits += frame_show_block(self, tile, 16 * i, first[i]);
    }
    __atomic_fetch_add(&self->hits, hits, __ATOMIC_RELAXED);
}

static inline void frame_time(frame *self, int stage, double *since)
{
    const double now = frame_now();
    self->seconds[stage] += now - *since;
    *since = now;
}

static inline void frame_run(frame *self)
{
    const double start = frame_now();
    double since = start;
    memset(self->seconds, 0, sizeof self->seconds);
    air_parallel_for(self->context, FRAME_VOXELS / 2, frame_mip_slab, self);
    frame_time(self, STAGE_CELLS, &since);
    frame_importance(self);
    frame_time(self, STAGE_IMPORTANCE, &since);
    frame_choose(self);
    frame_time(self, STAGE_ORDINATES, &since);
    frame_cells(self);
    frame_time(self, STAGE_CELLS, &since);
    frame_beams(self);
    since = frame_now();
    frame_solve(self);
    frame_time(self, STAGE_SOLVE, &since);
    air_dom_moments(self->dom, self->solved);
    air_parallel_for(self->context, self->side, frame_seen_slab, self);
    frame_time(self, STAGE_SEEN, &since);
    air_parallel_for(self->context, FRAME_VOXELS, frame_fill_slab, self);
    frame_time(self, STAGE_FILL, &since);
    air_volume_find_empty(&self->volume, self->empty);
    self->hits = 0;
    frame_bound(self);
    const size_t tiles = ((self->width + FRAME_TILE - 1) / FRAME_TILE) *
                         ((self->height + FRAME_TILE - 1) / FRAME_TILE);
    air_parallel_for(self->context, tiles, frame_march_tile, self);
    frame_time(self, STAGE_MARCH, &since);
    self->whole = since - start;
    self->turn++;
}

#endif
