/* air_area_eval_*: ns per S of the plain version and of every instruction set, for a square lamp,
 * points and directions at random around it, edges by 2, 4 and 8 nodes and two lobes, in double and
 * in float.
 *
 * Versions are timed in turn, round by round; printed are medians over the rounds, their quartiles,
 * and the median and range of the ratio to the plain version, which computes in double for both. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "airlight/arealight_eval.h"
#include "core/random.h"

enum { POINTS = 4096, ROUNDS = 15, SETTLE = 2, REPEATS = 6, LEVELS = 4, CASES = 5 };

typedef struct course {
    double position[3][POINTS], wo[3][POINTS], s[POINTS];
    float position_float[3][POINTS], wo_float[3][POINTS], s_float[POINTS];
    air_area_lamp lamp;
    air_context *contexts[LEVELS]; /* NULL where the machine lacks the level */
} course;

typedef struct question {
    const char *name;
    int nodes; /* 0: lobes */
    air_area_lobe lobe;
} question;

static const question questions[CASES] = {
    {"edge 2", 2, {0.0, 1.0, 0.0, 1.0, 0.0}},
    {"edge 4", 4, {0.0, 1.0, 0.0, 1.0, 0.0}},
    {"edge 8", 8, {0.0, 1.0, 0.0, 1.0, 0.0}},
    /* Fitted at g = 0.4: the paper's and the mixed model. */
    {"LTSD", 0, {0.4, 0.964044, 1.0, 1.625894, -1.0}},
    {"MIX", 0, {0.4, 1.324243, 0.430880, 0.964292, -0.337100}}};

static air_area_lamp make_lamp(void)
{
    return (air_area_lamp){
        .vertex_count = 4,
        .vertices = {{-1.0, -0.5, 0.0}, {1.0, -0.5, 0.0}, {1.0, 0.5, 0.0}, {-1.0, 0.5, 0.0}},
        .normal = {0.0, 0.0, 1.0},
        .area = 2.0,
        .two_sided = true};
}

/* Points in a cube about the lamp. spread: directions of neighbours all ways, so that nearly every
 * group of lanes has an edge that a horizon cuts; else slowly turning, as along a row of pixels. */
static void make_points(course *self, bool spread)
{
    air_rng rng = air_rng_from_keys(5, 1);
    for (int i = 0; i < POINTS; i++) {
        double x[6], square;
        do {
            for (int k = 0; k < 6; k++) {
                x[k] = 2.0 * air_rng_next(&rng) * 0x1p-32 - 1.0;
            }
            square = x[3] * x[3] + x[4] * x[4] + x[5] * x[5];
        } while (!(square > 0.01 && square < 1.0));
        const double row = i / 64 / 64.0 - 0.5, column = i % 64 / 64.0 - 0.5;
        const double near[6] = {2.0 * column, 2.0 * row, 1.5, column, row, 0.5};
        square = spread ? square : column * column + row * row + 0.25;
        for (int k = 0; k < 3; k++) {
            self->position[k][i] = spread ? 2.0 * x[k] : near[k];
            self->wo[k][i] = (spread ? x[3 + k] : near[3 + k]) / sqrt(square);
            self->position_float[k][i] = (float)self->position[k][i];
            self->wo_float[k][i] = (float)self->wo[k][i];
        }
    }
}

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void ask(course *self, int level, const question *q)
{
    const air_area_shading_points p = {{self->position[0], self->position[1], self->position[2]},
                                       {self->wo[0], self->wo[1], self->wo[2]}};
    if (q->nodes > 0) {
        air_area_eval_edge(self->contexts[level], &self->lamp, 0.4, q->nodes, &p, POINTS, self->s);
    } else {
        air_area_eval_lobes(self->contexts[level], &self->lamp, &q->lobe, &p, POINTS, self->s);
    }
}

static void ask_float(course *self, int level, const question *q)
{
    const air_area_shading_points_float p = {
        {self->position_float[0], self->position_float[1], self->position_float[2]},
        {self->wo_float[0], self->wo_float[1], self->wo_float[2]}};
    if (q->nodes > 0) {
        air_area_eval_edge_float(self->contexts[level], &self->lamp, 0.4, q->nodes, &p, POINTS,
                                 self->s_float);
    } else {
        air_area_eval_lobes_float(self->contexts[level], &self->lamp, &q->lobe, &p, POINTS,
                                  self->s_float);
    }
}

/* ns per point. A level gets its time in one piece, after a while in which the clock may settle. */
static double time_level(course *self, int level, const question *q, bool floats)
{
    const int repeats = level == 0 ? 1 : REPEATS;
    double start = 0.0;
    for (int i = level == 0 ? 0 : -SETTLE; i < repeats; i++) {
        start = i == 0 ? seconds() : start;
        if (floats) {
            ask_float(self, level, q);
        } else {
            ask(self, level, q);
        }
    }
    return 1e9 * (seconds() - start) / ((double)POINTS * repeats);
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(course *self, const question *q, bool floats)
{
    static const char *const levels[LEVELS] = {"C", "SSE4.2", "AVX2", "AVX-512"};
    double taken[LEVELS][ROUNDS], ratio[LEVELS][ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        for (int level = 0; level < LEVELS; level++) {
            if (self->contexts[level] != NULL) {
                taken[level][i] = time_level(self, level, q, floats);
                ratio[level][i] = taken[0][i] / taken[level][i];
            }
        }
    }
    for (int level = 0; level < LEVELS; level++) {
        if (self->contexts[level] != NULL) {
            double *t = taken[level], *r = ratio[level];
            qsort(t, ROUNDS, sizeof *t, compare_doubles);
            qsort(r, ROUNDS, sizeof *r, compare_doubles);
            printf("%-7s %-6s %-8s %7.1f (%.1f to %.1f)   %6.1f (%.1f to %.1f)\n", q->name,
                   floats ? "float" : "double", levels[level], t[ROUNDS / 2], t[ROUNDS / 4],
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
    self->lamp = make_lamp();
    printf("ns per point, median (quartiles); times as fast as C, median (range)\n");
    for (int order = 0; order < 2; order++) {
        make_points(self, order == 0);
        printf("%s\n", order == 0 ? "points and directions at random" : "neighbours alike");
        for (int i = 0; i < CASES; i++) {
            measure(self, &questions[i], false);
            measure(self, &questions[i], true);
        }
    }
    for (int level = 0; level < LEVELS; level++) {
        air_context_destroy(self->contexts[level]);
    }
    free(self);
    return EXIT_SUCCESS;
}
