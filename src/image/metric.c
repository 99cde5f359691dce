/* metric.c: the difference of two images as numbers (docs/metrics.md) and as an image. */
#include <math.h>
#include <string.h>

#include "image/flip.h"
#include "image/image.h"

void air_metrics_params_default(air_metrics_params *params)
{
    *params = (air_metrics_params){
        .auto_exposure = true,
        .view = AIR_VIEW_NEUTRAL,
        .pixels_per_degree = 67.0206f,
    };
}

/* Two images and what is looked at in them. */
typedef struct comparison {
    const float *a[3], *b[3];
    size_t width, height;
    const air_metrics_params *params;
    float exposure_ev;
} comparison;

static air_status check_pair(air_context *context, const air_image *a, const air_image *b,
                             const float *out_a[3], const float *out_b[3])
{
    if (a->width != b->width || a->height != b->height) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "compare: the images are %zu x %zu and %zu x %zu, expected equal sizes",
                        a->width, a->height, b->width, b->height);
    }
    const bool has_a = air_image_colour(a, out_a);
    if (!has_a || !air_image_colour(b, out_b)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "compare: image %s has neither the channels R,G,B nor Y",
                        has_a ? "B" : "A");
    }
    return AIR_OK;
}

static air_status check_finite(air_context *context, const char *name, const float *const planes[3],
                               size_t width, size_t count)
{
    size_t first = 0;
    const size_t bad = air_image_count_not_finite(planes, count, &first);
    if (bad > 0) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "compare: image %s has %zu pixels that are not finite, the first at "
                        "(%zu,%zu): (%g,%g,%g)",
                        name, bad, first % width, first / width, (double)planes[0][first],
                        (double)planes[1][first], (double)planes[2][first]);
    }
    return AIR_OK;
}

static air_status start(air_context *context, const air_image *a, const air_image *b,
                        const air_metrics_params *params, comparison *out)
{
    *out = (comparison){.width = a->width, .height = a->height, .params = params};
    const size_t count = a->width * a->height;
    if (!(params->pixels_per_degree >= 1.0f && params->pixels_per_degree <= 1000.0f)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "compare: pixels_per_degree is %g, must be 1 to 1000",
                        (double)params->pixels_per_degree);
    }
    air_status status = check_pair(context, a, b, out->a, out->b);
    if (status == AIR_OK) {
        status = check_finite(context, "A", out->a, out->width, count);
    }
    if (status == AIR_OK) {
        status = check_finite(context, "B", out->b, out->width, count);
    }
    if (status == AIR_OK) {
        out->exposure_ev = params->auto_exposure ? air_image_auto_exposure(b) : params->exposure_ev;
        if (!isfinite(out->exposure_ev)) {
            status = air_fail(context, AIR_ERROR_ARGUMENT, "compare: the exposure is not finite");
        }
    }
    return status;
}

static bool counted(const comparison *c, size_t i)
{
    return c->params->mask == NULL || c->params->mask[i] != 0;
}

/* 0/0 is 0: no error relative to nothing. */
static double ratio(double numerator, double denominator)
{
    return numerator == 0.0 ? 0.0 : numerator / denominator;
}

static void measure_differences(const comparison *c, air_metrics *out)
{
    const size_t count = c->width * c->height;
    double sum_a = 0.0;
    double sum_b = 0.0;
    double squares = 0.0;
    double peak = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (!counted(c, i)) {
            continue;
        }
        out->pixel_count++;
        for (size_t k = 0; k < 3; k++) {
            const double a = (double)c->a[k][i];
            const double b = (double)c->b[k][i];
            sum_a += a;
            sum_b += b;
            squares += (a - b) * (a - b);
            peak = fmax(peak, b);
        }
    }
    const double n = 3.0 * (double)out->pixel_count;
    out->mean_a = sum_a / n;
    out->mean_b = sum_b / n;
    out->bias = ratio(out->mean_a - out->mean_b, out->mean_b);
    out->rmse = sqrt(squares / n);
    out->relative_rmse = ratio(out->rmse, out->mean_b);
    out->psnr = squares > 0.0 ? -10.0 * log10(squares / n / (peak * peak)) : (double)INFINITY;

    double relative = 0.0;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < 3 && counted(c, i); k++) {
            const double b = (double)c->b[k][i];
            const double d = (double)c->a[k][i] - b;
            relative += ratio(d * d, b * b + 1e-4 * out->mean_b * out->mean_b);
        }
    }
    out->rel_mse = relative / n;
}

typedef struct view_job {
    const comparison *comparison;
    float *shown[6]; /* A's planes, then B's */
} view_job;

static void view_row(void *user, size_t y, size_t worker)
{
    const view_job *const job = user;
    const comparison *const c = job->comparison;
    (void)worker;
    for (size_t i = y * c->width; i < (y + 1) * c->width; i++) {
        float a[3] = {c->a[0][i], c->a[1][i], c->a[2][i]};
        float b[3] = {c->b[0][i], c->b[1][i], c->b[2][i]};
        air_view_apply(c->params->view, c->exposure_ev, a, a);
        air_view_apply(c->params->view, c->exposure_ev, b, b);
        for (size_t k = 0; k < 3; k++) {
            job->shown[k][i] = a[k];
            job->shown[3 + k][i] = b[k];
        }
    }
}

/* LDR-FLIP after exposure and view. */
static air_status ldr_flip(air_context *context, const comparison *c, float *out_map)
{
    const size_t count = c->width * c->height;
    float *pixels = air_allocate(context, 6 * count, sizeof(*pixels));
    if (pixels == NULL) {
        return air_fail_memory(context, "FLIP");
    }
    view_job job = {.comparison = c};
    air_flip_pair pair = {
        .width = c->width, .height = c->height, .pixels_per_degree = c->params->pixels_per_degree};
    for (size_t k = 0; k < 3; k++) {
        pair.test[k] = job.shown[k] = pixels + k * count;
        pair.reference[k] = job.shown[3 + k] = pixels + (3 + k) * count;
    }
    air_parallel_for(context, c->height, view_row, &job);
    const air_status status = air_flip_ldr(context, &pair, out_map);
    air_free(context, pixels);
    return status;
}

static double masked_mean(const comparison *c, const float *map)
{
    double sum = 0.0;
    size_t n = 0;
    for (size_t i = 0; i < c->width * c->height; i++) {
        if (counted(c, i)) {
            sum += (double)map[i];
            n++;
        }
    }
    return sum / (double)n;
}

air_status air_image_compare(air_context *context, const air_image *a, const air_image *b,
                             const air_metrics_params *params, air_metrics *out_metrics)
{
    comparison c;
    air_status status = start(context, a, b, params, &c);
    if (status != AIR_OK) {
        return status;
    }
    air_metrics metrics = {0};
    measure_differences(&c, &metrics);
    if (metrics.pixel_count == 0) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "compare: the mask selects no pixel");
    }
    float *map = air_allocate(context, c.width * c.height, sizeof(*map));
    if (map == NULL) {
        return air_fail_memory(context, "FLIP");
    }
    status = ldr_flip(context, &c, map);
    if (status == AIR_OK) {
        metrics.flip = masked_mean(&c, map);
        const air_flip_pair pair = {.test = {c.a[0], c.a[1], c.a[2]},
                                    .reference = {c.b[0], c.b[1], c.b[2]},
                                    .width = c.width,
                                    .height = c.height,
                                    .pixels_per_degree = params->pixels_per_degree};
        status = air_flip_hdr(context, &pair, map);
    }
    if (status == AIR_OK) {
        metrics.hdr_flip = masked_mean(&c, map);
        *out_metrics = metrics;
    }
    air_free(context, map);
    return status;
}

air_status air_image_flip(air_context *context, const air_image *a, const air_image *b,
                          const air_metrics_params *params, air_image **out_map)
{
    static const char *const names[1] = {"Y"};
    comparison c;
    *out_map = NULL;
    air_status status = start(context, a, b, params, &c);
    air_image *map = NULL;
    if (status == AIR_OK) {
        status = air_image_create(context, c.width, c.height, 1, names, &map);
    }
    if (status == AIR_OK) {
        status = ldr_flip(context, &c, air_image_plane(map, 0));
    }
    if (status == AIR_OK) {
        *out_map = map;
    } else {
        air_image_destroy(map);
    }
    return status;
}

air_status air_image_difference(air_context *context, const air_image *a, const air_image *b,
                                air_image **out_image)
{
    static const char *const names[3] = {"R", "G", "B"};
    const float *planes_a[3];
    const float *planes_b[3];
    air_image *image = NULL;
    *out_image = NULL;
    air_status status = check_pair(context, a, b, planes_a, planes_b);
    if (status == AIR_OK) {
        status = air_image_create(context, a->width, a->height, 3, names, &image);
    }
    for (size_t k = 0; k < 3 && status == AIR_OK; k++) {
        float *const plane = air_image_plane(image, k);
        for (size_t i = 0; i < a->width * a->height; i++) {
            plane[i] = fabsf(planes_a[k][i] - planes_b[k][i]);
        }
    }
    *out_image = image;
    return status;
}
