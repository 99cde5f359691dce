/* A whole picture by discrete ordinates, at the level of kernels: 800 x 600, half of it smoke of
 * 64^3 voxels under a sky of 64 directions; [Elek2014]'s stages one by one beside the paper's
 * figures (of another machine, and with the paper's propagation); how they grow.
 *
 * Wall times on two threads, the best, the median and the quartiles of rounds. Beside each stage
 * what it would take at the speed of the kernels at the top: floating-point operations at the rate
 * of multiplying and adding in registers, bytes at the rate of copies that stay in the second
 * cache.
 *
 * Arguments: "frame" leaves growth out; "one", the last, takes one thread and the processor's time
 * of it, which says more where others use the machine. */
#include <stdio.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "ordinates_frame.h"

enum { ROUNDS = 10, SIZES = 4 };

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* ---- what the machine does ---- */

typedef struct rates {
    air_context *context;
    float *from, *to;
    double flops, bytes; /* per second, of two threads */
} rates;

enum { TURNS = 200000, COPIED = 1 << 16 /* floats of a thread */, COPIES = 16 };

#if defined(__x86_64__)
__attribute__((target("avx512f"))) static float multiply_add_512(void)
{
    __m512 sums[16];
    const __m512 a = _mm512_set1_ps(0.999f), b = _mm512_set1_ps(0.5f);
    for (int i = 0; i < 16; i++) {
        sums[i] = _mm512_set1_ps((float)i);
    }
    for (long n = 0; n < TURNS; n++) {
#pragma GCC unroll 16
        for (int i = 0; i < 16; i++) {
            sums[i] = _mm512_fmadd_ps(sums[i], a, b);
        }
    }
    for (int i = 1; i < 16; i++) {
        sums[0] = _mm512_add_ps(sums[0], sums[i]);
    }
    return _mm512_reduce_add_ps(sums[0]);
}
#endif

static void multiply_add(void *user, size_t index, size_t worker)
{
    const rates *const self = user;
    (void)index;
    (void)worker;
#if defined(__x86_64__)
    if (air_context_cpu(self->context) == AIR_CPU_AVX512) {
        volatile const float result = multiply_add_512();
        (void)result;
    }
#else
    (void)self;
#endif
}

static void copy_part(void *user, size_t index, size_t worker)
{
    const rates *const self = user;
    (void)worker;
    for (int i = 0; i < COPIES; i++) {
        memcpy(self->to + index * COPIED, self->from + index * COPIED, COPIED * sizeof(float));
        self->from[index * COPIED] = self->to[index * COPIED + 1];
    }
}

static rates calibrate(air_context *context)
{
    rates self = {.context = context,
                  .from = frame_floats(FRAME_THREADS * COPIED),
                  .to = frame_floats(FRAME_THREADS * COPIED)};
    const bool wide = air_context_cpu(context) == AIR_CPU_AVX512;
    for (int round = 0; round < ROUNDS; round++) {
        double start = frame_now();
        air_parallel_for(context, FRAME_THREADS, multiply_add, &self);
        const double flops = FRAME_THREADS * 2.0 * 16.0 * 16.0 * TURNS / (frame_now() - start);
        self.flops = wide ? fmax(self.flops, flops) : 0.0;
        start = frame_now();
        air_parallel_for(context, FRAME_THREADS, copy_part, &self);
        self.bytes =
            fmax(self.bytes, FRAME_THREADS * 2.0 * 4.0 * COPIED * COPIES / (frame_now() - start));
    }
    free(self.from);
    free(self.to);
    printf("%zu threads: multiplying and adding %.0f GFLOP/s, copying 256 KiB each %.1f GB/s\n",
           air_context_thread_count(context), 1e-9 * self.flops, 1e-9 * self.bytes);
    return self;
}

/* ---- a frame ---- */

typedef struct row {
    const char *name;
    double paper; /* ms; 0: not apart */
    double flop, byte;
} row;

/* Operations and bytes by the loops' text, roots, inverses and exponentials as the operations that
 * they consist of; bytes: arrays read and written once per stage or block. */
static void count_work(const frame *self, row rows[STAGES])
{
    const double cells = (double)self->cells, beams = (double)self->count;
    const double moments = (double)(self->bands * self->bands);
    const double voxels = (double)FRAME_VOXELS * FRAME_VOXELS * FRAME_VOXELS;
    const double blocks = ceil(beams / FRAME_BLOCK), steps = FRAME_MARCH * (double)self->hits;
    const double ways = 64.0 * 32.0 * 8.0 * 8.0 * 8.0 / 16.0; /* out of blocks, by coarse texels */
    const row all[STAGES] = {
        /* 60 steps of 152 a cell; up to 64 places of 16 on each way out; lobes 20 a texel */
        {"importance", 5.0, 60.0 * 4096.0 * 152.0 + ways * 40.0 * 16.0 + 512.0 * 512.0 * 20.0,
         60.0 * 4096.0 * 40.0},
        {"ordinates", 2.0, 0.0, 0.0},
        {"cells", 2.0, voxels + cells * 40.0, 4.0 * voxels + cells * 4.0 * 26.0},
        /* smoke is grey, one number: 16 to interpolate, 70 to average */
        {"beams", 0.0, beams * cells * 86.0, beams * cells * 32.0},
        {"moments", 0.0, beams * cells * 8.0 * moments,
         beams * cells * 16.0 + blocks * cells * moments * 32.0 + cells * moments * 32.0},
        /* see bench_ordinates_dom.c: rows of 16 numbers, 8 octants */
        {"propagation", 12.0, self->sweeps * cells * 16.0 * (4.0 * moments + 48.0 + 160.0),
         self->sweeps * cells * (4.0 * moments * 4.0 * 4.0 + 6.0 * 8.0 * 16.0 * 4.0)},
        {"seen", 0.0, beams * cells * (20.0 + 12.0) + cells * moments * 12.0,
         beams * cells * 16.0 + blocks * cells * 32.0 + cells * moments * 16.0 * 3.0},
        {"upsampling", 4.0, voxels * 8.0 * (8.0 + 20.0), voxels * 20.0},
        /* Of every step, were none passed over: 7 mixtures of 4, 18 on places, 15 on the
         * exponential, 8 to sum up. */
        {"march", 5.0, steps * (7.0 * 12.0 + 18.0 + 15.0 + 8.0), voxels * 17.0}};
    memcpy(rows, all, sizeof all);
}

typedef struct spread {
    double best, low, median, high;
} spread;

static spread spread_of(double *times, size_t count)
{
    qsort(times, count, sizeof *times, compare);
    return (spread){1e3 * times[0], 1e3 * times[count / 4], 1e3 * times[count / 2],
                    1e3 * times[3 * count / 4]};
}

static void show_frame(frame *self, const rates *machine)
{
    double times[STAGES + 1][ROUNDS];
    row rows[STAGES];
    for (int round = -2; round < ROUNDS; round++) { /* two to warm up */
        frame_run(self);
        for (int stage = 0; stage < STAGES && round >= 0; stage++) {
            times[stage][round] = self->seconds[stage];
        }
        times[STAGES][round < 0 ? 0 : round] = self->whole;
    }
    count_work(self, rows);
    printf("%zu x %zu, %zu rays into smoke, %zu directions, %zu^3 cells, %u sweeps\n", self->width,
           self->height, self->hits, self->count, self->side, self->sweeps);
    printf("%-12s %5s %6s %6s (%s)  GFLOP/s  GB/s  limit ms\n", "ms", "paper", "best", "median",
           "quartiles");
    for (int stage = 0; stage < STAGES; stage++) {
        const row *const r = &rows[stage];
        const spread s = spread_of(times[stage], ROUNDS);
        const double limit =
            fmax(machine->flops > 0.0 ? r->flop / machine->flops : 0.0, r->byte / machine->bytes);
        printf("%-12s %5.0f %6.2f %6.2f (%.2f to %.2f)  %5.1f  %5.1f  %5.2f\n", r->name, r->paper,
               s.best, s.median, s.low, s.high, 1e-6 * r->flop / s.best, 1e-6 * r->byte / s.best,
               1e3 * limit);
    }
    printf("%-12s %5.0f      - (the solver has no residue of power to spread)\n", "residuum", 2.0);
    const spread s = spread_of(times[STAGES], ROUNDS);
    printf("%-12s %5.0f %6.2f %6.2f (%.2f to %.2f)\n", "frame", 32.0, s.best, s.median, s.low,
           s.high);
}

/* 8 sweeps from no light and from the last frame's, the smoke having moved. */
static void show_starts(frame *self)
{
    for (int cold = 0; cold < 2; cold++) {
        double times[ROUNDS];
        self->cold = cold == 1;
        for (int round = 0; round < ROUNDS; round++) {
            frame_run(self);
            times[round] = self->seconds[STAGE_SOLVE];
        }
        const spread s = spread_of(times, ROUNDS);
        printf("propagation, %s: %.2f ms, median %.2f (%.2f to %.2f); the last sweep changes the "
               "light by %.1e\n",
               cold == 1 ? "cold" : "warm", s.best, s.median, s.low, s.high, self->report.change);
    }
    self->cold = false;
}

/* ---- growth ---- */

typedef struct growth {
    const char *what;
    size_t value[SIZES];
    int stages[3]; /* ends with -1 */
} growth;

static void set_size(int which, size_t value, air_context *context, frame *out)
{
    const size_t width = which == 2 ? value : 400, height = width * 3 / 4;
    frame_make(context, which == 0 ? value : 20, which == 1 ? value : 64, width, height, out);
    out->sweeps = which == 3 ? (uint32_t)value : 8;
}

/* The slope of log time over log size, by least squares. */
static double exponent_of(const size_t *sizes, const double *times)
{
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int i = 0; i < SIZES; i++) {
        const double a = log((double)sizes[i]), b = log(times[i]);
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    return (SIZES * xy - x * y) / (SIZES * xx - x * x);
}

static void show_growth(air_context *context)
{
    static const growth all[] = {
        {"cells along an axis", {8, 16, 32, 64}, {STAGE_BEAMS, STAGE_SOLVE, STAGE_SEEN}},
        {"directions", {16, 32, 64, 256}, {STAGE_BEAMS, STAGE_MOMENTS, STAGE_SEEN}},
        {"pixels across", {200, 400, 800, 1600}, {STAGE_MARCH, -1, -1}},
        {"sweeps", {4, 8, 16, 32}, {STAGE_SOLVE, -1, -1}}};
    static frame self;
    row rows[STAGES];
    for (int which = 0; which < 4; which++) {
        double times[STAGES][SIZES];
        for (int i = 0; i < SIZES; i++) {
            set_size(which, all[which].value[i], context, &self);
            for (int round = 0; round < ROUNDS / 2; round++) {
                frame_run(&self);
                for (int s = 0; s < STAGES; s++) {
                    times[s][i] = round == 0 ? self.seconds[s] : fmin(times[s][i], self.seconds[s]);
                }
            }
            frame_finish(&self);
        }
        count_work(&self, rows);
        for (int n = 0; n < 3 && all[which].stages[n] >= 0; n++) {
            const int stage = all[which].stages[n];
            printf("%-20s %-12s", n == 0 ? all[which].what : "", rows[stage].name);
            for (int i = 0; i < SIZES; i++) {
                printf(" %4zu: %7.2f ms;", all[which].value[i], 1e3 * times[stage][i]);
            }
            printf(" exponent %.2f\n", exponent_of(all[which].value, times[stage]));
        }
    }
}

int main(int argc, char **argv)
{
    static frame self;
    air_context *context = NULL;
    air_context_params params;
    air_context_params_default(&params);
    params.thread_count = FRAME_THREADS;
    if (argc > 1 && strcmp(argv[argc - 1], "one") == 0) {
        params.thread_count = 1;
        frame_clock = CLOCK_PROCESS_CPUTIME_ID;
    }
    if (air_context_create(&params, &context) != AIR_OK) {
        return EXIT_FAILURE;
    }
    const rates machine = calibrate(context);
    frame_make(context, 20, 64, 800, 600, &self);
    show_frame(&self, &machine);
    show_starts(&self);
    frame_finish(&self);
    if (argc < 2 || strcmp(argv[1], "frame") != 0) {
        show_growth(context);
    }
    air_context_destroy(context);
    return EXIT_SUCCESS;
}
