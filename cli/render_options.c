#include "render_options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* More pixels than this in one picture are taken for a mistake. */
static const uint64_t pixel_max = (uint64_t)1 << 28;

static const uint32_t unlimited = UINT32_MAX;

/* A multiple of 16 that no --time reaches, and that leaves room behind --samples. */
static const uint32_t endless_spp = (uint32_t)1 << 30;

enum { DEFAULT_WIDTH = 960, DEFAULT_REPLICATES = 16, SAMPLE_BLOCK = 16 };

static const char *const quality_names[] = {"interactive", "draft", "medium", "high", NULL};
enum { QUALITY_MEDIUM = 2 };

/* What --quality stands for, and of method ordinates: the numbers that are not the library's
 * defaults; bands 0: by the media. */
typedef struct quality {
    uint32_t spp, max_depth;
    const char *method;
    uint32_t cells, directions, patches, sweeps, steps, march;
    int bands;
} quality;

static const quality qualities[] = {
    {4, UINT32_MAX, "interactive", 20, 128, 16, 24, 20, 1, 0},
    {16, 8, "auto", 24, 128, 32, 16, 24, 2, 0},
    {64, 32, "auto", 32, 128, 64, 64, 32, 2, 7},
    {512, UINT32_MAX, "auto", 48, 256, 256, 256, 48, 2, 8},
};

/* In the order of air_term, air_filter and air_pattern. */
static const char *const term_names[] = {"S0", "S+", "M1", "M2", "emission", "background", NULL};
static const char *const filter_names[] = {"box", "point", "tent", "gaussian", "mitchell", NULL};
static const char *const rule_names[] = {"riemann", "gauss", "optical", "equiangular", NULL};
static const char *const pattern_names[] = {"independent", "stratified", "systematic", "blue-noise",
                                            NULL};

static const cli_option sampling_options[] = {
    {.name = "quality",
     .kind = CLI_CHOICE,
     .value = "LEVEL",
     .choices = quality_names,
     .offset = offsetof(cli_render_options, quality),
     .help = "interactive (4 samples per pixel, any number of events, method interactive), draft "
             "(16, 8), "
             "medium (64, 32) or high (512, unlimited); default medium. --spp, --samples, --time, "
             "--max-depth, --method and the options of method ordinates override it; without it "
             "a scene file that says how many samples has its way."},
    {.name = "spp",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 1073741824.0,
     .offset = offsetof(cli_render_options, spp),
     .help = "Samples per pixel."},
    {.name = "samples",
     .kind = CLI_COUNTS,
     .value = "A:B",
     .expected = "A:B, two sample numbers with A < B",
     .max = 4294967295.0,
     .length = 2,
     .separator = ':',
     .offset = offsetof(cli_render_options, samples),
     .help = "Only these samples of each pixel, from A up to B - 1; A is a multiple of 16. Films "
             "of several such runs merge to the bytes of one."},
    {.name = "time",
     .kind = CLI_REAL,
     .value = "SECONDS",
     .min = 1e-3,
     .max = 1e9,
     .offset = offsetof(cli_render_options, time),
     .help = "Stop after the pass in which this much time has gone. Without --spp the samples are "
             "unlimited."},
    {.name = "seed",
     .kind = CLI_COUNT,
     .value = "N",
     .max = 18446744073709551615.0,
     .offset = offsetof(cli_render_options, seed),
     .help = "Seed of the random numbers; default 0."},
    {.name = "max-depth",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 4294967295.0,
     .word = "unlimited",
     .offset = offsetof(cli_render_options, max_depth),
     .help = "Most events on a path, surfaces and media together; 1 is direct light and single "
             "scattering."},
    {.name = "pattern",
     .kind = CLI_CHOICE,
     .value = "PATTERN",
     .choices = pattern_names,
     .offset = offsetof(cli_render_options, pattern),
     .help = "Distances that collimated:rm to :reds draw: independent, stratified, systematic or "
             "blue-noise; default stratified."},
    {.name = "filter",
     .kind = CLI_CHOICE,
     .value = "FILTER",
     .choices = filter_names,
     .offset = offsetof(cli_render_options, filter),
     .help = "Pixel filter: box, point (rays through pixel centres), tent, gaussian (standard "
             "deviation a third of its radius 1.5) or mitchell; default the scene file's, or box."},
    {.name = "variance",
     .kind = CLI_COUNT,
     .value = "R",
     .min = 2,
     .max = 4096,
     .optional = true,
     .offset = offsetof(cli_render_options, variance),
     .help = "Also the variance of each pixel's mean, from R independent scramblings that share "
             "the samples; default R = 16. EXR files get channels variance.R, ..."},
    {.name = "tile-size",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 65535,
     .offset = offsetof(cli_render_options, tile_size),
     .help = "Pixels along a tile's edge; the result does not depend on it; default 32."},
};

static const cli_option light_options[] = {
    {.name = "method",
     .kind = CLI_TEXT,
     .value = "METHOD",
     .offset = offsetof(cli_render_options, method),
     .help = "auto, interactive, METHOD[:MODE], or LIGHT=METHOD[:MODE],...; default auto, with "
             "--quality interactive that. Methods: path; collimated (suns and beams in convex "
             "homogeneous media) with modes exact, rm, ds, wvds, rees, reds, me, me6, me-ideal, "
             "me6-ideal; arealight (lamps, media of constant density) with modes edge, mix, ltsd, "
             "volume-ris; ordinates (all light that media with an end scatter, in a grid, without "
             "noise) with modes dom, cm, six, literal, shdom. interactive: ordinates where light "
             "is scattered many times or density varies, else auto."},
    {.name = "quadrature",
     .kind = CLI_CHOICE,
     .value = "RULE",
     .choices = rule_names,
     .offset = offsetof(cli_render_options, rule),
     .help = "Of arealight along a ray: riemann (equal steps), gauss, optical (equal optical "
             "depth) or equiangular; default equiangular."},
    {.name = "nodes",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = AIR_AREA_MAX_NODES,
     .offset = offsetof(cli_render_options, nodes),
     .help = "Points of that rule on each stretch of a ray in a medium; default 8."},
    {.name = "area-table",
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(cli_render_options, area_table),
     .help =
         "Of arealight:ltsd or :mix: fitted lobes as `airlight table build` writes them; default "
         "the library's own."},
    {.name = "shadow-samples",
     .kind = CLI_COUNT,
     .value = "K",
     .max = AIR_AREA_MAX_DRAWS,
     .offset = offsetof(cli_render_options, shadow_samples),
     .help = "Of arealight: shadow rays for each sample and lamp; 0: nothing is in the way of "
             "lamps; default 1."},
    {.name = "candidates",
     .kind = CLI_COUNT,
     .value = "M",
     .min = 1,
     .max = AIR_AREA_MAX_DRAWS,
     .offset = offsetof(cli_render_options, candidates),
     .help = "Of arealight: samples from which each shadow ray is chosen; default 8."},
    {.name = "lightmap",
     .kind = CLI_TEXT,
     .value = "DIR",
     .offset = offsetof(cli_render_options, lightmap),
     .help = "Light on surfaces as `airlight bake -o DIR` has it, not traced: S0 is what it calls "
             "direct, S+ indirect and media. Give the media and environment that it was baked "
             "with: fog and sky are rendered as ever."},
    {.name = "terms",
     .kind = CLI_SET,
     .value = "LIST",
     .choices = term_names,
     .offset = offsetof(cli_render_options, terms),
     .help = "Only these parts of the light, with commas between: S0, S+, M1, M2, emission, "
             "background."},
    {.name = "layers",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_render_options, layers),
     .help = "Keep the terms apart: EXR files get one layer for each, S0.R, M1.R, ..., films can "
             "give them later."},
    {.name = "guides",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_render_options, guides),
     .help = "Keep albedo, normal and depth of the first surface likewise, for denoisers: "
             "albedo.R, normal.X, depth.Z."},
};

static const cli_option frame_options[] = {
    {.name = "camera",
     .kind = CLI_TEXT,
     .value = "NAME",
     .offset = offsetof(cli_render_options, camera),
     .help = "Camera by name or by index as airlight info counts them; default the first."},
    {.name = "width",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 65535,
     .offset = offsetof(cli_render_options, width),
     .help = "Pixels; one of width and height alone gives the other from the camera; none: as the "
             "scene "
             "file says, or 960 wide."},
    {.name = "height",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 65535,
     .offset = offsetof(cli_render_options, height),
     .help = "Pixels."},
    {.name = "crop",
     .kind = CLI_COUNTS,
     .value = "X0,Y0,X1,Y1",
     .expected = "X0,Y0,X1,Y1, four pixel numbers",
     .max = 65535,
     .length = 4,
     .separator = ',',
     .offset = offsetof(cli_render_options, crop),
     .help = "Only the pixels from X0, Y0 (from the top left) up to X1 - 1, Y1 - 1. The picture "
             "has the size of the crop; attributes tell its place."},
};

static const cli_option sequence_options[] = {
    {.name = "frames",
     .kind = CLI_TEXT,
     .value = "N|A-B|A-B/STEP",
     .offset = offsetof(cli_render_options, frames),
     .help = "Render these frames, each to a file of its own: in the names of outputs and of grids "
             "of media a run of # stands for the number, with zeros before it. All have the same "
             "seed; --time is for each."},
    {.name = "orbit",
     .kind = CLI_REAL,
     .value = "DEGREES",
     .min = -360.0,
     .max = 360.0,
     .offset = offsetof(cli_render_options, orbit),
     .help = "Turn the camera by so much a frame, counterclockwise from above, about the upright "
             "axis through the middle of the media, or of the scene where no medium has bounds. "
             "Frame 0 is seen as the file has it."},
    {.name = "no-warm-start",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_render_options, no_warm_start),
     .help = "Of ordinates: each frame begins from nothing, as if it were the only one, not from "
             "the frame before. Slower, and it may flicker; for parts of a sequence on several "
             "machines."},
};

static const cli_option report_options[] = {
    {.name = "write-partial",
     .kind = CLI_REAL,
     .value = "SECONDS",
     .min = 0.1,
     .max = 1e9,
     .offset = offsetof(cli_render_options, write_partial),
     .help = "Every so often write what there is to NAME.partial.EXT, removed at the end."},
    {.name = "stats",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_render_options, stats),
     .help = "Print where the time went, memory, and the image's mean to stderr."},
    {.name = "json",
     .kind = CLI_FLAG,
     .offset = offsetof(cli_render_options, json),
     .help = "Print the same as a JSON object on stdout; with --frames one a line, as soon as a "
             "frame is done."},
};

void cli_render_groups(cli_render_options *options, cli_option_group out_groups[CLI_RENDER_GROUPS])
{
    out_groups[0] = (cli_option_group){"Picture", frame_options,
                                       sizeof frame_options / sizeof frame_options[0], options};
    out_groups[1] =
        (cli_option_group){"Sampling", sampling_options,
                           sizeof sampling_options / sizeof sampling_options[0], options};
    out_groups[2] = (cli_option_group){"Light", light_options,
                                       sizeof light_options / sizeof light_options[0], options};
    out_groups[3] = cli_ordinates_group(&options->ordinates);
    out_groups[4] =
        (cli_option_group){"Sequence", sequence_options,
                           sizeof sequence_options / sizeof sequence_options[0], options};
    out_groups[5] = (cli_option_group){"Reports", report_options,
                                       sizeof report_options / sizeof report_options[0], options};
}

static const quality *quality_of(const cli_render_options *options)
{
    return &qualities[options->quality.set ? options->quality.value : QUALITY_MEDIUM];
}

static cli_exit usage_error(const char *text)
{
    cli_say(NULL, AIR_MESSAGE_ERROR, "%s", text);
    return CLI_USAGE;
}

/* Of *settings what the quality and the options say; the rest stays. */
static void set_ordinates(const cli_render_options *options, air_ordinates_settings *settings)
{
    const quality *const q = quality_of(options);
    settings->cells = q->cells;
    settings->directions = q->directions;
    settings->patches = q->patches;
    settings->sweeps = q->sweeps;
    settings->steps = q->steps;
    settings->march = q->march;
    settings->bands = q->bands;
    cli_ordinates_set(&options->ordinates, settings);
}

cli_exit cli_render_check(cli_render_options *options)
{
    const uint64_t *const samples = options->samples.value;
    if (options->samples.set && options->spp.set) {
        return usage_error("--spp and --samples: expected one of the two");
    }
    if (options->samples.set && (samples[0] >= samples[1] || samples[0] % SAMPLE_BLOCK != 0)) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "--samples: expected A:B with A < B and A a multiple of %d, got %llu:%llu",
                (int)SAMPLE_BLOCK, (unsigned long long)samples[0], (unsigned long long)samples[1]);
        return CLI_USAGE;
    }
    if (options->variance.set && options->time.set) {
        return usage_error(
            "--variance and --time: expected one of the two, a variance needs all its samples");
    }
    if (options->orbit.set && options->frames == NULL) {
        return usage_error("--orbit: expected --frames with it, to turn from frame to frame");
    }
    const cli_exit result = cli_ordinates_check(&options->ordinates, quality_of(options)->bands);
    return result == CLI_OK ? cli_frames_read(options->frames, &options->sequence) : result;
}

/* ---- samples ---- */

static uint32_t replicates_of(const cli_render_options *options)
{
    if (!options->variance.set) {
        return 0;
    }
    return options->variance.word ? DEFAULT_REPLICATES : (uint32_t)options->variance.value;
}

static cli_exit set_samples(cli_host *host, const cli_render_options *options,
                            const air_film_hint *film, air_render_params *params)
{
    const uint32_t replicates = replicates_of(options);
    const bool as_filed = film->known && !options->quality.set;
    uint32_t count = as_filed ? film->samples : quality_of(options)->spp;
    if (options->samples.set) {
        params->sample_begin = (uint32_t)options->samples.value[0];
        count = (uint32_t)(options->samples.value[1] - options->samples.value[0]);
    } else if (options->spp.set) {
        count = (uint32_t)options->spp.value;
    } else if (options->time.set) {
        count = endless_spp;
    }
    if (replicates != 0 && count % replicates != 0) {
        if (options->samples.set || options->spp.set) {
            cli_say(&host->progress, AIR_MESSAGE_ERROR,
                    "--variance: expected a multiple of %u samples, to share between as many "
                    "scramblings, got %u",
                    replicates, count);
            return CLI_USAGE;
        }
        count += replicates - count % replicates;
    }
    params->sample_end = params->sample_begin + count;
    params->variance_replicates = replicates;
    params->max_depth = quality_of(options)->max_depth;
    if (options->max_depth.set) {
        params->max_depth =
            options->max_depth.word ? unlimited : (uint32_t)options->max_depth.value;
    }
    return CLI_OK;
}

/* ---- size ---- */

static size_t clamp_size(double size)
{
    return size < 1.0 ? 1 : size > 65535.0 ? 65535 : (size_t)llround(size);
}

/* Of the raw sums: those of the film, and as much again of the pass under way. */
static double film_bytes_per_pixel(const cli_render_options *options)
{
    const double terms = options->layers ? (double)AIR_TERM_COUNT : 1.0;
    const double guides = options->guides ? 7.0 : 0.0;
    const double squares = options->variance.set ? 3.0 : 0.0;
    return 2.0 * sizeof(double) * (3.0 * terms + guides + squares);
}

/* What the scene file says holds where neither side is given: width and height, and the crop. */
static cli_exit set_size(cli_host *host, const cli_render_options *options,
                         const cli_camera *camera, air_render_params *params)
{
    const double aspect = camera->aspect;
    const bool as_filed = camera->film.known && !options->width.set && !options->height.set;
    size_t width = options->width.set ? (size_t)options->width.value : DEFAULT_WIDTH;
    size_t height = clamp_size((double)width / aspect);
    if (as_filed) {
        width = camera->film.width;
        height = camera->film.height;
    }
    if (options->height.set) {
        height = (size_t)options->height.value;
        width = options->width.set ? width : clamp_size((double)height * aspect);
    }
    if ((uint64_t)width * height > pixel_max) {
        const double bytes = (double)width * (double)height * film_bytes_per_pixel(options);
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "%zu x %zu pixels need at least %.0f bytes (%.1f GB) of memory: expected at most "
                "%llu pixels; render parts with smaller --width and --height",
                width, height, bytes, bytes * 1e-9, (unsigned long long)pixel_max);
        return CLI_USAGE;
    }
    params->width = width;
    params->height = height;
    const size_t whole[4] = {0, 0, width, height};
    memcpy(params->crop, as_filed ? camera->film.crop : whole, sizeof params->crop);
    return CLI_OK;
}

static cli_exit set_crop(cli_host *host, const cli_render_options *options,
                         air_render_params *params)
{
    const uint64_t *const crop = options->crop.value;
    if (!options->crop.set) {
        return CLI_OK;
    }
    if (crop[0] >= crop[2] || crop[1] >= crop[3] || crop[2] > params->width ||
        crop[3] > params->height) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "--crop: expected X0 < X1 <= %zu and Y0 < Y1 <= %zu, got %llu,%llu,%llu,%llu",
                params->width, params->height, (unsigned long long)crop[0],
                (unsigned long long)crop[1], (unsigned long long)crop[2],
                (unsigned long long)crop[3]);
        return CLI_USAGE;
    }
    for (size_t i = 0; i < 4; i++) {
        params->crop[i] = (size_t)crop[i];
    }
    return CLI_OK;
}

cli_exit cli_render_params(cli_host *host, const cli_render_options *options,
                           const cli_camera *camera, air_render_params *params)
{
    air_render_params_default(params);
    params->camera = camera->handle;
    params->seed = options->seed.value;
    params->filter = (air_filter)options->filter.value;
    params->filter_radius = air_filter_radius_default(params->filter);
    if (camera->film.known && !options->filter.set) {
        params->filter = camera->film.filter;
        params->filter_radius = camera->film.filter_radius;
    }
    if (options->pattern.set) {
        params->pattern = (air_pattern)options->pattern.value;
    }
    if (options->rule.set) {
        params->area_rule = (air_area_rule)options->rule.value;
    }
    if (options->nodes.set) {
        params->area_nodes = (uint32_t)options->nodes.value;
    }
    if (options->shadow_samples.set) {
        params->shadow_samples = (uint32_t)options->shadow_samples.value;
    }
    if (options->candidates.set) {
        params->shadow_candidates = (uint32_t)options->candidates.value;
    }
    params->methods = options->method != NULL ? options->method : quality_of(options)->method;
    set_ordinates(options, &params->ordinates);
    if (options->terms.set) {
        params->terms = (uint32_t)options->terms.value;
    }
    if (options->tile_size.set) {
        params->tile_size = (size_t)options->tile_size.value;
    }
    params->layers = options->layers;
    params->guides = options->guides;
    params->time_limit_s = options->time.set ? options->time.value : (double)INFINITY;
    cli_exit result = set_samples(host, options, &camera->film, params);
    if (result == CLI_OK) {
        result = set_size(host, options, camera, params);
    }
    return result == CLI_OK ? set_crop(host, options, params) : result;
}

void cli_render_term_list(uint32_t terms, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (size_t i = 0; i < AIR_TERM_COUNT && used < size; i++) {
        if ((terms >> i & 1) != 0) {
            used += (size_t)snprintf(out + used, size - used, "%s%s", used == 0 ? "" : ",",
                                     term_names[i]);
        }
    }
}

const char *cli_render_filter_name(air_filter filter) { return filter_names[filter]; }
