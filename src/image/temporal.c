/* temporal.c: how a sequence changes from frame to frame, against another (docs/metrics.md). */
#include "airlight/temporal.h"

#include <math.h>
#include <string.h>

#include "image/image.h"

/* Changes by a thousandth of the mean, below what eight bits show of middle grey (1/255), are added
 * on both sides of a pixel's ratio: of two pixels that both stand still it then is 1. */
static const double change_floor = 1e-3;

/* One channel of one pixel: the frame before, and running means and sums of squares of the changes
 * [Welford1962]. */
typedef struct trace {
    float a, b;
    double mean_a, squares_a, mean_b, squares_b;
    double sum_b;
    double difference; /* sum of |dA - dB| */
} trace;

struct air_temporal {
    air_context *context;
    size_t width, height, frame_count;
    trace *traces; /* 3 per pixel; NULL before the first frame */
};

air_status air_temporal_create(air_context *context, air_temporal **out_temporal)
{
    if (out_temporal == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "temporal: a pointer given is NULL");
    }
    *out_temporal = NULL;
    air_temporal *const temporal = air_allocate(context, 1, sizeof *temporal);
    if (temporal == NULL) {
        return air_fail_memory(context, "temporal");
    }
    temporal->context = context;
    *out_temporal = temporal;
    return AIR_OK;
}

void air_temporal_destroy(air_temporal *temporal)
{
    if (temporal != NULL) {
        air_free(temporal->context, temporal->traces);
        air_free(temporal->context, temporal);
    }
}

/* ---- taking in frames ---- */

static air_status check_image(const air_temporal *temporal, const char *name,
                              const air_image *image, size_t width, size_t height,
                              const float *out_planes[3])
{
    size_t first = 0;
    if (image->width != width || image->height != height) {
        return air_fail(temporal->context, AIR_ERROR_ARGUMENT,
                        "temporal: image %s is %zu x %zu, expected %zu x %zu", name, image->width,
                        image->height, width, height);
    }
    if (!air_image_colour(image, out_planes)) {
        return air_fail(temporal->context, AIR_ERROR_ARGUMENT,
                        "temporal: image %s has neither the channels R,G,B nor Y", name);
    }
    const size_t bad = air_image_count_not_finite(out_planes, width * height, &first);
    if (bad > 0) {
        return air_fail(temporal->context, AIR_ERROR_FORMAT,
                        "temporal: image %s has %zu pixels that are not finite, the first at "
                        "(%zu,%zu)",
                        name, bad, first % width, first / width);
    }
    return AIR_OK;
}

static void take(trace *at, float a, float b, size_t change_count)
{
    if (change_count > 0) {
        const double n = (double)change_count;
        const double change_a = (double)a - (double)at->a, change_b = (double)b - (double)at->b;
        const double off_a = change_a - at->mean_a, off_b = change_b - at->mean_b;
        at->mean_a += off_a / n;
        at->mean_b += off_b / n;
        at->squares_a += off_a * (change_a - at->mean_a);
        at->squares_b += off_b * (change_b - at->mean_b);
        at->difference += fabs(change_a - change_b);
    }
    at->a = a;
    at->b = b;
    at->sum_b += (double)b;
}

air_status air_temporal_add(air_temporal *temporal, const air_image *a, const air_image *b)
{
    const float *planes_a[3], *planes_b[3];
    if (temporal == NULL || a == NULL || b == NULL) {
        return AIR_ERROR_ARGUMENT;
    }
    const bool first = temporal->frame_count == 0;
    const size_t width = first ? a->width : temporal->width;
    const size_t height = first ? a->height : temporal->height;
    air_status status = check_image(temporal, "A", a, width, height, planes_a);
    if (status == AIR_OK) {
        status = check_image(temporal, "B", b, width, height, planes_b);
    }
    if (status != AIR_OK) {
        return status;
    }
    if (first) {
        temporal->traces = air_allocate(temporal->context, 3 * width * height, sizeof(trace));
        if (temporal->traces == NULL) {
            return air_fail_memory(temporal->context, "temporal");
        }
        temporal->width = width;
        temporal->height = height;
    }
    for (size_t i = 0; i < width * height; i++) {
        for (size_t k = 0; k < 3; k++) {
            take(&temporal->traces[3 * i + k], planes_a[k][i], planes_b[k][i],
                 temporal->frame_count);
        }
    }
    temporal->frame_count++;
    return AIR_OK;
}

/* ---- measuring ---- */

/* 0/0 is 0: no flicker relative to none. */
static double ratio(double numerator, double denominator)
{
    return numerator == 0.0 ? 0.0 : numerator / denominator;
}

/* Sample variances of a pixel, the mean over its channels. */
static void pixel_variances(const air_temporal *temporal, size_t pixel, double *out_a,
                            double *out_b)
{
    const double divisor = 3.0 * (double)(temporal->frame_count - 2);
    *out_a = *out_b = 0.0;
    for (size_t k = 0; k < 3; k++) {
        *out_a += temporal->traces[3 * pixel + k].squares_a / divisor;
        *out_b += temporal->traces[3 * pixel + k].squares_b / divisor;
    }
}

static bool counted(const uint8_t *mask, size_t pixel) { return mask == NULL || mask[pixel] != 0; }

static void sum_up(const air_temporal *temporal, const uint8_t *mask, air_temporal_metrics *out)
{
    double variance_a, variance_b;
    for (size_t i = 0; i < temporal->width * temporal->height; i++) {
        if (counted(mask, i)) {
            pixel_variances(temporal, i, &variance_a, &variance_b);
            out->variance_a += variance_a;
            out->variance_b += variance_b;
            for (size_t k = 0; k < 3; k++) {
                out->mean_b += temporal->traces[3 * i + k].sum_b;
                out->difference += temporal->traces[3 * i + k].difference;
            }
            out->pixel_count++;
        }
    }
    const double n = (double)out->pixel_count;
    out->variance_a = ratio(out->variance_a, n);
    out->variance_b = ratio(out->variance_b, n);
    out->mean_b = ratio(out->mean_b, 3.0 * n * (double)temporal->frame_count);
    out->difference = ratio(out->difference, 3.0 * n * (double)(temporal->frame_count - 1));
    out->ratio_of_means = ratio(out->variance_a, out->variance_b);
}

air_status air_temporal_measure(const air_temporal *temporal, const uint8_t *mask,
                                air_temporal_metrics *out_metrics)
{
    if (temporal == NULL || out_metrics == NULL) {
        return AIR_ERROR_ARGUMENT;
    }
    if (temporal->frame_count < 3) {
        return air_fail(
            temporal->context, AIR_ERROR_ARGUMENT,
            "temporal: %zu frames, expected at least 3: a variance of changes needs two "
            "changes",
            temporal->frame_count);
    }
    air_temporal_metrics metrics = {.frame_count = temporal->frame_count};
    sum_up(temporal, mask, &metrics);
    if (metrics.pixel_count == 0) {
        return air_fail(temporal->context, AIR_ERROR_ARGUMENT,
                        "temporal: the mask selects no pixel");
    }
    const double least_change = change_floor * metrics.mean_b;
    const double least = least_change * least_change;
    for (size_t i = 0; i < temporal->width * temporal->height; i++) {
        double variance_a, variance_b;
        if (counted(mask, i)) {
            pixel_variances(temporal, i, &variance_a, &variance_b);
            metrics.ratio += ratio(variance_a + least, variance_b + least);
        }
    }
    metrics.ratio /= (double)metrics.pixel_count;
    *out_metrics = metrics;
    return AIR_OK;
}

air_status air_temporal_difference(const air_temporal *temporal, air_image **out_image)
{
    static const char *const names[3] = {"R", "G", "B"};
    if (temporal == NULL || out_image == NULL) {
        return AIR_ERROR_ARGUMENT;
    }
    *out_image = NULL;
    if (temporal->frame_count < 2) {
        return air_fail(temporal->context, AIR_ERROR_ARGUMENT,
                        "temporal: %zu frames, expected at least 2", temporal->frame_count);
    }
    air_image *image = NULL;
    const air_status status =
        air_image_create(temporal->context, temporal->width, temporal->height, 3, names, &image);
    if (status != AIR_OK) {
        return status;
    }
    const double changes = (double)(temporal->frame_count - 1);
    for (size_t k = 0; k < 3; k++) {
        float *const plane = air_image_plane(image, k);
        for (size_t i = 0; i < temporal->width * temporal->height; i++) {
            plane[i] = (float)(temporal->traces[3 * i + k].difference / changes);
        }
    }
    *out_image = image;
    return AIR_OK;
}
