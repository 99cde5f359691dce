/* Profiles: what a ray through scene A's box costs by parts, what an estimator's sample costs, and
 * what stacks of cells cost, each as ns and as a ratio to making the box's profile and integral.
 *
 * All are timed in turn, round by round; printed are medians over the rounds and the range of the
 * ratio. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "airlight/collimated.h"

enum { SIDE = 64, RAYS = SIDE * SIDE, ROUNDS = 25, MOST_CELLS = 8, MOST_PIECES = 10 * MOST_CELLS };

/* The rays of a camera, row by row, and one profile to sample. */
typedef struct course {
    double origin[3], dir[RAYS][3], to_light[3];
    air_collimated_cell cells[MOST_CELLS + 1]; /* the box, then slabs of it */
    size_t slabs;
    air_collimated_piece pieces[MOST_PIECES];
    air_collimated_profile profile;
    air_collimated_estimator estimator;
} course;

typedef double step_fn(course *self, int i);

static double profile_step(course *self, int i)
{
    air_collimated_profile_make(&self->cells[0].medium, self->to_light, 1.0, self->origin,
                                self->dir[i], INFINITY, &self->profile);
    return air_collimated_integral(&self->profile);
}

static double interval_step(course *self, int i)
{
    air_interval stretch = {0.0, 0.0};
    (void)air_collimated_interval(&self->cells[0].medium, self->origin, self->dir[i], INFINITY,
                                  &stretch);
    return stretch.end;
}

static double cells_step(course *self, int i)
{
    air_collimated_profile_make_cells(self->cells + 1, self->slabs, self->to_light, self->origin,
                                      self->dir[i], INFINITY, &self->profile);
    return air_collimated_integral(&self->profile);
}

static double estimate_step(course *self, int i)
{
    const double u = (i + 0.5) / RAYS;
    return air_collimated_estimate(self->estimator, &self->profile, u).unoccluded;
}

static air_collimated_cell slab(double low, double high)
{
    const air_collimated_cell out = {.medium = {.plane_count = 6,
                                                .planes = {{1.0, 0.0, 0.0, 1.0},
                                                           {-1.0, 0.0, 0.0, 1.0},
                                                           {0.0, 1.0, 0.0, high},
                                                           {0.0, -1.0, 0.0, -low},
                                                           {0.0, 0.0, 1.0, 1.0},
                                                           {0.0, 0.0, -1.0, 1.0}}},
                                     .sigma_t = 1.0,
                                     .weight = 1.0};
    return out;
}

/* Looking at the box from outside; every ray meets it. */
static void set_up(course *self)
{
    const double light[3] = {-0.3, 0.6, -0.3}, eye[3] = {0.5, 1.0, 3.5};
    for (int k = 0; k < 3; k++) {
        self->to_light[k] = light[k] / sqrt(0.54);
        self->origin[k] = eye[k];
    }
    for (int i = 0; i < RAYS; i++) {
        const double x = 1.6 * (i % SIDE + 0.5) / SIDE - 0.8,
                     y = 0.8 - 1.6 * (i / SIDE + 0.5) / SIDE;
        const double to[3] = {x - eye[0], y - eye[1], -eye[2]};
        const double length = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
        for (int k = 0; k < 3; k++) {
            self->dir[i][k] = to[k] / length;
        }
    }
    self->cells[0] = slab(-1.0, 1.0);
    self->profile = (air_collimated_profile){.pieces = self->pieces, .capacity = MOST_PIECES};
}

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ns per step */
static double time_steps(course *self, step_fn *step)
{
    volatile double sink;
    double sum = 0.0;
    const double start = seconds();
    for (int i = 0; i < RAYS; i++) {
        sum += step(self, i);
    }
    const double taken = seconds() - start;
    sink = sum;
    (void)sink;
    return 1e9 * taken / RAYS;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void measure(course *self, const char *name, step_fn *step)
{
    double taken[ROUNDS], ratio[ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        const double base = time_steps(self, profile_step);
        (void)profile_step(self, RAYS / 2 + SIDE / 2); /* what estimators sample: two pieces */
        taken[i] = time_steps(self, step);
        ratio[i] = taken[i] / base;
    }
    qsort(taken, ROUNDS, sizeof *taken, compare_doubles);
    qsort(ratio, ROUNDS, sizeof *ratio, compare_doubles);
    printf("%-28s %8.1f   %6.3f (%.3f to %.3f)\n", name, taken[ROUNDS / 2], ratio[ROUNDS / 2],
           ratio[0], ratio[ROUNDS - 1]);
}

int main(void)
{
    static const char *const names[AIR_COLLIMATED_ESTIMATOR_COUNT] = {
        "RM, a sample", "DS, a sample", "WVDS, a sample", "REES, a sample", "REDS, a sample"};
    course *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return EXIT_FAILURE;
    }
    set_up(self);
    printf("ns per ray or sample; ratio to a box's profile and integral\n");
    measure(self, "box, profile and integral", profile_step);
    measure(self, "box, interval only", interval_step);
    for (int e = 0; e < AIR_COLLIMATED_ESTIMATOR_COUNT; e++) {
        self->estimator = (air_collimated_estimator)e;
        measure(self, names[e], estimate_step);
    }
    for (self->slabs = 1; self->slabs <= MOST_CELLS; self->slabs *= 2) {
        char name[32];
        for (size_t i = 0; i < self->slabs; i++) {
            const double step = 2.0 / (double)self->slabs;
            self->cells[1 + i] = slab(-1.0 + step * (double)i, -1.0 + step * (double)(i + 1));
        }
        snprintf(name, sizeof name, "box as %zu cells", self->slabs);
        measure(self, name, cells_step);
    }
    free(self);
    return EXIT_SUCCESS;
}
