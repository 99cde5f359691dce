/* bench_bake.c: what each treatment of media costs in a bake, and how far it is from the truth.
 *
 *     bench_bake                              all situations of bake_situations.h
 *     bench_bake SCENE [WITH.json] [options]  a scene from a file
 *
 * --spp N (default 256), --reference N (samples of the reference, default 4096; 0: times only),
 * --texels D (per metre), --mesh-size N (texels of the meshes' own coordinates), --bounces N,
 * --threads N (default 1), --rounds N (default 3; medians and spread are printed), --situation K
 * (may be given several times), --denoise: all but the reference, --cache: instead of all modes
 * `exact` by the resolution of its cached light.
 *
 * All modes run in turn in one process on the same texels with the same samples, without denoising
 * unless asked for.
 * Errors are of the media layer and of all light: mean |difference| to the reference over its mean,
 * and bias. The reference has noise of its own, which is part of the error printed; the mode
 * `reference` shows how much there is. */
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
    uint32_t situations; /* a bit for each */
    bool cache, denoise;
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

static const char *const media_names[3] = {"media.R", "media.G", "media.B"};
static const char *const all_names[3] = {"R", "G", "B"};

static void add_page(const air_image *a, const air_image *b, const char *const names[3],
                     double sums[4])
{
    const size_t texels = air_image_width(a) * air_image_height(a);
    const ptrdiff_t coverage = air_image_find_channel(a, "coverage.Y");
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

static difference compare(const air_lightmap *a, const air_lightmap *b, const char *const names[3])
{
    double sums[4] = {0.0};
    for (size_t p = 0; p < a->page_count; p++) {
        add_page(a->pages[p], b->pages[p], names, sums);
    }
    return (difference){sums[0] / sums[2], sums[1] / sums[2], sums[2] / sums[3]};
}

/* ---- baking ---- */

static air_lightmap *bake(air_context *context, const air_snapshot *snapshot,
                          const bench_options *options, const mode *m, uint32_t samples,
                          uint64_t seed, uint32_t cache_resolution, air_bake_report *report)
{
    air_bake_params params;
    air_lightmap *lightmap = NULL;
    air_bake_params_default(&params);
    params.samples = samples;
    params.seed = seed;
    params.media = m->media;
    params.impulse_literal = m->literal;
    params.cache_resolution = cache_resolution;
    params.texels_per_metre = options->texels_per_metre;
    params.mesh_size = options->mesh_size;
    params.page_size = options->mesh_size > 0 ? options->mesh_size : params.page_size;
    params.padding = options->mesh_size > 0 ? 0 : params.padding;
    params.max_bounces = options->bounces;
    params.denoise = options->denoise && samples != options->reference;
    params.stitch = false;
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
            lightmaps[i] = bake(context, snapshot, options, &modes[i], options->spp, 3, 0, &report);
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
    difference media[MODES] = {{0.0, 0.0, 0.0}}, all[MODES] = {{0.0, 0.0, 0.0}};
    time_modes(context, snapshot, options, times, lightmaps);
    if (options->reference > 0) {
        truth = bake(context, snapshot, options, &modes[5], options->reference, 1, 0, &report);
        for (int i = 0; i < MODES; i++) {
            media[i] = compare(lightmaps[i], truth, media_names);
            all[i] = compare(lightmaps[i], truth, all_names);
        }
    }
    printf("%s: %u samples, %zu rounds; reference of %u, mean %.4g, of it media %.4g\n", name,
           options->spp, options->rounds, options->reference, all[0].mean, media[0].mean);
    printf("  %-10s %9s %9s %9s %9s %9s %9s %9s %9s\n", "mode", "sampling", "prepare", "over att.",
           "spread", "media", "bias", "all", "bias");
    for (int i = 0; i < MODES; i++) {
        printf("  %-10s %7.2f s %7.2f s %+8.1f%% %8.1f%% %8.2f%% %+8.2f%% %8.2f%% %+8.2f%%\n",
               modes[i].name, median(times[i].sample_s, options->rounds), times[i].prepare_s,
               median(times[i].ratio, options->rounds) - 100.0,
               spread(times[i].ratio, options->rounds), 100.0 * media[i].error,
               100.0 * media[i].bias, 100.0 * all[i].error, 100.0 * all[i].bias);
        air_lightmap_destroy(lightmaps[i]);
    }
    if (options->reference > 0) {
        const double exact_s = median(times[4].sample_s, options->rounds) + times[4].prepare_s;
        printf("  the reference takes %.0f times as long for the error of exact\n",
               pow(media[5].error / media[4].error, 2.0) *
                   median(times[5].sample_s, options->rounds) / exact_s);
    }
    fflush(stdout);
    air_lightmap_destroy(truth);
}

/* One scene: `exact` by the resolution of its cached light. */
static void run_cache(air_context *context, const air_snapshot *snapshot,
                      const bench_options *options, const char *name)
{
    static const uint32_t resolutions[] = {4, 8, 16, 32, 64};
    air_bake_report report;
    air_lightmap *truth =
        bake(context, snapshot, options, &modes[5], options->reference, 1, 0, &report);
    printf("%s: %u samples, reference of %u\n", name, options->spp, options->reference);
    printf("  %-10s %9s %9s %9s %9s\n", "resolution", "cached", "bytes", "media", "bias");
    for (size_t i = 0; i < sizeof resolutions / sizeof resolutions[0]; i++) {
        air_lightmap *lightmap =
            bake(context, snapshot, options, &modes[4], options->spp, 3, resolutions[i], &report);
        const difference media = compare(lightmap, truth, media_names);
        printf("  %-10u %7.2f s %6.2f MB %8.2f%% %+8.2f%%\n", resolutions[i], report.cache_s,
               1e-6 * (double)report.cache_bytes, 100.0 * media.error, 100.0 * media.bias);
        fflush(stdout);
        air_lightmap_destroy(lightmap);
    }
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
        (own.cache ? run_cache : run)(context, snapshot, &own, s->name);
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
        (options->cache ? run_cache : run)(context, snapshot, options, options->scene);
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
                       .rounds = 3};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "0";
        if (argv[i][0] != '-') {
            *(o.scene == NULL ? &o.scene : &o.with) = argv[i];
            continue;
        }
        if (strcmp(argv[i], "--cache") == 0 || strcmp(argv[i], "--denoise") == 0) {
            *(argv[i][2] == 'c' ? &o.cache : &o.denoise) = true;
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
            o.situations |= 1u << (number & 31);
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
        if (options.situations == 0 || options.situations >> i & 1) {
            failed |= run_situation(context, &options, &situations[i]);
        }
    }
    air_context_destroy(context);
    return failed;
}
