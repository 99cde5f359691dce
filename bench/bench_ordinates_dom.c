/* Light scattered many times in a box, by discrete ordinates: the time of a solve for each
 * instruction set, on one thread and two; its phases apart; how it grows with cells and bands.
 *
 * Wall time, the least and the median of rounds taken in turn; beside it, in the same run, a
 * kernel of fused multiplications and additions in registers and one that copies. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "airlight/ordinates_dom.h"
#include "ordinates/dom.h"

enum { ROUNDS = 10, SWEEPS = 8, LEVELS = 4, PHASES = 3 };

static const char *const level_names[LEVELS] = {"C", "SSE4.2", "AVX2", "AVX-512"};

static double now(void)
{
    struct timespec time;
    (void)clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* ---- what the machine does ---- */

#if defined(__x86_64__)
__attribute__((target("avx512f"))) static float multiply_add_512(long count)
{
    __m512 sums[16];
    float out[16];
    for (int i = 0; i < 16; i++) {
        sums[i] = _mm512_set1_ps((float)i);
    }
    const __m512 a = _mm512_set1_ps(0.999f), b = _mm512_set1_ps(0.5f);
    for (long n = 0; n < count; n++) {
#pragma GCC unroll 16
        for (int i = 0; i < 16; i++) {
            sums[i] = _mm512_fmadd_ps(sums[i], a, b);
        }
    }
    for (int i = 1; i < 16; i++) {
        sums[0] = _mm512_add_ps(sums[0], sums[i]);
    }
    _mm512_storeu_ps(out, sums[0]);
    return out[0];
}
#endif

/* GFLOP/s of one thread, 0 where there is no AVX-512; GB/s read and written by a copy. */
static void calibrate(air_context *best)
{
    static char from[4 << 20], to[4 << 20];
    double flops = 0.0, small = 0.0, large = 0.0;
    for (int round = 0; round < ROUNDS; round++) {
#if defined(__x86_64__)
        if (air_context_cpu(best) == AIR_CPU_AVX512) {
            const double before = now();
            volatile const float result = multiply_add_512(200000);
            (void)result;
            flops = fmax(flops, 200000.0 * 16 * 16 * 2 / (now() - before));
        }
#endif
        double before = now();
        memcpy(to, from, sizeof to);
        large = fmax(large, 2.0 * sizeof to / (now() - before));
        before = now();
        for (int i = 0; i < 64; i++) {
            memcpy(to, from, 256 << 10);
            from[i] = to[i + 1];
        }
        small = fmax(small, 2.0 * 64 * (256 << 10) / (now() - before));
    }
    printf("calibration, one thread: %.0f GFLOP/s; copies of 256 KiB %.1f GB/s, 4 MiB %.1f GB/s\n",
           1e-9 * flops, 1e-9 * small, 1e-9 * large);
}

/* ---- a box ---- */

static air_dom *make(air_context *context, size_t n, int bands)
{
    air_dom_params params;
    air_dom *dom = NULL;
    const size_t cells = n * n * n, moments = (size_t)(bands * bands) * AIR_DOM_STRIDE;
    float *const numbers = calloc(9 * cells + cells * moments, sizeof *numbers);
    air_dom_params_default(&params);
    for (int axis = 0; axis < 3; axis++) {
        params.size[axis] = n;
        params.cell_m[axis] = 1.0f / (float)n;
    }
    params.bands = bands;
    params.polar = bands + bands % 2;
    params.azimuths = 2 * params.polar;
    if (numbers == NULL || air_dom_create(context, &params, &dom) != AIR_OK) {
        free(numbers);
        return NULL;
    }
    float *const light = numbers + 9 * cells;
    for (size_t i = 0; i < 3 * cells; i++) {
        numbers[i] = 3.0f + (float)(i * 7 % 11) * 0.2f;
        numbers[3 * cells + i] = 0.01f;
        numbers[6 * cells + i] = 0.7f;
    }
    for (size_t cell = 0; cell < cells; cell++) { /* a beam along z: y_l0 = sqrt((2l+1)/(4 pi)) */
        const double beam = exp(-3.0 * (double)(cell / (n * n)) / (double)n);
        for (int l = 0; l < bands; l++) {
            for (size_t c = 0; c < 3; c++) {
                light[cell * moments + (size_t)(l * l + l) * AIR_DOM_STRIDE + c] =
                    (float)(beam * sqrt((2.0 * l + 1.0) / 12.566));
            }
        }
    }
    const air_dom_phase phase = {.g = numbers + 6 * cells};
    (void)air_dom_set_medium(dom, numbers, numbers + 3 * cells, &phase);
    (void)air_dom_set_light(dom, light);
    free(numbers);
    return dom;
}

static double solve_once(air_dom *dom, int depth)
{
    air_dom_solve_params params;
    air_dom_solve_params_default(&params);
    params.sweeps = SWEEPS;
    params.change = 0.0;
    params.depth = depth;
    params.cold = true;
    const double before = now();
    (void)air_dom_solve(dom, &params, NULL);
    return now() - before;
}

/* Floating-point operations of a sweep per cell: a source's and a moment's product and sum per
 * moment and direction of one octant, the octants' sums and differences twice, 20 per direction on
 * the way; channels are 4. */
static double flops_per_cell(const air_dom *dom)
{
    const double row = (double)dom->row;
    return row * (2.0 * 2.0 * dom->moments + 2.0 * 24.0 + 8.0 * 20.0);
}

/* ---- tables ---- */

static void levels(air_context *contexts[2][LEVELS])
{
    double times[2][LEVELS][ROUNDS], accelerated[ROUNDS];
    air_dom *doms[2][LEVELS] = {{NULL}};
    for (int i = 0; i < 2 * LEVELS; i++) {
        air_context *const context = contexts[i / LEVELS][i % LEVELS];
        doms[i / LEVELS][i % LEVELS] = context != NULL ? make(context, 20, 4) : NULL;
    }
    for (int round = -1; round < ROUNDS; round++) { /* one to warm up */
        for (int i = 0; i < 2 * LEVELS; i++) {
            air_dom *const dom = doms[i / LEVELS][i % LEVELS];
            if (dom != NULL) {
                times[i / LEVELS][i % LEVELS][round < 0 ? 0 : round] = solve_once(dom, 0);
            }
        }
    }
    printf("20^3 cells, 4 bands, 32 directions, 3 channels, 8 sweeps: ms, least (median) on one "
           "thread; on two\n");
    for (int level = 0; level < LEVELS; level++) {
        if (doms[0][level] == NULL || doms[1][level] == NULL) {
            continue;
        }
        qsort(times[0][level], ROUNDS, sizeof(double), compare);
        qsort(times[1][level], ROUNDS, sizeof(double), compare);
        const double one = times[0][level][0];
        for (int round = 0; round < ROUNDS; round++) {
            accelerated[round] = solve_once(doms[0][level], 4);
        }
        qsort(accelerated, ROUNDS, sizeof(double), compare);
        printf("  %-8s %7.2f (%7.2f); %7.2f (%7.2f)   %5.1f GFLOP/s; accelerated %7.2f (%7.2f)\n",
               level_names[level], 1e3 * one, 1e3 * times[0][level][ROUNDS / 2],
               1e3 * times[1][level][0], 1e3 * times[1][level][ROUNDS / 2],
               1e-9 * flops_per_cell(doms[0][level]) * 8000.0 * SWEEPS / one, 1e3 * accelerated[0],
               1e3 * accelerated[ROUNDS / 2]);
    }
    for (int i = 0; i < 2 * LEVELS; i++) {
        air_dom_destroy(doms[i / LEVELS][i % LEVELS]);
    }
}

static void run_phase(air_dom *dom, int phase)
{
    for (size_t k = 0; k < dom->params.size[2] && phase != 1; k++) {
        if (phase == 0) {
            dom->kernel->emit(dom, &dom->field, k);
        } else {
            dom->kernel->gather(dom, k);
        }
    }
    for (int octant = 0; octant < DOM_OCTANTS && phase == 1; octant++) {
        dom->kernel->sweep(dom, octant);
    }
}

/* Apart; bytes: of what each must read and write at least. */
static void phases(air_context *context, size_t n, int bands)
{
    static const char *const names[PHASES] = {"emit", "sweep", "gather"};
    double times[PHASES] = {INFINITY, INFINITY, INFINITY};
    air_dom *const dom = make(context, n, bands);
    if (dom == NULL) {
        return;
    }
    const double cells = (double)dom->cells, radiance = 8.0 * (double)dom->row * sizeof(float);
    const double moments = 4.0 * dom->moments * sizeof(float);
    const double bytes[PHASES] = {2.0 * moments + radiance, 2.0 * radiance,
                                  radiance + 2.0 * moments};
    (void)solve_once(dom, 0);
    for (int round = 0; round < ROUNDS; round++) {
        for (int phase = 0; phase < PHASES; phase++) {
            const double before = now();
            run_phase(dom, phase);
            times[phase] = fmin(times[phase], now() - before);
        }
    }
    printf("  %2zu^3, %2d bands:", n, bands);
    for (int phase = 0; phase < PHASES; phase++) {
        printf(" %s %6.1f ns per cell, %4.1f GB/s;", names[phase], 1e9 * times[phase] / cells,
               1e-9 * bytes[phase] * cells / times[phase]);
    }
    printf(" all %.1f ns\n", 1e9 * (times[0] + times[1] + times[2]) / cells);
    air_dom_destroy(dom);
}

int main(void)
{
    air_context *contexts[2][LEVELS] = {{NULL}}, *best = NULL;
    for (int i = 0; i < 2 * LEVELS; i++) {
        air_context_params params;
        air_context_params_default(&params);
        params.thread_count = (size_t)(1 + i / LEVELS);
        params.cpu = (air_cpu)(AIR_CPU_C + i % LEVELS);
        if (air_context_create(&params, &contexts[i / LEVELS][i % LEVELS]) == AIR_OK &&
            i < LEVELS) {
            best = contexts[0][i];
        }
    }
    calibrate(best);
    levels(contexts);
    printf("phases apart, one thread, the best instruction set\n");
    for (size_t n = 8; n <= 64; n += n < 24 ? 4 : n < 32 ? 8 : 32) {
        phases(best, n, 4);
    }
    for (int bands = 1; bands <= AIR_DOM_BANDS_MAX; bands++) {
        phases(best, 20, bands);
    }
    for (int i = 0; i < 2 * LEVELS; i++) {
        air_context_destroy(contexts[i / LEVELS][i % LEVELS]);
    }
    return 0;
}
