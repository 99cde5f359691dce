/* bench_bake.c: what each treatment of media costs in a bake, and how far it is from the truth.
 *
 *     bench_bake                              four situations, and the table of them
 *     bench_bake SCENE [WITH.json] [options]  a scene from a file
 *
 * --spp N (default 256), --reference N (samples of the reference, default 4096; 0: times only),
 * --texels D (per metre), --mesh-size N (texels of the meshes' own coordinates), --bounces N,
 * --threads N (default 1), --rounds N (default 3; medians and spread are printed), --situation K.
 *
 * All modes run in turn in one process on the same texels with the same samples, without denoising.
 * Errors are of the media layer: mean |difference| to the reference over its mean, and bias. The
 * reference has noise of its own, which is part of the error printed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/airlight.h"
#include "bake_situations.h"

typedef struct bench_options {
    const char *scene, *with;
    uint32_t spp, reference, mesh_size, bounces;
    float texels_per_metre;
    size_t threads, rounds;
    int situation;
} bench_options;

typedef struct mode {
    const char *name;
    air_bake_media media;
    bool literal;
} mode;

static const mode modes[] = {
    {"none", AIR_BAKE_NONE, false},      {"attenuate", AIR_BAKE_ATTENUATE, false},
    {"literal", AIR_BAKE_IMPULSE, true}, {"impulse", AIR_BAKE_IMPULSE, false},
    {"exact", AIR_BAKE_EXACT, false},    {"reference", AIR_BAKE_REFERENCE, false},
};
enum { MODES = sizeof modes / sizeof modes[0], MOST_ROUNDS = 32 };

/* ---- comparing ---- */

typedef struct difference {
    double error, bias, mean;
} difference;

static void add_page(const air_image *a, const air_image *b, double sums[4])
{
    const size_t texels = air_image_width(a) * air_image_height(a);
    const ptrdiff_t coverage = air_image_find_channel(a, "coverage.Y");
    static const char *const names[3] = {"media.R", "media.G", "media.B"};
    const float *covered = air_image_plane_const(a, (size_t)coverage);
    for (int c = 0; c < 3; c++) {
        const float *x = air_image_plane_const(a, (size_t)air_image_find_channel(a, names[c]));
        const float *y = air_image_plane_const(b, (size_t)air_image_find_channel(b, names[c]));
        for (size_t i = 0; i < texels; i++) {
            if (covered[i] > 0.0f) {
                sums[0] += fabs((double)x[i] - (double)y[i]);
                sums[1] += (double)x[i] - (double)y[i];
                sums[2] += (double)y[i];
                sums[3] += 1.0;
            }
        }
    }
}

static difference compare(const air_lightmap *a, const air_lightmap *b)
{
    double sums[4] = {0.0};
    for (size_t p = 0; p < a->page_count; p++) {
        add_page(a->pages[p], b->pages[p], sums);
    }
    return (difference){sums[0] / sums[2], sums[1] / sums[2], sums[2] / sums[3]};
}

/* ---- baking ---- */

static air_lightmap *bake(air_context *context, const air_snapshot *snapshot,
                          const bench_options *options, const mode *m, uint32_t samples,
                          uint64_t seed, air_bake_report *report)
{
    air_bake_params params;
    air_lightmap *lightmap = NULL;
    air_bake_params_default(&params);
    params.samples = samples;
    params.seed = seed;
    params.media = m->media;
    params.impulse_literal = m->literal;
    params.texels_per_metre = options->texels_per_metre;
    params.mesh_size = options->mesh_size;
    params.page_size = options->mesh_size > 0 ? options->mesh_size : params.page_size;
    params.padding = options->mesh_size > 0 ? 0 : params.padding;
    params.max_bounces = options->bounces;
    params.denoise = params.stitch = false;
    if (air_bake(context, snapshot, &params, &lightmap, report) != AIR_OK) {
        fprintf(stderr, "bench_bake: %s\n", air_context_last_error(context));
        exit(1);
    }
    return lightmap;
}

typedef struct timing {
    double sample_s[MOST_ROUNDS], ratio[MOST_ROUNDS], prepare_s;
} timing;

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median(const double *values, size_t count)
{
    double sorted[MOST_ROUNDS];
    memcpy(sorted, values, count * sizeof *values);
    qsort(sorted, count, sizeof *sorted, by_size);
    return count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
}

static double spread(const double *values, size_t count)
{
    double low = values[0], high = values[0];
    for (size_t i = 1; i < count; i++) {
        low = fmin(low, values[i]);
        high = fmax(high, values[i]);
    }
    return high - low;
}

/* Every mode in turn, round after round; of each the lightmap of the last one stays. */
static void time_modes(air_context *context, const air_snapshot *snapshot,
                       const bench_options *options, timing times[MODES],
                       air_lightmap *lightmaps[MODES])
{
    air_bake_report report;
    for (size_t round = 0; round < options->rounds; round++) {
        for (int i = 0; i < MODES; i++) {
            air_lightmap_destroy(lightmaps[i]);
            lightmaps[i] = bake(context, snapshot, options, &modes[i], options->spp, 3, &report);
            times[i].sample_s[round] = report.sample_s;
            times[i].prepare_s = report.cache_s + report.first_s;
        }
        for (int i = 0; i < MODES; i++) {
            times[i].ratio[round] = 100.0 * (times[i].sample_s[round] / times[1].sample_s[round]);
        }
    }
}

/* One scene: a line for each mode. */
static void run(air_context *context, const air_snapshot *snapshot, const bench_options *options,
                const char *name)
{
    timing times[MODES];
    air_lightmap *lightmaps[MODES] = {NULL}, *truth = NULL;
    air_bake_report report;
    difference differences[MODES] = {{0.0, 0.0, 0.0}};
    time_modes(context, snapshot, options, times, lightmaps);
    if (options->reference > 0) {
        truth = bake(context, snapshot, options, &modes[5], options->reference, 1, &report);
        for (int i = 0; i < MODES; i++) {
            differences[i] = compare(lightmaps[i], truth);
        }
    }
    printf("%s: %u samples, %zu rounds; reference of %u, media mean %.4g\n", name, options->spp,
           options->rounds, options->reference, differences[0].mean);
    printf("  %-10s %9s %9s %9s %9s %9s %9s\n", "mode", "sampling", "prepare", "over att.",
           "spread", "error", "bias");
    for (int i = 0; i < MODES; i++) {
        printf("  %-10s %7.2f s %7.2f s %+8.1f%% %8.1f%% %8.2f%% %+8.2f%%\n", modes[i].name,
               median(times[i].sample_s, options->rounds), times[i].prepare_s,
               median(times[i].ratio, options->rounds) - 100.0,
               spread(times[i].ratio, options->rounds), 100.0 * differences[i].error,
               100.0 * differences[i].bias);
        air_lightmap_destroy(lightmaps[i]);
    }
    if (options->reference > 0) {
        const double exact_s = median(times[4].sample_s, options->rounds) + times[4].prepare_s;
        printf("  the reference takes %.0f times as long for the error of exact\n",
               pow(differences[5].error / differences[4].error, 2.0) *
                   median(times[5].sample_s, options->rounds) / exact_s);
    }
    fflush(stdout);
    air_lightmap_destroy(truth);
}

static int run_situation(air_context *context, const bench_options *options, const situation *s)
{
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    bench_options own = *options;
    own.texels_per_metre = s->texels_per_metre;
    air_status status = air_scene_create(context, &scene);
    status = status == AIR_OK ? s->make(scene) : status;
    status = status == AIR_OK ? air_scene_commit(scene, &snapshot, NULL) : status;
    if (status == AIR_OK) {
        run(context, snapshot, &own, s->name);
    } else {
        fprintf(stderr, "bench_bake: %s\n", air_context_last_error(context));
    }
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    return status == AIR_OK ? 0 : 1;
}

static int run_file(air_context *context, const bench_options *options)
{
    air_load_params load;
    air_scene *scene = NULL;
    air_snapshot *snapshot = NULL;
    air_load_params_default(&load);
    load.with = &options->with;
    load.with_count = options->with != NULL ? 1 : 0;
    air_status status = air_scene_load(context, options->scene, &load, &scene);
    status = status == AIR_OK ? air_scene_commit(scene, &snapshot, NULL) : status;
    if (status == AIR_OK) {
        run(context, snapshot, options, options->scene);
    } else {
        fprintf(stderr, "bench_bake: %s\n", air_context_last_error(context));
    }
    air_snapshot_release(snapshot);
    air_scene_destroy(scene);
    return status == AIR_OK ? 0 : 1;
}

static bench_options read_options(int argc, char **argv)
{
    bench_options o = {.spp = 256,
                       .reference = 4096,
                       .bounces = UINT32_MAX,
                       .texels_per_metre = 4.0f,
                       .threads = 1,
                       .rounds = 3,
                       .situation = -1};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "0";
        if (argv[i][0] != '-') {
            *(o.scene == NULL ? &o.scene : &o.with) = argv[i];
            continue;
        }
        const uint32_t number = (uint32_t)strtoul(value, NULL, 10);
        i++;
        if (strcmp(argv[i - 1], "--spp") == 0) {
            o.spp = number;
        } else if (strcmp(argv[i - 1], "--reference") == 0) {
            o.reference = number;
        } else if (strcmp(argv[i - 1], "--texels") == 0) {
            o.texels_per_metre = strtof(value, NULL);
        } else if (strcmp(argv[i - 1], "--mesh-size") == 0) {
            o.mesh_size = number;
        } else if (strcmp(argv[i - 1], "--bounces") == 0) {
            o.bounces = number;
        } else if (strcmp(argv[i - 1], "--threads") == 0) {
            o.threads = number;
        } else if (strcmp(argv[i - 1], "--rounds") == 0) {
            o.rounds = number < 1 ? 1 : number < MOST_ROUNDS ? number : MOST_ROUNDS;
        } else if (strcmp(argv[i - 1], "--situation") == 0) {
            o.situation = (int)number;
        }
    }
    return o;
}

int main(int argc, char **argv)
{
    const bench_options options = read_options(argc, argv);
    air_context_params params;
    air_context *context;
    int failed = 0;
    air_context_params_default(&params);
    params.thread_count = options.threads;
    if (air_context_create(&params, &context) != AIR_OK) {
        return 1;
    }
    if (options.scene != NULL) {
        failed = run_file(context, &options);
    }
    for (int i = 0; options.scene == NULL && i < SITUATIONS; i++) {
        if (options.situation < 0 || options.situation == i) {
            failed |= run_situation(context, &options, &situations[i]);
        }
    }
    air_context_destroy(context);
    return failed;
}
