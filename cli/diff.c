#include <airlight/image.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "diff_temporal.h"
#include "diff_values.h"
#include "frames.h"
#include "host.h"
#include "output.h"

typedef struct diff_options {
    const char *variance_a, *variance_b, *mask, *false_colour;
    cli_count block, degrees_of_freedom, view;
    cli_real exposure, scale;
    cli_list fail_above, fail_below;
    const char *frames;
    bool temporal, json;
    cli_frames sequence; /* what frames says */
} diff_options;

static const char *const view_names[] = {"neutral", "standard", "raw", NULL};

static const cli_option diff_table[] = {
    {.name = "variance",
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(diff_options, variance_a),
     .help = "Variance of the means of A, as channels variance.R, ... or R, G, B: adds the Z-test. "
             "Not needed where A itself holds variance channels."},
    {.name = "variance-a",
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(diff_options, variance_a),
     .help = "The same as --variance."},
    {.name = "variance-b",
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(diff_options, variance_b),
     .help = "Likewise for B, which counts as exact without."},
    {.name = "block",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 65535,
     .offset = offsetof(diff_options, block),
     .help = "Average N x N pixels before each Z-test; default 8."},
    {.name = "dof",
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 1e9,
     .offset = offsetof(diff_options, degrees_of_freedom),
     .help = "Degrees of freedom of the variances: replicates - 1; default what the files say, "
             "else 15."},
    {.name = "mask",
     .kind = CLI_TEXT,
     .value = "FILE",
     .offset = offsetof(diff_options, mask),
     .help = "Count only pixels whose first channel in this image is not 0."},
    {.name = "exposure",
     .kind = CLI_REAL,
     .value = "auto|EV",
     .min = -40.0,
     .max = 40.0,
     .word = "auto",
     .offset = offsetof(diff_options, exposure),
     .help = "Exposure of the pictures FLIP compares; default auto, from B."},
    {.name = "view",
     .kind = CLI_CHOICE,
     .value = "VIEW",
     .choices = view_names,
     .offset = offsetof(diff_options, view),
     .help = "View transform of those pictures: neutral, standard or raw; default neutral."},
    {.name = "false-colour",
     .kind = CLI_TEXT,
     .value = "OUT.png",
     .offset = offsetof(diff_options, false_colour),
     .help = "Write |A - B| in false colours."},
    {.name = "scale",
     .kind = CLI_REAL,
     .value = "MAX",
     .min = 1e-30,
     .max = 1e30,
     .offset = offsetof(diff_options, scale),
     .help = "Difference that gets the last of the false colours; default 3 times the RMSE."},
    {.name = "fail-above",
     .kind = CLI_LIST,
     .value = "METRIC=VALUE",
     .offset = offsetof(diff_options, fail_above),
     .help = "Exit with 1 if the size of a metric, named as in the output, is above VALUE. "
             "Repeatable."},
    {.name = "fail-below",
     .kind = CLI_LIST,
     .value = "METRIC=VALUE",
     .offset = offsetof(diff_options, fail_below),
     .help = "Likewise below: for psnr and the p-values. Repeatable."},
    {.name = "temporal",
     .kind = CLI_FLAG,
     .offset = offsetof(diff_options, temporal),
     .help = "Compare how two sequences change from frame to frame: # in A and B stands for the "
             "number, --frames says which. Metrics are temporal-..., the false colours show the "
             "mean difference of the changes."},
    {.name = "frames",
     .kind = CLI_TEXT,
     .value = "A-B|A-B/STEP",
     .offset = offsetof(diff_options, frames),
     .help = "Frames of --temporal, at least three."},
    {.name = "json",
     .kind = CLI_FLAG,
     .offset = offsetof(diff_options, json),
     .help = "Print the metrics as a JSON object."},
};

static const cli_usage diff_usage = {
    .command = "diff",
    .arguments = "A B",
    .summary =
        "Compares two images of equal size and prints the metrics defined in docs/metrics.md; "
        "B is the reference. With variances it tests whether both have the same expectation.",
    .examples =
        "  airlight diff fast.exr truth.exr --false-colour difference.png\n"
        "  airlight diff new.exr old.exr --fail-above relative-rmse=0.02 --fail-above flip=0.01\n"
        "  airlight diff new.exr truth.exr --fail-below sidak-p=0.01   # variance channels in "
        "new.exr\n"
        "  airlight diff --temporal fast.####.exr truth.####.exr --frames 1-48\n",
    .argument_min = 2,
    .argument_max = 2,
};

/* ---- comparing ---- */

typedef struct diff_images {
    air_image *a, *b, *variance_a,
        *variance_b; /* the variances are NULL if not given as files of their own */
    uint8_t *mask;
} diff_images;

static cli_exit load(cli_host *host, const char *path, air_image **out_image)
{
    return path == NULL ? CLI_OK
                        : cli_host_exit(host, air_image_load(host->context, path, out_image), path);
}

/* The mask for an image like this one. */
static cli_exit load_mask(cli_host *host, const char *path, const air_image *like,
                          uint8_t **out_mask)
{
    air_image *image = NULL;
    uint8_t *mask = NULL;
    cli_exit result = load(host, path, &image);
    if (result != CLI_OK || image == NULL) {
        return result;
    }
    const size_t width = air_image_width(image), height = air_image_height(image);
    if (width != air_image_width(like) || height != air_image_height(like)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "%s: the mask is %zu x %zu pixels, expected the %zu x %zu of the images", path,
                width, height, air_image_width(like), air_image_height(like));
        result = CLI_FAILED;
    } else if ((mask = malloc(width * height)) == NULL) {
        result = cli_host_exit(host, AIR_ERROR_MEMORY, path);
    } else {
        const float *const plane = air_image_plane_const(image, 0);
        for (size_t i = 0; i < width * height; i++) {
            mask[i] = plane[i] != 0.0f;
        }
    }
    air_image_destroy(image);
    *out_mask = mask;
    return result;
}

static cli_exit load_all(cli_host *host, const diff_options *options, char *const *paths,
                         diff_images *images)
{
    cli_exit result = load(host, paths[0], &images->a);
    if (result == CLI_OK) {
        result = load(host, paths[1], &images->b);
    }
    if (result == CLI_OK) {
        result = load(host, options->variance_a, &images->variance_a);
    }
    if (result == CLI_OK) {
        result = load(host, options->variance_b, &images->variance_b);
    }
    return result == CLI_OK ? load_mask(host, options->mask, images->a, &images->mask) : result;
}

static void free_all(diff_images *images)
{
    air_image_destroy(images->a);
    air_image_destroy(images->b);
    air_image_destroy(images->variance_a);
    air_image_destroy(images->variance_b);
    free(images->mask);
}

/* The Z-test knows no masks: what is not counted becomes 0 everywhere, the same in A and B and
 * without variance. */
static void apply_mask(const uint8_t *mask, air_image *image)
{
    if (mask == NULL || image == NULL) {
        return;
    }
    const size_t pixels = air_image_width(image) * air_image_height(image);
    for (size_t c = 0; c < air_image_channel_count(image); c++) {
        float *const plane = air_image_plane(image, c);
        for (size_t i = 0; i < pixels; i++) {
            plane[i] = mask[i] != 0 ? plane[i] : 0.0f;
        }
    }
}

/* Degrees of freedom of a variance image, from the number of replicates it says it has; `otherwise`
 * if it does not say. */
static size_t degrees_of_freedom(const air_image *image, size_t otherwise)
{
    const char *const text =
        image != NULL ? air_image_attribute(image, "airlight:variance-replicates") : NULL;
    const unsigned long replicates = text != NULL ? strtoul(text, NULL, 10) : 0;
    return replicates >= 2 ? (size_t)replicates - 1 : otherwise;
}

static const air_image *variance_of(const air_image *file, const air_image *image)
{
    if (file != NULL) {
        return file;
    }
    return air_image_find_channel(image, "variance.R") >= 0 ? image : NULL;
}

static cli_exit run_ztest(cli_host *host, const diff_options *options, diff_images *images,
                          cli_diff_values *values)
{
    enum { DEFAULT_BLOCK = 8, DEFAULT_DEGREES = 15 };
    air_ztest test;
    const air_image *const variance_a = variance_of(images->variance_a, images->a);
    const air_image *const variance_b = variance_of(images->variance_b, images->b);
    if (variance_a == NULL && variance_b == NULL) {
        return CLI_OK;
    }
    size_t degrees = degrees_of_freedom(variance_a, DEFAULT_DEGREES);
    const size_t degrees_b = degrees_of_freedom(variance_b, degrees);
    degrees = variance_a == NULL || degrees_b < degrees ? degrees_b : degrees;
    if (options->degrees_of_freedom.set) {
        degrees = (size_t)options->degrees_of_freedom.value;
    }
    air_image *const all[] = {images->a, images->b, images->variance_a, images->variance_b};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        apply_mask(images->mask, all[i]);
    }
    const size_t block = options->block.set ? (size_t)options->block.value : DEFAULT_BLOCK;
    const air_status status = air_image_ztest(host->context, images->a, images->b, variance_a,
                                              variance_b, block, degrees, &test);
    if (status == AIR_OK) {
        cli_diff_keep_ztest(&test, values);
    }
    return cli_host_exit(host, status, "the Z-test");
}

static cli_exit write_false_colour(cli_host *host, const diff_options *options,
                                   const air_image *difference, double typical)
{
    air_image *picture = NULL;
    air_image_save_params params;
    double scale = options->scale.set ? options->scale.value : 3.0 * typical;
    scale = scale > 0.0 && isfinite(scale) ? scale : 1.0;
    air_image_save_params_default(&params);
    params.auto_exposure = false;
    params.view = AIR_VIEW_STANDARD;
    air_status status = air_image_false_colour(host->context, difference, (float)scale, &picture);
    if (status == AIR_OK) {
        status = air_image_save(host->context, picture, options->false_colour, &params);
    }
    if (status == AIR_OK) {
        cli_report(&host->progress, "wrote %s, full scale %.4g", options->false_colour, scale);
    }
    air_image_destroy(picture);
    return cli_host_exit(host, status, options->false_colour);
}

static cli_exit compare(cli_host *host, const diff_options *options, diff_images *images)
{
    air_metrics_params params;
    air_metrics metrics;
    cli_diff_values values = {0};
    air_metrics_params_default(&params);
    params.auto_exposure = !options->exposure.set || options->exposure.word;
    params.exposure_ev = (float)options->exposure.value;
    params.view = (air_view)options->view.value;
    params.mask = images->mask;
    cli_exit result = cli_host_exit(
        host, air_image_compare(host->context, images->a, images->b, &params, &metrics),
        "comparing");
    if (result != CLI_OK) {
        return result;
    }
    cli_diff_keep_metrics(&metrics, &values);
    if (options->false_colour != NULL) {
        air_image *difference = NULL;
        result = cli_host_exit(
            host, air_image_difference(host->context, images->a, images->b, &difference),
            options->false_colour);
        if (result == CLI_OK) {
            result = write_false_colour(host, options, difference, metrics.rmse);
        }
        air_image_destroy(difference);
    }
    if (result == CLI_OK) {
        result = run_ztest(host, options, images, &values);
    }
    if (result != CLI_OK) {
        return result;
    }
    cli_diff_print(&values, options->json);
    return cli_diff_check_limits(host, &options->fail_above, &options->fail_below, &values);
}

/* ---- sequences ---- */

static cli_exit compare_sequences(cli_host *host, const diff_options *options, char *const *paths)
{
    air_temporal *temporal = NULL;
    air_temporal_metrics metrics;
    air_image *difference = NULL;
    uint8_t *mask = NULL;
    cli_diff_values values = {0};
    cli_exit result = cli_diff_sequences(host, paths, &options->sequence, &temporal);
    if (result == CLI_OK) {
        result = cli_host_exit(host, air_temporal_difference(temporal, &difference), "comparing");
    }
    if (result == CLI_OK) {
        result = load_mask(host, options->mask, difference, &mask);
    }
    if (result == CLI_OK) {
        result = cli_host_exit(host, air_temporal_measure(temporal, mask, &metrics), "comparing");
    }
    if (result == CLI_OK && options->false_colour != NULL) {
        result = write_false_colour(host, options, difference, metrics.difference);
    }
    if (result == CLI_OK) {
        cli_diff_keep_temporal(&metrics, &values);
        cli_diff_print(&values, options->json);
        result = cli_diff_check_limits(host, &options->fail_above, &options->fail_below, &values);
    }
    free(mask);
    air_image_destroy(difference);
    air_temporal_destroy(temporal);
    return result;
}

/* ---- the command ---- */

static cli_exit usage_error(const char *text)
{
    cli_say(NULL, AIR_MESSAGE_ERROR, "%s", text);
    return CLI_USAGE;
}

/* What can be said against the options before a file is read. */
static cli_exit check_options(diff_options *options)
{
    if (!cli_diff_limits_readable(&options->fail_above, &options->fail_below)) {
        return CLI_USAGE;
    }
    if (options->temporal != (options->frames != NULL)) {
        return usage_error("--temporal and --frames: expected both or neither");
    }
    if (options->temporal && (options->variance_a != NULL || options->variance_b != NULL ||
                              options->block.set || options->degrees_of_freedom.set)) {
        return usage_error("--temporal: expected none of --variance, --variance-b, --block and "
                           "--dof with it: sequences have no Z-test");
    }
    const cli_exit result = cli_frames_read(options->frames, &options->sequence);
    if (result == CLI_OK && options->temporal && cli_frames_count(&options->sequence) < 3) {
        return usage_error("--frames: expected at least three frames: a variance of changes needs "
                           "two changes");
    }
    return result;
}

cli_exit cli_diff(int argc, char **argv)
{
    static const char *const picture_extensions[] = {".png", NULL};
    diff_options options = {0};
    cli_host_options host_options = {0};
    cli_host host = {0};
    diff_images images = {0};
    const cli_option_group groups[] = {
        {"Comparison", diff_table, sizeof diff_table / sizeof diff_table[0], &options},
        cli_host_group(&host_options),
    };
    const cli_parsed parsed =
        cli_parse(&diff_usage, groups, sizeof groups / sizeof groups[0], &argc, argv);
    if (parsed != CLI_PARSED) {
        return parsed == CLI_PARSED_HELP ? CLI_OK : CLI_USAGE;
    }
    cli_exit result = check_options(&options);
    if (result == CLI_OK) {
        result = cli_host_open(&host, &host_options);
    }
    if (result == CLI_OK && options.false_colour != NULL) {
        const cli_list paths = {.count = 1, .items = {options.false_colour}};
        result = cli_output_check(&host, &paths, picture_extensions);
    }
    if (result == CLI_OK && options.temporal) {
        result = compare_sequences(&host, &options, argv);
    } else if (result == CLI_OK) {
        result = load_all(&host, &options, argv, &images);
        result = result == CLI_OK ? compare(&host, &options, &images) : result;
    }
    free_all(&images);
    cli_host_close(&host);
    return result;
}
