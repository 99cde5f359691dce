/* air_denoise_planes: ns per pixel and level of every instruction set, 6 planes of 1280 x 720 on
 * one thread; beside it what the arithmetic and the memory alone would take.
 *
 * Versions are timed in turn, round by round; printed are medians and quartiles over the rounds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "airlight/denoise.h"

enum { WIDTH = 1280, HEIGHT = 720, PIXELS = WIDTH * HEIGHT, PLANES = 6, ROUNDS = 9, VERSIONS = 4 };

typedef struct course {
    float depth[PIXELS], normal[3][PIXELS];
    float noise[PLANES][PIXELS], planes[PLANES][PIXELS];
    air_context *contexts[VERSIONS]; /* NULL where the machine lacks the instructions */
} course;

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Waves under a sky: depths and normals that change, so that no weight is 0 or 1 throughout. */
static void make_guides(course *self)
{
    for (int i = 0; i < PIXELS; i++) {
        const double x = i % WIDTH, y = i / WIDTH;
        const double slope[2] = {0.3 * sin(x / 40.0), 0.3 * cos(y / 30.0)};
        const double length = sqrt(1.0 + slope[0] * slope[0] + slope[1] * slope[1]);
        const bool sky = y < HEIGHT / 8;
        self->depth[i] = sky ? 0.0f : (float)(400.0 / y);
        self->normal[0][i] = sky ? 0.0f : (float)(slope[0] / length);
        self->normal[1][i] = sky ? 0.0f : (float)(slope[1] / length);
        self->normal[2][i] = sky ? 0.0f : (float)(1.0 / length);
    }
}

static void make_noise(course *self)
{
    uint64_t random = 1;
    for (int k = 0; k < PLANES; k++) {
        for (int i = 0; i < PIXELS; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            self->noise[k][i] = (float)(random >> 40) * 0x1p-24f;
        }
    }
}

/* Seconds of one run over all planes. */
static double time_run(course *self, int version, uint32_t levels, bool normals)
{
    air_denoise_params params;
    air_denoise_guides guides = {WIDTH, HEIGHT, self->depth, {NULL, NULL, NULL}, NULL};
    float *planes[PLANES];
    air_denoise_params_default(&params);
    params.levels = levels;
    for (int k = 0; k < 3; k++) {
        guides.normal[k] = normals ? self->normal[k] : NULL;
    }
    for (int k = 0; k < PLANES; k++) {
        planes[k] = self->planes[k];
    }
    memcpy(self->planes, self->noise, sizeof self->planes);
    const double start = seconds();
    if (air_denoise_planes(self->contexts[version], &guides, &params, planes, PLANES) != AIR_OK) {
        return NAN;
    }
    return seconds() - start;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(course *self, bool normals)
{
    static const char *const names[VERSIONS] = {"C", "SSE4.2", "AVX2", "AVX-512"};
    double taken[VERSIONS][ROUNDS], prepare[VERSIONS][ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        for (int v = 0; v < VERSIONS; v++) {
            if (self->contexts[v] != NULL) {
                /* what is done once does not count to the levels */
                const double one = time_run(self, v, 1, normals);
                const double four = time_run(self, v, 4, normals);
                taken[v][i] = 1e9 * (four - one) / (3.0 * PIXELS);
                prepare[v][i] = 1e9 * one / PIXELS - taken[v][i];
            }
        }
    }
    for (int v = 0; v < VERSIONS; v++) {
        if (self->contexts[v] != NULL) {
            qsort(taken[v], ROUNDS, sizeof(double), compare_doubles);
            qsort(prepare[v], ROUNDS, sizeof(double), compare_doubles);
            printf("%-16s %-8s %7.1f (%.1f to %.1f)  %7.1f\n", normals ? "depth, normals" : "depth",
                   names[v], taken[v][ROUNDS / 2], taken[v][ROUNDS / 4], taken[v][3 * ROUNDS / 4],
                   prepare[v][ROUNDS / 2]);
        }
    }
}

/* What a level must move: every plane read and written once. */
static double time_copy(course *self)
{
    double best = INFINITY;
    for (int i = 0; i < ROUNDS; i++) {
        const double start = seconds();
        memcpy(self->planes, self->noise, sizeof self->planes);
        best = fmin(best, 1e9 * (seconds() - start) / PIXELS);
    }
    return best;
}

int main(void)
{
    course *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return EXIT_FAILURE;
    }
    for (int v = 0; v < VERSIONS; v++) {
        air_context_params params;
        air_context_params_default(&params);
        params.cpu = (air_cpu)(AIR_CPU_C + v);
        params.thread_count = 1;
        (void)air_context_create(&params, &self->contexts[v]);
    }
    make_guides(self);
    make_noise(self);
    printf("copying 6 planes: %.1f ns per pixel\n", time_copy(self));
    printf("ns per pixel and level, median (quartiles); ns per pixel before and after\n");
    measure(self, true);
    measure(self, false);
    for (int v = 0; v < VERSIONS; v++) {
        air_context_destroy(self->contexts[v]);
    }
    free(self);
    return EXIT_SUCCESS;
}
