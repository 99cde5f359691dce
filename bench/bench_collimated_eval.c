/* air_collimated_eval: ns per T of the plain version and of every instruction set, on a box and on
 * a dodecahedron, with and without log T.
 *
 * Versions are timed in turn, round by round; printed are medians over the rounds, their quartiles,
 * and the median and range of the ratio to the plain version. For the machine's pace: the best time
 * of a chain of additions, each of which waits for the one before (4 cycles on Skylake). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "airlight/collimated.h"

enum { SIDE = 64, RAYS = SIDE * SIDE, ROUNDS = 21, SETTLE = 4, REPEATS = 8, LEVELS = 4 };

typedef struct course {
    double origin[3][RAYS], dir[3][RAYS], t[RAYS], log_t[RAYS];
    air_context *contexts[LEVELS]; /* NULL where the machine lacks the level */
} course;

static air_collimated_medium make_box(void)
{
    air_collimated_medium box = {.plane_count = 6};
    for (int k = 0; k < 6; k++) {
        box.planes[k][k / 2] = k % 2 == 0 ? 1.0 : -1.0;
        box.planes[k][3] = 1.0;
    }
    return box;
}

/* Normals (0, +-1, +-g), cyclic; g the golden ratio. */
static air_collimated_medium make_dodecahedron(void)
{
    air_collimated_medium out = {.plane_count = 12};
    const double g = 0.5 + 0.5 * sqrt(5.0);
    for (int k = 0; k < 12; k++) {
        double *n = out.planes[k];
        n[(k / 4 + 1) % 3] = k % 2 == 0 ? 1.0 : -1.0;
        n[(k / 4 + 2) % 3] = k / 2 % 2 == 0 ? g : -g;
        n[3] = sqrt(1.0 + g * g);
    }
    return out;
}

/* Looking at the unit cube from outside. */
static void make_rays(course *self)
{
    static const double eye[3] = {0.5, 1.0, 3.5};
    for (int i = 0; i < RAYS; i++) {
        const double x = 1.6 * (i % SIDE + 0.5) / SIDE - 0.8,
                     y = 0.8 - 1.6 * (i / SIDE + 0.5) / SIDE;
        const double to[3] = {x - eye[0], y - eye[1], -eye[2]};
        const double length = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
        for (int k = 0; k < 3; k++) {
            self->origin[k][i] = eye[k];
            self->dir[k][i] = to[k] / length;
        }
    }
}

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ns per ray. A level gets its time in one piece, after a while in which the clock may settle: it
 * is slower for wide vectors. */
static double time_level(course *self, int level, const air_collimated_medium *medium, bool logs)
{
    const double to_light[3] = {-0.3 / sqrt(0.54), 0.6 / sqrt(0.54), -0.3 / sqrt(0.54)};
    const air_collimated_rays rays = {{self->origin[0], self->origin[1], self->origin[2]},
                                      {self->dir[0], self->dir[1], self->dir[2]},
                                      NULL};
    double start = 0.0;
    for (int i = -SETTLE; i < REPEATS; i++) {
        start = i == 0 ? seconds() : start;
        air_collimated_eval(self->contexts[level], medium, to_light, 1.0, &rays, RAYS, self->t,
                            logs ? self->log_t : NULL);
    }
    return 1e9 * (seconds() - start) / ((double)RAYS * REPEATS);
}

/* ns per addition */
static double time_additions(void)
{
    enum { CHAIN = 100000 };
    volatile double step = 1.0;
    double best = INFINITY;
    for (int i = 0; i < ROUNDS; i++) {
        const double x = step, start = seconds();
        double sum = x;
        for (int k = 0; k < CHAIN; k++) {
            sum += x;
        }
        step = sum > 0.0 ? x : sum;
        const double taken = 1e9 * (seconds() - start) / CHAIN;
        best = taken < best ? taken : best;
    }
    return best;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(course *self, const char *name, const air_collimated_medium *medium, bool logs)
{
    static const char *const levels[LEVELS] = {"C", "SSE4.2", "AVX2", "AVX-512"};
    double taken[LEVELS][ROUNDS], ratio[LEVELS][ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        for (int level = 0; level < LEVELS; level++) {
            if (self->contexts[level] != NULL) {
                taken[level][i] = time_level(self, level, medium, logs);
                ratio[level][i] = taken[0][i] / taken[level][i];
            }
        }
    }
    for (int level = 0; level < LEVELS; level++) {
        if (self->contexts[level] != NULL) {
            double *t = taken[level], *r = ratio[level];
            qsort(t, ROUNDS, sizeof *t, compare_doubles);
            qsort(r, ROUNDS, sizeof *r, compare_doubles);
            printf("%-12s %-5s %-8s %7.2f (%.2f to %.2f)   %6.2f (%.2f to %.2f)\n", name,
                   logs ? "log T" : "T", levels[level], t[ROUNDS / 2], t[ROUNDS / 4],
                   t[3 * ROUNDS / 4], r[ROUNDS / 2], r[0], r[ROUNDS - 1]);
        }
    }
}

int main(void)
{
    course *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return EXIT_FAILURE;
    }
    for (int level = 0; level < LEVELS; level++) {
        air_context_params params;
        air_context_params_default(&params);
        params.cpu = (air_cpu)(AIR_CPU_C + level);
        (void)air_context_create(&params, &self->contexts[level]);
    }
    make_rays(self);
    const air_collimated_medium box = make_box(), dodecahedron = make_dodecahedron();
    printf("an addition: %.2f ns\n", time_additions());
    printf("ns per ray, median (quartiles); times as fast as C, median (range)\n");
    for (int logs = 0; logs < 2; logs++) {
        measure(self, "box", &box, logs != 0);
        measure(self, "dodecahedron", &dodecahedron, logs != 0);
    }
    for (int level = 0; level < LEVELS; level++) {
        air_context_destroy(self->contexts[level]);
    }
    free(self);
    return EXIT_SUCCESS;
}
