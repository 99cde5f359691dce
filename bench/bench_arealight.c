/* A lamp over a floor in haze (scene A, area_scene_a.h): error and time of every way to integrate,
 * in 15 settings, beside published figures; Volume-RIS for the time of the paper's method and of
 * the default.
 *
 * bench_arealight [--csv FILE]: FILE gets error and time of many more settings (arealight_plot.py).
 * Fails if the reference is off, or a figure misses what the specification's section 12 accepts. */
#include <stdio.h>
#include <time.h>

#include "area_ris.h"
#include "area_scene_a.h"
#include "core/host.h"

#ifndef AIR_SHARED_DIR
#define AIR_SHARED_DIR "../shared"
#endif

enum { ROUNDS = 3, METHODS = 6 };

typedef struct method {
    const char *name;
    scene_plan plan;
    double accepted; /* times the published error; 0: all */
    double figures[SETTINGS];
} method;

/* relMSE by setting: g from -0.95 to 0.9, sigma_s 0.05, 0.2, 1 for each. */
static const method methods[METHODS] = {
    {"LTSD, shortest way, 8 equal steps",
     {SCATTER_LTSD, 0, true, false, AIR_AREA_RIEMANN, 8},
     0.0,
     {2.8e-2, 4.4e-2, .26, 1.7e-2, 3.6e-2, .46, 1.7e-2, 4.2e-2, .50, 1.8e-2, 3.3e-2, .51, 1.5e-2,
      2.3e-2, .21}},
    {"the same, 500 steps",
     {SCATTER_LTSD, 0, true, false, AIR_AREA_RIEMANN, 500},
     1.1,
     {1.7e-2, 3.3e-2, .23, 2.3e-3, 1.7e-2, .41, 6.9e-3, 2.8e-2, .48, 4.8e-3, 1.9e-2, .49, 1.4e-2,
      2.2e-2, .22}},
    {"MIX, 3 x 3 ways, 8 nodes",
     {SCATTER_MIX, 0, false, false, AIR_AREA_EQUIANGULAR, 8},
     2.0,
     {3.0e-4, 1.9e-4, 2.9e-3, 7.3e-5, 2.9e-4, 1.4e-3, 6.9e-5, 8.4e-5, 4.1e-4, 2.5e-5, 3.7e-5,
      3.1e-4, 7.2e-4, 9.6e-4, 1.9e-3}},
    {"edges, 3 x 3 ways, 4 nodes",
     {SCATTER_EDGE, 6, false, false, AIR_AREA_EQUIANGULAR, 4},
     2.0,
     {9.7e-4, 5.7e-4, 8.1e-4, 5.4e-4, 6.0e-4, 1.2e-3, 6.4e-4, 6.8e-4, 1.2e-3, 2.8e-4, 2.7e-4,
      5.4e-4, 9.8e-5, 1.2e-4, 3.5e-4}},
    {"edges, 3 x 3 ways, 8 nodes",
     {SCATTER_EDGE, 6, false, false, AIR_AREA_EQUIANGULAR, 8},
     2.0,
     {9.5e-6, 2.7e-5, 4.0e-4, 3.3e-5, 5.6e-5, 4.4e-4, 6.9e-5, 8.4e-5, 4.1e-4, 2.5e-5, 3.7e-5,
      3.1e-4, 7.0e-7, 6.6e-6, 1.3e-4}},
    {"edges, 8 x 8 ways if near, 32 nodes",
     {SCATTER_EDGE, 8, false, true, AIR_AREA_EQUIANGULAR, 32},
     0.0,
     {2.6e-7, 3.5e-6, 6.6e-5, 2.7e-7, 2.8e-6, 5.5e-5, 3.7e-7, 2.6e-6, 4.5e-5, 2.0e-7, 2.1e-6,
      4.0e-5, 1.5e-7, 2.2e-6, 4.7e-5}},
};
enum { PAPER = 0, DEFAULT = 4 };

static double thread_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct picture {
    double air[SCENE_PIXELS], floor[SCENE_PIXELS];
} picture;

/* ---- the reference ---- */

typedef struct reference_work {
    const area_scene *scene;
    picture *out;
} reference_work;

/* The picture is the same left and right. */
static void reference_row(void *user, size_t row, size_t worker)
{
    const reference_work *work = user;
    (void)worker;
    for (int x = 0; x < SCENE_WIDTH / 2; x++) {
        const int pixel = (int)row * SCENE_WIDTH + x;
        const int mirrored = (int)row * SCENE_WIDTH + SCENE_WIDTH - 1 - x;
        double dir[3], length;
        const bool met = scene_ray(pixel, dir, &length);
        work->out->air[pixel] = work->out->air[mirrored] =
            scene_air_exact(work->scene, dir, length);
        work->out->floor[pixel] = work->out->floor[mirrored] =
            met ? scene_floor_exact(work->scene, dir, length) : 0.0;
    }
}

/* The largest relative difference to the published pixels of the setting; negative: no file. */
static double check_reference(const picture *reference, double g, double sigma)
{
    FILE *file = fopen(AIR_SHARED_DIR "/spec/data/area-lights/sceneA_ref.csv", "r");
    char line[256];
    double worst = -1.0;
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        double at_g, at_sigma, air, floor;
        int x, y;
        if (sscanf(line, "%lf,%lf,%d,%d,%lf,%lf", &at_g, &at_sigma, &x, &y, &air, &floor) == 6 &&
            at_g == g && at_sigma == sigma) {
            const int pixel = y * SCENE_WIDTH + x;
            worst = fmax(worst, fabs(reference->air[pixel] - air) / air);
            worst = fmax(worst, fabs(reference->floor[pixel] - floor) / (floor + 1e-30));
        }
    }
    if (file != NULL) {
        fclose(file);
    }
    return worst;
}

/* ---- pictures ---- */

static double render(const area_scene *scene, const scene_plan *plan, picture *out)
{
    const double start = thread_seconds();
    for (int pixel = 0; pixel < SCENE_PIXELS; pixel++) {
        double dir[3], length;
        const bool met = scene_ray(pixel, dir, &length);
        out->air[pixel] = scene_air(scene, plan, dir, length);
        out->floor[pixel] = met ? scene_floor(scene, plan, dir, length) : 0.0;
    }
    return thread_seconds() - start;
}

static double render_ris(const area_scene *scene, int candidates, picture *out)
{
    const double start = thread_seconds();
    for (int pixel = 0; pixel < SCENE_PIXELS; pixel++) {
        air_rng rng = air_rng_from_keys(7, (uint32_t)pixel);
        double dir[3], length;
        const bool met = scene_ray(pixel, dir, &length);
        out->air[pixel] = ris_air(scene, dir, length, candidates, &rng);
        out->floor[pixel] = met ? ris_floor(scene, dir, length, candidates, &rng) : 0.0;
    }
    return thread_seconds() - start;
}

typedef struct errors {
    double relmse, psnr;
} errors;

static errors compare(const picture *a, const picture *reference)
{
    double mean = 0.0, peak = 0.0, squares = 0.0, relative = 0.0;
    for (int i = 0; i < SCENE_PIXELS; i++) {
        const double r = reference->air[i] + reference->floor[i];
        mean += r / SCENE_PIXELS;
        peak = fmax(peak, r);
    }
    for (int i = 0; i < SCENE_PIXELS; i++) {
        const double r = reference->air[i] + reference->floor[i];
        const double d = a->air[i] + a->floor[i] - r;
        squares += d * d / SCENE_PIXELS;
        relative += d * d / (r * r + 1e-4 * mean * mean) / SCENE_PIXELS;
    }
    return (errors){relative, -10.0 * log10(squares / (peak * peak))};
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return values[count / 2];
}

/* ---- one setting ---- */

typedef struct result {
    errors errors[METHODS];
    double seconds[METHODS];
    errors paper;  /* the paper's method in the time of the default */
    errors ris[2]; /* in the time of the paper's method and of the default */
} result;

/* The paper's method with as many steps as the default has time for. */
static void measure_paper(const area_scene *scene, const picture *reference, result *out)
{
    picture *made = malloc(sizeof *made);
    scene_plan plan = methods[PAPER].plan;
    plan.nodes = (size_t)(8.0 * out->seconds[DEFAULT] / out->seconds[PAPER] + 0.5);
    const double seconds = render(scene, &plan, made);
    out->paper = compare(made, reference);
    printf(
        "  LTSD, shortest way, %2zu equal steps     relMSE %.2e           PSNR %4.1f  time %5.2f "
        "(the default's: %.2f)\n",
        plan.nodes, out->paper.relmse, out->paper.psnr, seconds / out->seconds[PAPER],
        out->seconds[DEFAULT] / out->seconds[PAPER]);
    free(made);
}

static errors measure_ris(const area_scene *scene, const picture *reference, double seconds,
                          int *out_candidates)
{
    picture *out = malloc(sizeof *out);
    double least = render_ris(scene, 32, out);
    int candidates = (int)fmax(1.0, 32.0 * seconds / least);
    (void)render_ris(scene, candidates, out);
    const errors found = compare(out, reference);
    *out_candidates = candidates;
    free(out);
    return found;
}

static bool measure(air_context *context, int setting, result *out)
{
    const double g = scene_g[setting / 3], sigma = scene_sigma[setting % 3];
    const area_scene scene = scene_make(g, sigma);
    picture *reference = malloc(sizeof *reference), *made = malloc(sizeof *made);
    bool good = true;
    reference_work work = {&scene, reference};
    air_parallel_for(context, SCENE_HEIGHT, reference_row, &work);
    const double off = check_reference(reference, g, sigma);
    good = off <= 2e-4; /* what is published claims no more */
    printf("g %5.2f, sigma_s %4.2f: reference off by at most %.1e\n", g, sigma, off);
    double seconds[METHODS][ROUNDS];
    for (int round = 0; round < ROUNDS; round++) {
        for (int m = 0; m < METHODS; m++) {
            seconds[m][round] = render(&scene, &methods[m].plan, made);
            out->errors[m] = compare(made, reference);
        }
    }
    for (int m = 0; m < METHODS; m++) {
        const double figure = methods[m].figures[setting];
        out->seconds[m] = median(seconds[m], ROUNDS);
        const bool accepted =
            methods[m].accepted == 0.0 || out->errors[m].relmse <= methods[m].accepted * figure;
        good = good && accepted;
        printf("  %-36s relMSE %.2e (%.1e)%s PSNR %4.1f  time %5.2f\n", methods[m].name,
               out->errors[m].relmse, figure, accepted ? "" : " TOO MUCH", out->errors[m].psnr,
               out->seconds[m] / out->seconds[PAPER]);
    }
    measure_paper(&scene, reference, out);
    for (int i = 0; i < 2; i++) {
        int candidates;
        out->ris[i] =
            measure_ris(&scene, reference, out->seconds[i == 0 ? PAPER : DEFAULT], &candidates);
        printf("  Volume-RIS, %3d candidates              relMSE %.2e           PSNR %4.1f\n",
               candidates, out->ris[i].relmse, out->ris[i].psnr);
    }
    free(reference);
    free(made);
    return good;
}

/* ---- error over time ---- */

typedef struct curve {
    const char *name;
    scene_plan plan; /* nodes: to be set; 0 edge nodes and SCATTER_EDGE: samples, as path takes them
                      */
} curve;

static const curve curves[] = {
    {"ltsd, riemann (paper)", {SCATTER_LTSD, 0, true, false, AIR_AREA_RIEMANN, 0}},
    {"ltsd, equiangular", {SCATTER_LTSD, 0, false, false, AIR_AREA_EQUIANGULAR, 0}},
    {"mix, equiangular", {SCATTER_MIX, 0, false, false, AIR_AREA_EQUIANGULAR, 0}},
    {"edge, riemann", {SCATTER_EDGE, 6, false, true, AIR_AREA_RIEMANN, 0}},
    {"edge, gauss", {SCATTER_EDGE, 6, false, true, AIR_AREA_GAUSS, 0}},
    {"edge, optical", {SCATTER_EDGE, 6, false, true, AIR_AREA_OPTICAL, 0}},
    {"edge, equiangular", {SCATTER_EDGE, 6, false, true, AIR_AREA_EQUIANGULAR, 0}},
    {"path, equiangular samples", {SCATTER_EDGE, 0, false, false, AIR_AREA_EQUIANGULAR, 0}},
};

static double render_samples(const area_scene *scene, int samples, picture *out)
{
    const double start = thread_seconds();
    for (int pixel = 0; pixel < SCENE_PIXELS; pixel++) {
        air_rng rng = air_rng_from_keys(8, (uint32_t)pixel);
        double dir[3], length;
        const bool met = scene_ray(pixel, dir, &length);
        out->air[pixel] = path_air(scene, dir, length, samples, &rng);
        out->floor[pixel] = met ? ris_floor(scene, dir, length, samples, &rng) : 0.0;
    }
    return thread_seconds() - start;
}

/* Rows of method, g, sigma_s, nodes, relMSE and microseconds per pixel for arealight_plot.py. */
static bool write_csv(air_context *context, const char *path)
{
    static const int settings[3] = {3, 4, 13}; /* g -0.6 and 0.9 */
    FILE *file = fopen(path, "w");
    picture *reference = malloc(sizeof *reference), *made = malloc(sizeof *made);
    if (file == NULL) {
        fprintf(stderr, "bench_arealight: %s: cannot be written\n", path);
        return false;
    }
    fprintf(file, "method,g,sigma_s,nodes,relmse,us_per_pixel\n");
    for (int i = 0; i < 3; i++) {
        const double g = scene_g[settings[i] / 3], sigma = scene_sigma[settings[i] % 3];
        const area_scene scene = scene_make(g, sigma);
        reference_work work = {&scene, reference};
        air_parallel_for(context, SCENE_HEIGHT, reference_row, &work);
        for (size_t c = 0; c < sizeof curves / sizeof *curves; c++) {
            const bool samples =
                curves[c].plan.scatter == SCATTER_EDGE && curves[c].plan.edge_nodes == 0;
            for (int nodes = 2; nodes <= (samples ? 1024 : 128); nodes *= 2) {
                scene_plan plan = curves[c].plan;
                plan.nodes = (size_t)nodes;
                const double seconds =
                    samples ? render_samples(&scene, nodes, made) : render(&scene, &plan, made);
                fprintf(file, "\"%s\",%g,%g,%d,%.4e,%.4f\n", curves[c].name, g, sigma, nodes,
                        compare(made, reference).relmse, 1e6 * seconds / SCENE_PIXELS);
            }
        }
    }
    free(reference);
    free(made);
    return fclose(file) == 0;
}

int main(int argc, char **argv)
{
    air_context *context;
    result results[SETTINGS];
    double gains[SETTINGS], times[SETTINGS];
    bool good = true;
    const bool csv = argc == 3 && strcmp(argv[1], "--csv") == 0;
    if (argc > 1 && !csv) {
        fprintf(stderr, "usage: bench_arealight [--csv FILE]\n");
        return 2;
    }
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (air_context_create(NULL, &context) != AIR_OK) {
        return EXIT_FAILURE;
    }
    if (csv) {
        good = write_csv(context, argv[2]);
        air_context_destroy(context);
        return good ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    for (int i = 0; i < SETTINGS; i++) {
        good = measure(context, i, &results[i]) && good;
        gains[i] = results[i].paper.relmse / results[i].errors[DEFAULT].relmse;
        times[i] = results[i].seconds[DEFAULT] / results[i].seconds[PAPER];
    }
    const double middle = median(gains, SETTINGS);
    printf("edges, 3 x 3 ways, 8 nodes against the paper's in the same time: relMSE smaller %.0f "
           "times in the median (%.0f to %.0f); %.2f times the paper's time at 8 steps\n",
           middle, gains[0], gains[SETTINGS - 1], median(times, SETTINGS));
    air_context_destroy(context);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
