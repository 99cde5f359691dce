/* Multiple scattering of light from infinity: the error of every way to draw distances in scene A
 * beside published figures, and what the mixture of two ways gains. */
#include "collimated_figures.h"

enum { SEEDS = 16 };

enum { WALK_SIZE = 64, WALK_PIXELS = WALK_SIZE * WALK_SIZE, REFERENCE_WALKS = 1500 };

/* Two estimates of every way to draw distances. */
typedef struct walk_kind {
    const char *name;
    air_collimated_distance distance;
    air_collimated_estimator as; /* a ratio estimator or a plain one */
    double figures[COLUMNS], paper;
} walk_kind;

static const walk_kind walk_kinds[] = {
    {"RM", AIR_COLLIMATED_DISTANCE_UNIFORM, AIR_COLLIMATED_RM, {12.35, 17.41, 24.27, 29.94}, 24.95},
    {"DS",
     AIR_COLLIMATED_DISTANCE_EXTINCTION,
     AIR_COLLIMATED_DS,
     {17.13, 22.97, 29.11, 35.06},
     25.43},
    {"REES",
     AIR_COLLIMATED_DISTANCE_UNIFORM,
     AIR_COLLIMATED_REES,
     {15.26, 22.41, 28.11, 34.11},
     25.31},
    {"REDS",
     AIR_COLLIMATED_DISTANCE_EXTINCTION,
     AIR_COLLIMATED_REDS,
     {18.20, 24.30, 30.12, 36.05},
     25.89},
    {"WVDS",
     AIR_COLLIMATED_DISTANCE_WHOLE_VOLUME,
     AIR_COLLIMATED_WVDS,
     {18.07, 23.95, 29.97, 35.85},
     25.90},
    {"mix", AIR_COLLIMATED_DISTANCE_MIXTURE, AIR_COLLIMATED_WVDS, {NONE, NONE, NONE, NONE}, NONE},
    {"REmix", AIR_COLLIMATED_DISTANCE_MIXTURE, AIR_COLLIMATED_REES, {NONE, NONE, NONE, NONE}, NONE},
};
enum { WALK_KINDS = sizeof walk_kinds / sizeof *walk_kinds };

/* The first number of a walk is given, the rest are random. */
typedef struct first_number {
    bool used;
    double u;
    air_rng rng;
} first_number;

static double first_then_random(void *user)
{
    first_number *self = user;
    const bool first = !self->used;
    self->used = true;
    return first ? self->u : random_unit(&self->rng);
}

typedef struct walk_work {
    const sphere_scene *scene;
    double *reference;                           /* pixels */
    double (*error)[WALK_KINDS][COLUMNS][SEEDS]; /* rows: squared */
    double (*mean)[WALK_KINDS];                  /* rows: sums at the most samples */
} walk_work;

static void reference_row(void *user, size_t row, size_t worker)
{
    const walk_work *work = user;
    sphere_scene scene = *work->scene;
    air_collimated_walk_params params = walk_in(&scene, 0.9);
    params.distance = AIR_COLLIMATED_DISTANCE_EXTINCTION;
    (void)worker;
    for (int x = 0; x < WALK_SIZE; x++) {
        const int pixel = (int)row * WALK_SIZE + x;
        first_number numbers = {.rng = air_rng_from_keys(900, (uint32_t)pixel)};
        air_collimated_sums sums = {0.0, 0.0, 0.0};
        double dir[3];
        scene_direction(&scene, pixel, dir);
        for (int n = 0; n < REFERENCE_WALKS; n++) {
            numbers.used = false;
            numbers.u = (n + random_unit(&numbers.rng)) / REFERENCE_WALKS;
            sums_add(&sums,
                     air_collimated_walk(&params, scene.eye, dir, first_then_random, &numbers));
        }
        work->reference[pixel] = sums_value(AIR_COLLIMATED_REDS, sums, REFERENCE_WALKS);
    }
}

/* What one pixel is off by, for every seed. */
static void walk_pixel(const walk_work *work, size_t row, int pixel, const double dir[3],
                       const air_collimated_walk_params *params, int kind)
{
    for (int i = 0; i < SEEDS * COLUMNS; i++) {
        const int column = i % COLUMNS, samples = column_samples[column];
        const uint32_t stream = (uint32_t)(kind * SEEDS * COLUMNS + i);
        air_rng rng = air_rng_from_keys(1u + stream, (uint32_t)pixel);
        air_collimated_sums sums = {0.0, 0.0, 0.0};
        for (int n = 0; n < samples; n++) {
            sums_add(&sums, air_collimated_walk(params, work->scene->eye, dir, next_number, &rng));
        }
        const double value = sums_value(walk_kinds[kind].as, sums, samples);
        const double error = value - work->reference[pixel];
        work->error[row][kind][column][i / COLUMNS] += error * error;
        work->mean[row][kind] += column + 1 == COLUMNS ? value / SEEDS : 0.0;
    }
}

static void walk_row(void *user, size_t row, size_t worker)
{
    const walk_work *work = user;
    sphere_scene scene = *work->scene;
    air_collimated_walk_params params = walk_in(&scene, 0.9);
    (void)worker;
    for (int x = 0; x < WALK_SIZE; x++) {
        const int pixel = (int)row * WALK_SIZE + x;
        double dir[3];
        scene_direction(&scene, pixel, dir);
        for (int k = 0; k < WALK_KINDS; k++) {
            params.distance = walk_kinds[k].distance;
            walk_pixel(work, row, pixel, dir, &params, k);
        }
    }
}

/* Of all seeds together, and how far seeds are apart: the standard deviation of one, in dB. */
static void print_walk_figure(const walk_work *work, int kind, int column, double peak)
{
    double mean = 0.0, square = 0.0;
    picture_error all = {0.0, peak};
    for (int seed = 0; seed < SEEDS; seed++) {
        picture_error one = {0.0, peak};
        for (int row = 0; row < WALK_SIZE; row++) {
            one.sum += work->error[row][kind][column][seed];
        }
        const double psnr = picture_psnr(one, WALK_SIZE);
        mean += psnr / SEEDS;
        square += psnr * psnr / SEEDS;
        all.sum += one.sum / SEEDS;
    }
    const double spread = sqrt(fmax(0.0, square - mean * mean) * SEEDS / (SEEDS - 1.0));
    (void)print_figure(picture_psnr(all, WALK_SIZE), walk_kinds[kind].figures[column]);
    printf(" +-%.2f", spread);
}

static void print_walk_table(const walk_work *work)
{
    double peak = 0.0, sum = 0.0;
    for (int i = 0; i < WALK_PIXELS; i++) {
        peak = fmax(peak, work->reference[i]);
        sum += work->reference[i];
    }
    printf(
        "Scene A, at most 8 events, albedo 0.9, independent: PSNR in dB of the mean squared error "
        "of %d seeds (published for one seed, difference) +- standard deviation of one "
        "seed\nreference: REDS, %d walks, first distance stratified: max %.3f (1.056), mean %.5f "
        "(0.35671)\n",
        SEEDS, REFERENCE_WALKS, peak, sum / WALK_PIXELS);
    for (int k = 0; k < WALK_KINDS; k++) {
        printf("%-5s", walk_kinds[k].name);
        double mean = 0.0;
        for (int c = 0; c < COLUMNS; c++) {
            print_walk_figure(work, k, c, peak);
        }
        for (int row = 0; row < WALK_SIZE; row++) {
            mean += work->mean[row][k];
        }
        printf("  mean %+.2f %%", 100.0 * (mean / sum - 1.0));
        if (walk_kinds[k].paper > 0.0) {
            printf("  paper at 4: %.2f", walk_kinds[k].paper);
        }
        printf("\n");
    }
}

static bool print_walks(air_context *context)
{
    const sphere_scene scene = scene_a(WALK_SIZE);
    walk_work work = {&scene, calloc(WALK_PIXELS, sizeof(double)),
                      calloc(WALK_SIZE, sizeof *work.error), calloc(WALK_SIZE, sizeof *work.mean)};
    const bool good = work.reference != NULL && work.error != NULL && work.mean != NULL;
    if (good) {
        air_parallel_for(context, WALK_SIZE, reference_row, &work);
        air_parallel_for(context, WALK_SIZE, walk_row, &work);
        print_walk_table(&work);
    }
    free(work.reference);
    free(work.error);
    free(work.mean);
    return good;
}

/* Of one walk: variances over the squared mean, for the plain and the ratio estimator; seconds. */
typedef struct walk_noise {
    double plain, ratio, seconds;
} walk_noise;

static walk_noise measure_noise(double sigma_t, air_collimated_distance distance)
{
    enum { SIZE = 16, WALKS = 256 };
    sphere_scene scene = scene_a(SIZE);
    scene.sigma_t = sigma_t;
    air_collimated_walk_params params = walk_in(&scene, 0.9);
    params.max_events = 64;
    params.roulette = 0.25;
    params.distance = distance;
    walk_noise out = {0.0, 0.0, 0.0};
    double mean = 0.0, pixels = 0.0;
    const double start = thread_seconds();
    for (int pixel = 0; pixel < SIZE * SIZE; pixel++) {
        double dir[3];
        scene_direction(&scene, pixel, dir);
        const moments m = walk_moments(&params, scene.eye, dir, WALKS, 40u + (uint32_t)pixel);
        if (m.sum[1] > 0.0) {
            const double plain = plain_of(&m).error, ratio = ratio_of(&m).error;
            out.plain += WALKS * plain * plain;
            out.ratio += WALKS * ratio * ratio;
            mean += m.sum[2];
            pixels += 1.0;
        }
    }
    out.seconds = (thread_seconds() - start) / (pixels * WALKS);
    out.plain *= pixels / (mean * mean);
    out.ratio *= pixels / (mean * mean);
    return out;
}

/* Does the mixture pay? Work is variance times time; times are the best of rounds in turn. */
static void print_mixture(void)
{
    static const double extinctions[3] = {1.0, 4.0, 16.0};
    static const char *const ways[AIR_COLLIMATED_DISTANCE_COUNT] = {"uniform", "extinction",
                                                                    "whole volume", "mixture"};
    enum { TURNS = 2 };
    printf("\nWays to draw distances, at most 64 events, roulette: noise of one walk over the mean "
           "(plain, ratio), time, work to equal error (extinction, plain = 1)\n");
    for (int s = 0; s < 3; s++) {
        walk_noise noise[AIR_COLLIMATED_DISTANCE_COUNT];
        for (int turn = 0; turn < TURNS; turn++) {
            for (int k = 1; k < AIR_COLLIMATED_DISTANCE_COUNT; k++) {
                const double before = turn > 0 ? noise[k].seconds : INFINITY;
                noise[k] = measure_noise(extinctions[s], (air_collimated_distance)k);
                noise[k].seconds = fmin(noise[k].seconds, before);
            }
        }
        const double unit = noise[AIR_COLLIMATED_DISTANCE_EXTINCTION].plain *
                            noise[AIR_COLLIMATED_DISTANCE_EXTINCTION].seconds;
        for (int k = 1; k < AIR_COLLIMATED_DISTANCE_COUNT; k++) {
            printf("sigma_t %4.1f  %-12s  %5.2f  %5.2f  %6.0f ns  work %5.2f  %5.2f\n",
                   extinctions[s], ways[k], sqrt(noise[k].plain), sqrt(noise[k].ratio),
                   1e9 * noise[k].seconds, noise[k].plain * noise[k].seconds / unit,
                   noise[k].ratio * noise[k].seconds / unit);
        }
    }
}

int main(void)
{
    air_context *context;
    if (air_context_create(NULL, &context) != AIR_OK) {
        return EXIT_FAILURE;
    }
    const bool good = print_walks(context);
    print_mixture();
    air_context_destroy(context);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
