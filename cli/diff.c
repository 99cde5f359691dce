#include <airlight/image.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"
#include "output.h"

typedef struct diff_options {
    const char *variance_a, *variance_b, *mask, *false_colour;
    cli_count block, degrees_of_freedom, view;
    cli_real exposure, scale;
    cli_list fail_above, fail_below;
    bool json;
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
        "new.exr\n",
    .argument_min = 2,
    .argument_max = 2,
};

/* ---- what is printed ---- */

typedef enum value_group { VALUE_METRIC, VALUE_ZTEST } value_group;

/* Everything printed, under the name by which --fail-above knows it. */
typedef enum value_index {
    VALUE_MEAN_A,
    VALUE_MEAN_B,
    VALUE_BIAS,
    VALUE_RMSE,
    VALUE_RELATIVE_RMSE,
    VALUE_REL_MSE,
    VALUE_PSNR,
    VALUE_FLIP,
    VALUE_HDR_FLIP,
    VALUE_PIXELS,
    VALUE_TESTS,
    VALUE_MIN_P,
    VALUE_SIDAK_P,
    VALUE_MEAN_Z,
    VALUE_MEAN_P,
    VALUE_CHI_SQUARE_P,
    VALUE_BEYOND_95,
    VALUE_UNTESTED,
    VALUE_COUNT
} value_index;

static const struct {
    const char *name;
    value_group group;
    const char *meaning;
} value_names[VALUE_COUNT] = {
    [VALUE_MEAN_A] = {"mean-a", VALUE_METRIC, "mean of A"},
    [VALUE_MEAN_B] = {"mean-b", VALUE_METRIC, "mean of B"},
    [VALUE_BIAS] = {"bias", VALUE_METRIC, "(mean A - mean B) / mean B"},
    [VALUE_RMSE] = {"rmse", VALUE_METRIC, "root of the mean squared difference"},
    [VALUE_RELATIVE_RMSE] = {"relative-rmse", VALUE_METRIC, "RMSE / mean B"},
    [VALUE_REL_MSE] = {"rel-mse", VALUE_METRIC, "mean of (A-B)^2 / (B^2 + 1e-4 mean B^2)"},
    [VALUE_PSNR] = {"psnr", VALUE_METRIC, "dB, peak = largest of B"},
    [VALUE_FLIP] = {"flip", VALUE_METRIC, "LDR-FLIP after the view transform, mean"},
    [VALUE_HDR_FLIP] = {"hdr-flip", VALUE_METRIC, "HDR-FLIP, mean"},
    [VALUE_PIXELS] = {"pixels", VALUE_METRIC, "pixels compared"},
    [VALUE_TESTS] = {"tests", VALUE_ZTEST, "Z-tests made"},
    [VALUE_MIN_P] = {"min-p", VALUE_ZTEST, "smallest p-value of one test"},
    [VALUE_SIDAK_P] = {"sidak-p", VALUE_ZTEST, "the same, corrected for their number"},
    [VALUE_MEAN_Z] = {"mean-z", VALUE_ZTEST, "standard errors between the image means"},
    [VALUE_MEAN_P] = {"mean-p", VALUE_ZTEST, "p-value of that"},
    [VALUE_CHI_SQUARE_P] = {"chi-square-p", VALUE_ZTEST, "p-value of all tests together"},
    [VALUE_BEYOND_95] = {"beyond-95", VALUE_ZTEST, "share of tests outside their 95 % interval"},
    [VALUE_UNTESTED] = {"untested", VALUE_ZTEST, "blocks that differ without any variance"},
};

typedef struct diff_values {
    double value[VALUE_COUNT];
    bool tested; /* VALUE_ZTEST is there too */
} diff_values;

static void keep_metrics(const air_metrics *metrics, diff_values *out)
{
    out->value[VALUE_MEAN_A] = metrics->mean_a;
    out->value[VALUE_MEAN_B] = metrics->mean_b;
    out->value[VALUE_BIAS] = metrics->bias;
    out->value[VALUE_RMSE] = metrics->rmse;
    out->value[VALUE_RELATIVE_RMSE] = metrics->relative_rmse;
    out->value[VALUE_REL_MSE] = metrics->rel_mse;
    out->value[VALUE_PSNR] = metrics->psnr;
    out->value[VALUE_FLIP] = metrics->flip;
    out->value[VALUE_HDR_FLIP] = metrics->hdr_flip;
    out->value[VALUE_PIXELS] = (double)metrics->pixel_count;
}

static void keep_ztest(const air_ztest *test, diff_values *out)
{
    out->tested = true;
    out->value[VALUE_TESTS] = (double)test->test_count;
    out->value[VALUE_MIN_P] = test->min_p;
    out->value[VALUE_SIDAK_P] = test->sidak_p;
    out->value[VALUE_MEAN_Z] = test->mean_z;
    out->value[VALUE_MEAN_P] = test->mean_p;
    out->value[VALUE_CHI_SQUARE_P] = test->chi_square_p;
    out->value[VALUE_BEYOND_95] = test->fraction_beyond_95;
    out->value[VALUE_UNTESTED] = (double)test->differing_without_variance;
}

static bool printed(const diff_values *values, size_t index)
{
    return value_names[index].group == VALUE_METRIC || values->tested;
}

static void print_text(const diff_values *values)
{
    for (size_t i = 0; i < VALUE_COUNT; i++) {
        if (printed(values, i)) {
            printf("%-14s %-14.7g %s\n", value_names[i].name, values->value[i],
                   value_names[i].meaning);
        }
    }
}

static void print_json(const diff_values *values)
{
    json_t *const object = json_object();
    for (size_t i = 0; i < VALUE_COUNT; i++) {
        if (printed(values, i)) {
            /* JSON knows no infinity: null. */
            json_object_set_new(object, value_names[i].name,
                                isfinite(values->value[i]) ? json_real(values->value[i])
                                                           : json_null());
        }
    }
    json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(object);
}

/* ---- limits ---- */

typedef struct diff_limit {
    size_t index;
    double value;
} diff_limit;

static bool read_limit(const char *option, const char *text, diff_limit *out)
{
    char name[32];
    const char *names[VALUE_COUNT + 1] = {NULL};
    const size_t length = strcspn(text, "=");
    snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1),
             text);
    if (text[length] != '=' || !cli_read_real(text + length + 1, &out->value)) {
        cli_say(NULL, AIR_MESSAGE_ERROR, "--%s: expected METRIC=NUMBER, got \"%s\"", option, text);
        return false;
    }
    for (size_t i = 0; i < VALUE_COUNT; i++) {
        names[i] = value_names[i].name;
        if (strcmp(name, names[i]) == 0) {
            out->index = i;
            return true;
        }
    }
    const char *const nearest = cli_nearest(name, names);
    cli_say(NULL, AIR_MESSAGE_ERROR, "--%s: no metric is called \"%s\" (%s%s?)", option, name,
            nearest != NULL ? "did you mean " : "perhaps ",
            nearest != NULL ? nearest : "rmse, rel-mse, flip");
    return false;
}

static bool limits_readable(const diff_options *options)
{
    diff_limit limit;
    for (size_t i = 0; i < options->fail_above.count; i++) {
        if (!read_limit("fail-above", options->fail_above.items[i], &limit)) {
            return false;
        }
    }
    for (size_t i = 0; i < options->fail_below.count; i++) {
        if (!read_limit("fail-below", options->fail_below.items[i], &limit)) {
            return false;
        }
    }
    return true;
}

/* One limit; says so if it is broken. A value that is not a number breaks every limit. */
static bool holds(cli_host *host, const diff_values *values, const char *option, const char *text,
                  bool above)
{
    diff_limit limit;
    if (!read_limit(option, text, &limit)) {
        return false;
    }
    const char *const name = value_names[limit.index].name;
    if (!printed(values, limit.index)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "--%s %s: there is no Z-test without a variance", option, text);
        return false;
    }
    const double value = values->value[limit.index];
    if (above ? fabs(value) <= limit.value : value >= limit.value) {
        return true;
    }
    cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s is %.7g, %s the limit of %.7g", name, value,
            above ? "above" : "below", limit.value);
    return false;
}

static cli_exit check_limits(cli_host *host, const diff_options *options, const diff_values *values)
{
    bool all = true;
    for (size_t i = 0; i < options->fail_above.count; i++) {
        all = holds(host, values, "fail-above", options->fail_above.items[i], true) && all;
    }
    for (size_t i = 0; i < options->fail_below.count; i++) {
        all = holds(host, values, "fail-below", options->fail_below.items[i], false) && all;
    }
    return all ? CLI_OK : CLI_FAILED;
}

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

static cli_exit load_mask(cli_host *host, const char *path, diff_images *images)
{
    air_image *image = NULL;
    cli_exit result = load(host, path, &image);
    if (result != CLI_OK || image == NULL) {
        return result;
    }
    const size_t width = air_image_width(image), height = air_image_height(image);
    if (width != air_image_width(images->a) || height != air_image_height(images->a)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR,
                "%s: the mask is %zu x %zu pixels, expected the %zu x %zu of the images", path,
                width, height, air_image_width(images->a), air_image_height(images->a));
        result = CLI_FAILED;
    } else if ((images->mask = malloc(width * height)) == NULL) {
        result = cli_host_exit(host, AIR_ERROR_MEMORY, path);
    } else {
        const float *const plane = air_image_plane_const(image, 0);
        for (size_t i = 0; i < width * height; i++) {
            images->mask[i] = plane[i] != 0.0f;
        }
    }
    air_image_destroy(image);
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
    return result == CLI_OK ? load_mask(host, options->mask, images) : result;
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
                          diff_values *values)
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
        keep_ztest(&test, values);
    }
    return cli_host_exit(host, status, "the Z-test");
}

static cli_exit write_false_colour(cli_host *host, const diff_options *options,
                                   const diff_images *images, double rmse)
{
    air_image *difference = NULL, *picture = NULL;
    air_image_save_params params;
    double scale = options->scale.set ? options->scale.value : 3.0 * rmse;
    scale = scale > 0.0 && isfinite(scale) ? scale : 1.0;
    air_image_save_params_default(&params);
    params.auto_exposure = false;
    params.view = AIR_VIEW_STANDARD;
    air_status status = air_image_difference(host->context, images->a, images->b, &difference);
    if (status == AIR_OK) {
        status = air_image_false_colour(host->context, difference, (float)scale, &picture);
    }
    if (status == AIR_OK) {
        status = air_image_save(host->context, picture, options->false_colour, &params);
    }
    if (status == AIR_OK) {
        cli_report(&host->progress, "wrote %s, full scale %.4g", options->false_colour, scale);
    }
    air_image_destroy(picture);
    air_image_destroy(difference);
    return cli_host_exit(host, status, options->false_colour);
}

static cli_exit compare(cli_host *host, const diff_options *options, diff_images *images)
{
    air_metrics_params params;
    air_metrics metrics;
    diff_values values = {.tested = false};
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
    keep_metrics(&metrics, &values);
    if (options->false_colour != NULL) {
        result = write_false_colour(host, options, images, metrics.rmse);
    }
    if (result == CLI_OK) {
        result = run_ztest(host, options, images, &values);
    }
    if (result != CLI_OK) {
        return result;
    }
    if (options->json) {
        print_json(&values);
    } else {
        print_text(&values);
    }
    return check_limits(host, options, &values);
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
    if (!limits_readable(&options)) {
        return CLI_USAGE;
    }
    cli_exit result = cli_host_open(&host, &host_options);
    if (result == CLI_OK && options.false_colour != NULL) {
        const cli_list paths = {.count = 1, .items = {options.false_colour}};
        result = cli_output_check(&host, &paths, picture_extensions);
    }
    if (result == CLI_OK) {
        result = load_all(&host, &options, argv, &images);
    }
    if (result == CLI_OK) {
        result = compare(&host, &options, &images);
    }
    free_all(&images);
    cli_host_close(&host);
    return result;
}
