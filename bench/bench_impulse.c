/* Tables of impulse responses: time to build and load them, and ns for a look-up: from the tables,
 * from prepared responses one by one, and in batches of every instruction set of this machine.
 *
 * Processor time, the least of many rounds, versions in turn; beside it a calibration kernel of
 * this run, one multiplication and one addition that wait for each other. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "airlight/impulse.h"
#include "core/random.h"

enum { PLACES = 4096, ROUNDS = 60, SLOW_ROUNDS = 5, LEVELS = 4 };

typedef struct course {
    float distance[PLACES], n_l[PLACES], cos_s[PLACES], n_x[PLACES], out[3][PLACES];
    air_impulse_place places[PLACES];
    air_context *contexts[LEVELS]; /* NULL where the machine lacks the level */
    air_impulse_tables *tables;
} course;

static const char *const emitter_names[AIR_IMPULSE_EMITTERS] = {"point", "directional", "area"};

static double seconds(clockid_t id)
{
    struct timespec now;
    (void)clock_gettime(id, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void make_places(course *self)
{
    air_rng rng = air_rng_from_keys(4, 2);
    for (int i = 0; i < PLACES; i++) {
        double x[4];
        for (int k = 0; k < 4; k++) {
            x[k] = air_rng_next(&rng) * 0x1p-32;
        }
        const double z = 2.0 * x[0] - 1.0;
        self->places[i] = (air_impulse_place){.distance = 0.1 + 10.0 * x[1],
                                              .n_l = z,
                                              .cos_s = 2.0 * x[2] - 1.0,
                                              .n_x = sqrt(1.0 - z * z) * (2.0 * x[3] - 1.0)};
        self->distance[i] = (float)self->places[i].distance;
        self->n_l[i] = (float)z;
        self->cos_s[i] = (float)self->places[i].cos_s;
        self->n_x[i] = (float)self->places[i].n_x;
    }
}

static double calibrate(void)
{
    double least = INFINITY;
    volatile double start = 0.7;
    for (int round = 0; round < ROUNDS; round++) {
        double x = start;
        const double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
        for (int i = 0; i < PLACES; i++) {
            x = x * 0.5 + 1.0;
        }
        least = fmin(least, seconds(CLOCK_PROCESS_CPUTIME_ID) - before);
        start = x - 1.3;
    }
    return 1e9 * least / PLACES;
}

/* ns per place of the tables themselves (way 0), of single questions (1), of batches (2). */
static double time_way(course *self, const air_impulse_response *response,
                       air_impulse_emitter emitter, const air_impulse_medium *medium, int way)
{
    const air_impulse_places places = {self->distance, self->n_l, self->cos_s, self->n_x};
    float *const outs[3] = {self->out[0], self->out[1], self->out[2]};
    double least = INFINITY;
    for (int round = 0; round < (way == 0 ? SLOW_ROUNDS : ROUNDS); round++) {
        const double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
        for (int i = 0; i < PLACES && way == 0; i++) {
            self->out[0][i] =
                (float)air_impulse_irradiance(self->tables, emitter, medium, &self->places[i]);
        }
        for (int i = 0; i < PLACES && way == 1; i++) {
            const air_impulse_place_float place = {self->distance[i], self->n_l[i], self->cos_s[i],
                                                   self->n_x[i]};
            air_impulse_response_irradiance(response, &place, &self->out[0][i]);
        }
        if (way == 2) {
            air_impulse_response_batch(response, &places, PLACES, outs);
        }
        least = fmin(least, seconds(CLOCK_PROCESS_CPUTIME_ID) - before);
    }
    return 1e9 * least / PLACES;
}

static void look_ups(course *self)
{
    static const char *const levels[LEVELS] = {"C", "SSE4.2", "AVX2", "AVX-512"};
    const air_impulse_medium media[3] = {{.sigma_s = 0.3, .sigma_t = 0.3, .bounces = 10},
                                         {.sigma_s = 0.2, .sigma_t = 0.3, .bounces = 10},
                                         {.sigma_s = 0.1, .sigma_t = 0.3, .bounces = 10}};
    for (int e = 0; e < AIR_IMPULSE_EMITTERS; e++) {
        const air_impulse_emitter emitter = (air_impulse_emitter)e;
        printf("%s: tables, 10 bounces %.0f ns", emitter_names[e],
               time_way(self, NULL, emitter, media, 0));
        for (int level = 0; level < LEVELS; level++) {
            air_impulse_response *one = NULL, *three = NULL;
            air_context *const context = self->contexts[level];
            if (context != NULL &&
                air_impulse_response_create(context, self->tables, emitter, media, 1, &one) ==
                    AIR_OK &&
                air_impulse_response_create(context, self->tables, emitter, media, 3, &three) ==
                    AIR_OK) {
                if (level == 0) {
                    printf("; response, one by one %.1f ns",
                           time_way(self, one, emitter, media, 1));
                }
                printf("; batch, %s %.1f ns, three channels %.1f ns", levels[level],
                       time_way(self, one, emitter, media, 2),
                       time_way(self, three, emitter, media, 2));
            }
            air_impulse_response_destroy(one);
            air_impulse_response_destroy(three);
        }
        printf("\n");
    }
}

/* False where there is no memory. */
static bool build(course *self, air_context *context)
{
    static const char *const names[2] = {"default", "the paper's"};
    for (int i = 0; i < 2; i++) {
        air_impulse_params params;
        air_impulse_tables *tables;
        if (i == 0) {
            air_impulse_params_default(&params);
        } else {
            air_impulse_params_paper(&params);
        }
        const double wall = seconds(CLOCK_MONOTONIC), before = seconds(CLOCK_PROCESS_CPUTIME_ID);
        if (air_impulse_tables_create(context, &params, &tables) != AIR_OK) {
            return false;
        }
        printf("tables, %s: %.2f s of processor time, %.2f s on %zu threads, %.1f MB\n", names[i],
               seconds(CLOCK_PROCESS_CPUTIME_ID) - before, seconds(CLOCK_MONOTONIC) - wall,
               air_context_thread_count(context), 1e-6 * (double)air_impulse_tables_bytes(tables));
        if (i == 0) {
            self->tables = tables;
        } else {
            air_impulse_tables_destroy(tables);
        }
    }
    return true;
}

static void file(const course *self, air_context *context)
{
    static const char path[] = "bench_impulse.impulse";
    air_impulse_tables *tables = NULL;
    if (air_impulse_tables_save(context, self->tables, path) != AIR_OK) {
        return;
    }
    const double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
    if (air_impulse_tables_load(context, path, &tables) == AIR_OK) {
        printf("loaded in %.3f s\n", seconds(CLOCK_PROCESS_CPUTIME_ID) - before);
    }
    air_impulse_tables_destroy(tables);
    (void)remove(path);
}

int main(void)
{
    static course self; /* 400 KB */
    air_context *context;
    make_places(&self);
    if (air_context_create(NULL, &context) != AIR_OK || !build(&self, context)) {
        return 1;
    }
    for (int level = 0; level < LEVELS; level++) {
        air_context_params params;
        air_context_params_default(&params);
        params.cpu = (air_cpu)(AIR_CPU_C + level);
        (void)air_context_create(&params, &self.contexts[level]);
    }
    file(&self, context);
    printf("calibration: %.2f ns\n", calibrate());
    look_ups(&self);
    air_impulse_tables_destroy(self.tables);
    for (int level = 0; level < LEVELS; level++) {
        air_context_destroy(self.contexts[level]);
    }
    air_context_destroy(context);
    return 0;
}
