#include "diff_values.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

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
    VALUE_TEMPORAL_VARIANCE_A,
    VALUE_TEMPORAL_VARIANCE_B,
    VALUE_TEMPORAL_RATIO,
    VALUE_TEMPORAL_RATIO_OF_MEANS,
    VALUE_TEMPORAL_DIFFERENCE,
    VALUE_TEMPORAL_PIXELS,
    VALUE_TEMPORAL_FRAMES,
    VALUE_COUNT
} value_index;

static const struct {
    const char *name;
    cli_diff_group group;
    const char *meaning;
} value_names[VALUE_COUNT] = {
    [VALUE_MEAN_A] = {"mean-a", CLI_DIFF_METRIC, "mean of A"},
    [VALUE_MEAN_B] = {"mean-b", CLI_DIFF_METRIC, "mean of B"},
    [VALUE_BIAS] = {"bias", CLI_DIFF_METRIC, "(mean A - mean B) / mean B"},
    [VALUE_RMSE] = {"rmse", CLI_DIFF_METRIC, "root of the mean squared difference"},
    [VALUE_RELATIVE_RMSE] = {"relative-rmse", CLI_DIFF_METRIC, "RMSE / mean B"},
    [VALUE_REL_MSE] = {"rel-mse", CLI_DIFF_METRIC, "mean of (A-B)^2 / (B^2 + 1e-4 mean B^2)"},
    [VALUE_PSNR] = {"psnr", CLI_DIFF_METRIC, "dB, peak = largest of B"},
    [VALUE_FLIP] = {"flip", CLI_DIFF_METRIC, "LDR-FLIP after the view transform, mean"},
    [VALUE_HDR_FLIP] = {"hdr-flip", CLI_DIFF_METRIC, "HDR-FLIP, mean"},
    [VALUE_PIXELS] = {"pixels", CLI_DIFF_METRIC, "pixels compared"},
    [VALUE_TESTS] = {"tests", CLI_DIFF_ZTEST, "Z-tests made"},
    [VALUE_MIN_P] = {"min-p", CLI_DIFF_ZTEST, "smallest p-value of one test"},
    [VALUE_SIDAK_P] = {"sidak-p", CLI_DIFF_ZTEST, "the same, corrected for their number"},
    [VALUE_MEAN_Z] = {"mean-z", CLI_DIFF_ZTEST, "standard errors between the image means"},
    [VALUE_MEAN_P] = {"mean-p", CLI_DIFF_ZTEST, "p-value of that"},
    [VALUE_CHI_SQUARE_P] = {"chi-square-p", CLI_DIFF_ZTEST, "p-value of all tests together"},
    [VALUE_BEYOND_95] = {"beyond-95", CLI_DIFF_ZTEST, "share of tests outside their 95 % interval"},
    [VALUE_UNTESTED] = {"untested", CLI_DIFF_ZTEST, "blocks that differ without any variance"},
    [VALUE_TEMPORAL_VARIANCE_A] = {"temporal-variance-a", CLI_DIFF_TEMPORAL,
                                   "variance of the changes from frame to frame of A, mean"},
    [VALUE_TEMPORAL_VARIANCE_B] = {"temporal-variance-b", CLI_DIFF_TEMPORAL, "the same of B"},
    [VALUE_TEMPORAL_RATIO] = {"temporal-ratio", CLI_DIFF_TEMPORAL,
                              "mean of (var A + f) / (var B + f), f = 1e-6 mean B^2"},
    [VALUE_TEMPORAL_RATIO_OF_MEANS] = {"temporal-ratio-of-means", CLI_DIFF_TEMPORAL,
                                       "mean var A / mean var B"},
    [VALUE_TEMPORAL_DIFFERENCE] = {"temporal-difference", CLI_DIFF_TEMPORAL,
                                   "mean of |change of A - change of B|"},
    [VALUE_TEMPORAL_PIXELS] = {"temporal-pixels", CLI_DIFF_TEMPORAL, "pixels compared"},
    [VALUE_TEMPORAL_FRAMES] = {"frames", CLI_DIFF_TEMPORAL, "frames compared"},
};

_Static_assert((int)VALUE_COUNT <= (int)CLI_DIFF_VALUES_MAX, "room for all values");

void cli_diff_keep_metrics(const air_metrics *metrics, cli_diff_values *out)
{
    out->present[CLI_DIFF_METRIC] = true;
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

void cli_diff_keep_ztest(const air_ztest *test, cli_diff_values *out)
{
    out->present[CLI_DIFF_ZTEST] = true;
    out->value[VALUE_TESTS] = (double)test->test_count;
    out->value[VALUE_MIN_P] = test->min_p;
    out->value[VALUE_SIDAK_P] = test->sidak_p;
    out->value[VALUE_MEAN_Z] = test->mean_z;
    out->value[VALUE_MEAN_P] = test->mean_p;
    out->value[VALUE_CHI_SQUARE_P] = test->chi_square_p;
    out->value[VALUE_BEYOND_95] = test->fraction_beyond_95;
    out->value[VALUE_UNTESTED] = (double)test->differing_without_variance;
}

void cli_diff_keep_temporal(const air_temporal_metrics *metrics, cli_diff_values *out)
{
    out->present[CLI_DIFF_TEMPORAL] = true;
    out->value[VALUE_TEMPORAL_VARIANCE_A] = metrics->variance_a;
    out->value[VALUE_TEMPORAL_VARIANCE_B] = metrics->variance_b;
    out->value[VALUE_TEMPORAL_RATIO] = metrics->ratio;
    out->value[VALUE_TEMPORAL_RATIO_OF_MEANS] = metrics->ratio_of_means;
    out->value[VALUE_TEMPORAL_DIFFERENCE] = metrics->difference;
    out->value[VALUE_TEMPORAL_PIXELS] = (double)metrics->pixel_count;
    out->value[VALUE_TEMPORAL_FRAMES] = (double)metrics->frame_count;
}

/* ---- printing ---- */

static bool printed(const cli_diff_values *values, size_t index)
{
    return values->present[value_names[index].group];
}

static void print_text(const cli_diff_values *values)
{
    int width = 14;
    for (size_t i = 0; i < VALUE_COUNT; i++) {
        const int length = (int)strlen(value_names[i].name);
        width = printed(values, i) && length >= width ? length + 1 : width;
    }
    for (size_t i = 0; i < VALUE_COUNT; i++) {
        if (printed(values, i)) {
            printf("%-*s %-14.7g %s\n", width, value_names[i].name, values->value[i],
                   value_names[i].meaning);
        }
    }
}

static void print_json(const cli_diff_values *values)
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

void cli_diff_print(const cli_diff_values *values, bool json)
{
    if (json) {
        print_json(values);
    } else {
        print_text(values);
    }
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

bool cli_diff_limits_readable(const cli_list *above, const cli_list *below)
{
    diff_limit limit;
    for (size_t i = 0; i < above->count; i++) {
        if (!read_limit("fail-above", above->items[i], &limit)) {
            return false;
        }
    }
    for (size_t i = 0; i < below->count; i++) {
        if (!read_limit("fail-below", below->items[i], &limit)) {
            return false;
        }
    }
    return true;
}

/* Why a value of the group is not there. */
static const char *absence(cli_diff_group group)
{
    switch (group) {
    case CLI_DIFF_ZTEST:
        return "there is no Z-test without a variance";
    case CLI_DIFF_TEMPORAL:
        return "expected --temporal with it";
    case CLI_DIFF_METRIC:
    case CLI_DIFF_GROUPS:
        break;
    }
    return "--temporal has no such metric";
}

/* One limit; says so if it is broken. A value that is not a number breaks every limit. */
static bool holds(cli_host *host, const cli_diff_values *values, const char *option,
                  const char *text, bool above)
{
    diff_limit limit;
    if (!read_limit(option, text, &limit)) {
        return false;
    }
    const char *const name = value_names[limit.index].name;
    if (!printed(values, limit.index)) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "--%s %s: %s", option, text,
                absence(value_names[limit.index].group));
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

cli_exit cli_diff_check_limits(cli_host *host, const cli_list *above, const cli_list *below,
                               const cli_diff_values *values)
{
    bool all = true;
    for (size_t i = 0; i < above->count; i++) {
        all = holds(host, values, "fail-above", above->items[i], true) && all;
    }
    for (size_t i = 0; i < below->count; i++) {
        all = holds(host, values, "fail-below", below->items[i], false) && all;
    }
    return all ? CLI_OK : CLI_FAILED;
}
