/* air_ordinates_run: 64 directions x 3 channels of 20^3 cells, 10 steps each, with what an observer
 * sees summed up; by every instruction set, on one thread and on two.
 *
 * Wall time of all of it, arguments checked and grids laid out included, versions in turn; printed
 * are the best of the rounds, median and quartiles. Where others use the machine, the least times
 * of the single directions and channels, 0.1 to 0.5 ms each, say more: their sum over the threads,
 * what that is in ns of a thread per cell and step, and in GFLOP/s of a thread beside what a kernel
 * of multiplications and additions reaches in the same run. Media are shared by directions and thus
 * near, as they are where they have just been sampled. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "airlight/ordinates.h"
#include "core/host.h"
#include "core/random.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

enum {
    SIDE = 20,
    CELLS = SIDE * SIDE * SIDE,
    DIRECTIONS = 64,
    CHANNELS = 3,
    ITEMS = DIRECTIONS * CHANNELS,
    STEPS = 10,
    ROUNDS = 10,
    SLOW_ROUNDS = 3, /* of C */
    LEVELS = 4,
    THREADS = 2
};

/* Multiplications and additions of a cell and step with phase functions, roots and inverses counted
 * as one: LITERAL 31 to send, 17 to be seen, 24 to receive; CM 87, 18 and 47. */
static const double flop[2] = {72.0, 152.0};

typedef struct course {
    float sigma_s[CHANNELS][CELLS], sigma_a[CELLS], g[CELLS], view_cosine[DIRECTIONS][CELLS];
    float seen[ITEMS][CELLS];
    void *scratch[THREADS];
    air_context *context;
    air_ordinates_params params;
    double (*least)[ITEMS]; /* seconds of each */
    bool failed;
} course;

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Smoke of optical thickness 4 across. */
static void fill(course *self)
{
    air_rng rng = air_rng_from_keys(5, 9);
    for (int i = 0; i < CELLS; i++) {
        const float density = 2.0f * air_rng_float(&rng);
        for (int c = 0; c < CHANNELS; c++) {
            self->sigma_s[c][i] = density * (3.5f + 0.5f * (float)c);
        }
        self->sigma_a[i] = 0.1f * density;
        self->g[i] = 0.7f;
        for (int d = 0; d < DIRECTIONS; d++) {
            self->view_cosine[d][i] = 2.0f * air_rng_float(&rng) - 1.0f;
        }
    }
}

static void run_item(void *user, size_t item, size_t worker)
{
    course *const self = user;
    const air_ordinates_cells cells = {.size = {SIDE, SIDE, SIDE},
                                       .cell_m = 1.0f / SIDE,
                                       .sigma_s = self->sigma_s[item % CHANNELS],
                                       .sigma_a = self->sigma_a,
                                       .g = self->g};
    const air_ordinates_results results = {.view_cosine = self->view_cosine[item / CHANNELS],
                                           .seen = self->seen[item]};
    const double start = seconds();
    if (air_ordinates_run(self->context, &cells, &self->params, self->scratch[worker], &results) !=
        AIR_OK) {
        self->failed = true;
    }
    (*self->least)[item] = fmin((*self->least)[item], seconds() - start);
}

static double time_all(course *self)
{
    const double start = seconds();
    air_parallel_for(self->context, ITEMS, run_item, self);
    return seconds() - start;
}

/* ---- what the machine can do ---- */

#if defined(__x86_64__)
enum { CHAINS = 12, TURNS = 20000 };

__attribute__((target("avx512f"))) static float multiply_add_16(float with)
{
    __m512 sum[CHAINS];
    const __m512 factor = _mm512_set1_ps(with);
    for (int i = 0; i < CHAINS; i++) {
        sum[i] = _mm512_set1_ps((float)i);
    }
    for (int k = 0; k < TURNS; k++) {
        for (int i = 0; i < CHAINS; i++) {
            sum[i] = _mm512_fmadd_ps(sum[i], factor, factor);
        }
    }
    float all = 0.0f;
    for (int i = 0; i < CHAINS; i++) {
        all += _mm512_reduce_add_ps(sum[i]);
    }
    return all;
}

__attribute__((target("avx2,fma"))) static float multiply_add_8(float with)
{
    __m256 sum[CHAINS];
    const __m256 factor = _mm256_set1_ps(with);
    for (int i = 0; i < CHAINS; i++) {
        sum[i] = _mm256_set1_ps((float)i);
    }
    for (int k = 0; k < TURNS; k++) {
        for (int i = 0; i < CHAINS; i++) {
            sum[i] = _mm256_fmadd_ps(sum[i], factor, factor);
        }
    }
    float all[8], whole = 0.0f;
    for (int i = 0; i < CHAINS; i++) {
        _mm256_storeu_ps(all, sum[i]);
        whole += all[0];
    }
    return whole;
}

/* GFLOP/s of one thread. */
static double calibrate(bool wide)
{
    volatile float with = 0.5f, result = 0.0f;
    double best = INFINITY;
    for (int round = 0; round < 20; round++) {
        const double start = seconds();
        result = wide ? multiply_add_16(with) : multiply_add_8(with);
        best = fmin(best, seconds() - start);
    }
    (void)result;
    return 1e-9 * 2.0 * CHAINS * TURNS * (wide ? 16 : 8) / best;
}
#endif

/* ---- */

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report(const char *stencil, double operations, const char *level, int threads,
                   double *taken, int rounds, const double *least)
{
    const double updates = (double)ITEMS * CELLS * STEPS;
    double sum = 0.0;
    for (int i = 0; i < ITEMS; i++) {
        sum += least[i];
    }
    qsort(taken, (size_t)rounds, sizeof *taken, compare_doubles);
    printf("%-8s %-8s %d  %8.2f  %8.2f (%.2f to %.2f)  %8.2f  %6.2f  %6.1f\n", stencil, level,
           threads, 1e3 * taken[0], 1e3 * taken[rounds / 2], 1e3 * taken[rounds / 4],
           1e3 * taken[3 * rounds / 4], 1e3 * sum / threads, 1e9 * sum / updates,
           1e-9 * updates * operations / sum);
}

static void measure(course *self, air_context *contexts[LEVELS][THREADS], int stencil)
{
    static const char *const levels[LEVELS] = {"C", "SSE4.2", "AVX2", "AVX-512"};
    static double taken[LEVELS][THREADS][ROUNDS], least[LEVELS][THREADS][ITEMS];
    self->params.stencil = (air_ordinates_stencil)stencil;
    for (int i = 0; i < LEVELS * THREADS * ITEMS; i++) {
        least[i / ITEMS / THREADS][i / ITEMS % THREADS][i % ITEMS] = INFINITY;
    }
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < LEVELS * THREADS; i++) {
            self->least = &least[i / THREADS][i % THREADS];
            self->context = contexts[i / THREADS][i % THREADS];
            if (self->context != NULL && (i / THREADS > 0 || round < SLOW_ROUNDS)) {
                taken[i / THREADS][i % THREADS][round] = time_all(self);
            }
        }
    }
    for (int i = 0; i < LEVELS * THREADS; i++) {
        if (contexts[i / THREADS][i % THREADS] != NULL) {
            report(stencil == 0 ? "literal" : "cm", flop[stencil], levels[i / THREADS],
                   1 + i % THREADS, taken[i / THREADS][i % THREADS],
                   i / THREADS > 0 ? ROUNDS : SLOW_ROUNDS, least[i / THREADS][i % THREADS]);
        }
    }
}

int main(void)
{
    course *const self = calloc(1, sizeof *self);
    air_context *contexts[LEVELS][THREADS] = {{NULL}};
    if (self == NULL) {
        return EXIT_FAILURE;
    }
    fill(self);
    air_ordinates_params_default(&self->params);
    self->params.steps = STEPS;
    self->params.residual = 0.0;
    const air_ordinates_cells cells = {.size = {SIDE, SIDE, SIDE}};
    const size_t bytes = air_ordinates_scratch(&cells, &self->params);
    for (int i = 0; i < LEVELS * THREADS; i++) {
        air_context_params params;
        air_context_params_default(&params);
        params.cpu = (air_cpu)(AIR_CPU_C + i / THREADS);
        params.thread_count = (size_t)(1 + i % THREADS);
        (void)air_context_create(&params, &contexts[i / THREADS][i % THREADS]);
    }
    for (int i = 0; i < THREADS; i++) {
        self->scratch[i] = aligned_alloc(64, (bytes + 63) / 64 * 64);
        self->failed = self->failed || self->scratch[i] == NULL;
    }
#if defined(__x86_64__)
    if (contexts[AIR_CPU_AVX512 - AIR_CPU_C][0] != NULL) {
        printf("multiplying and adding, a thread: AVX-512 %.0f GFLOP/s\n", calibrate(true));
    }
    if (contexts[AIR_CPU_AVX2 - AIR_CPU_C][0] != NULL) {
        printf("multiplying and adding, a thread: AVX2 %.0f GFLOP/s\n", calibrate(false));
    }
#endif
    printf("threads; ms: best, median (quartiles), least times; ns per cell and step; GFLOP/s\n");
    for (int stencil = 0; stencil < 2 && !self->failed; stencil++) {
        measure(self, contexts, stencil);
    }
    for (int i = 0; i < LEVELS * THREADS; i++) {
        air_context_destroy(contexts[i / THREADS][i % THREADS]);
    }
    for (int i = 0; i < THREADS; i++) {
        free(self->scratch[i]);
    }
    const bool failed = self->failed;
    free(self);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
