/* ztest.c: have two noisy images the same expectation? */
#include <math.h>

#include "image/image.h"
#include "image/probability.h"

/* What is compared; variances of a missing variance image are NULL. */
typedef struct ztest_input {
    const float *a[3], *b[3];
    const float *variance[2][3];
    size_t width, height, block;
    double nu;
} ztest_input;

/* Sums over pixels of one channel. */
typedef struct sums {
    double a, b;
    double variance;
    double variance_squared; /* of the pixels' variances, for Welch and Satterthwaite */
} sums;

/* Running results of one channel. */
typedef struct channel_result {
    size_t tests, beyond_95, differing;
    double min_p, score_squares;
    sums image;
} channel_result;

static bool find_variance(const air_image *image, const float *out_planes[3])
{
    static const char *const names[3] = {"variance.R", "variance.G", "variance.B"};
    for (size_t c = 0; c < 3; c++) {
        const ptrdiff_t channel = air_image_find_channel(image, names[c]);
        if (channel < 0) {
            return air_image_colour(image, out_planes);
        }
        out_planes[c] = air_image_plane_const(image, (size_t)channel);
    }
    return true;
}

static air_status check_finite(air_context *context, const char *name, const float *const planes[3],
                               size_t width, size_t count)
{
    size_t first = 0;
    const size_t bad = air_image_count_not_finite(planes, count, &first);
    if (bad > 0) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "Z-test: %s has %zu pixels that are not finite, the first at (%zu,%zu)",
                        name, bad, first % width, first / width);
    }
    return AIR_OK;
}

static air_status check_variance(air_context *context, const char *name,
                                 const float *const planes[3], size_t width, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (planes[0][i] < 0.0f || planes[1][i] < 0.0f || planes[2][i] < 0.0f) {
            return air_fail(context, AIR_ERROR_FORMAT, "Z-test: %s is negative at pixel (%zu,%zu)",
                            name, i % width, i / width);
        }
    }
    return check_finite(context, name, planes, width, count);
}

static air_status collect(air_context *context, const air_image *a, const air_image *b,
                          const air_image *const variances[2], ztest_input *out)
{
    static const char *const names[2] = {"the variance of A", "the variance of B"};
    const size_t count = a->width * a->height;
    if (b->width != a->width || b->height != a->height) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "Z-test: the images are %zu x %zu and %zu x %zu, expected equal sizes",
                        a->width, a->height, b->width, b->height);
    }
    if (!air_image_colour(a, out->a) || !air_image_colour(b, out->b)) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "Z-test: an image has neither R,G,B nor Y");
    }
    air_status status = check_finite(context, "image A", out->a, a->width, count);
    if (status == AIR_OK) {
        status = check_finite(context, "image B", out->b, a->width, count);
    }
    for (size_t i = 0; i < 2 && status == AIR_OK; i++) {
        if (variances[i] == NULL) {
            continue;
        }
        if (variances[i]->width != a->width || variances[i]->height != a->height ||
            !find_variance(variances[i], out->variance[i])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "Z-test: %s needs the size %zu x %zu and the channels variance.R,G,B "
                            "or R,G,B",
                            names[i], a->width, a->height);
        }
        status = check_variance(context, names[i], out->variance[i], a->width, count);
    }
    return status;
}

static void add_pixel(sums *s, const ztest_input *in, size_t channel, size_t i)
{
    s->a += (double)in->a[channel][i];
    s->b += (double)in->b[channel][i];
    for (size_t k = 0; k < 2; k++) {
        if (in->variance[k][channel] != NULL) {
            const double v = (double)in->variance[k][channel][i];
            s->variance += v;
            s->variance_squared += v * v;
        }
    }
}

static void add_sums(sums *total, const sums *s)
{
    total->a += s->a;
    total->b += s->b;
    total->variance += s->variance;
    total->variance_squared += s->variance_squared;
}

/* z of the difference and its two-sided p. The variance of a sum of N estimates with nu degrees of
 * freedom each has about nu (sum v)^2 / sum v^2 of them [Satterthwaite1946, Welch1947]. */
static double score(const sums *s, double nu, double *out_p)
{
    const double z = (s->a - s->b) / sqrt(s->variance);
    const double nu_sum = nu * s->variance * s->variance / s->variance_squared;
    *out_p = air_student_two_sided(z, nu_sum);
    return z;
}

static void test_block(const ztest_input *in, const sums *s, channel_result *result)
{
    if (s->variance > 0.0) {
        double p = 1.0;
        (void)score(s, in->nu, &p);
        const double normal = air_normal_two_sided_score(p);
        result->tests++;
        result->beyond_95 += p < 0.05;
        result->min_p = fmin(result->min_p, p);
        result->score_squares += normal * normal;
    } else if (fabs(s->a - s->b) > 1e-4 * fmax(fabs(s->a), fabs(s->b))) {
        /* Beyond what rounding does to two ways of computing the same constant. */
        result->differing++;
    }
    add_sums(&result->image, s);
}

typedef struct ztest_job {
    const ztest_input *input;
    channel_result results[3];
} ztest_job;

static void test_channel(void *user, size_t channel, size_t worker)
{
    ztest_job *const job = user;
    const ztest_input *const in = job->input;
    channel_result *const result = &job->results[channel];
    (void)worker;
    *result = (channel_result){.min_p = 1.0};
    for (size_t y0 = 0; y0 < in->height; y0 += in->block) {
        for (size_t x0 = 0; x0 < in->width; x0 += in->block) {
            const size_t y1 = in->height - y0 < in->block ? in->height : y0 + in->block;
            const size_t x1 = in->width - x0 < in->block ? in->width : x0 + in->block;
            sums s = {0};
            for (size_t y = y0; y < y1; y++) {
                for (size_t x = x0; x < x1; x++) {
                    add_pixel(&s, in, channel, y * in->width + x);
                }
            }
            test_block(in, &s, result);
        }
    }
}

static void combine(const channel_result results[3], double nu, air_ztest *out)
{
    size_t beyond = 0;
    double mean_p = 1.0;
    double chi_square_p = 1.0;
    *out = (air_ztest){.min_p = 1.0};
    for (size_t c = 0; c < 3; c++) {
        const channel_result *const r = &results[c];
        out->test_count += r->tests;
        out->differing_without_variance += r->differing;
        out->min_p = fmin(out->min_p, r->min_p);
        beyond += r->beyond_95;
        if (r->tests == 0) {
            continue;
        }
        double p = 1.0;
        const double z = score(&r->image, nu, &p);
        out->mean_z = fabs(z) > fabs(out->mean_z) ? z : out->mean_z;
        mean_p = fmin(mean_p, p);
        chi_square_p = fmin(chi_square_p, air_chi_square_upper(r->score_squares, (double)r->tests));
    }
    out->sidak_p = air_sidak(out->min_p, (double)out->test_count);
    out->mean_p = air_sidak(mean_p, 3.0);
    out->chi_square_p = air_sidak(chi_square_p, 3.0);
    if (out->test_count > 0) {
        out->fraction_beyond_95 = (double)beyond / (double)out->test_count;
    }
}

air_status air_image_ztest(air_context *context, const air_image *a, const air_image *b,
                           const air_image *variance_a, const air_image *variance_b, size_t block,
                           size_t degrees_of_freedom, air_ztest *out_test)
{
    if (variance_a == NULL && variance_b == NULL) {
        return air_fail(context, AIR_ERROR_ARGUMENT, "Z-test: no variance is given");
    }
    if (block < 1 || degrees_of_freedom < 1) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "Z-test: block %zu and %zu degrees of freedom, both must be at least 1",
                        block, degrees_of_freedom);
    }
    const air_image *const variances[2] = {variance_a, variance_b};
    ztest_input input = {
        .width = a->width, .height = a->height, .block = block, .nu = (double)degrees_of_freedom};
    const air_status status = collect(context, a, b, variances, &input);
    if (status != AIR_OK) {
        return status;
    }
    ztest_job job = {.input = &input};
    air_parallel_for(context, 3, test_channel, &job);
    combine(job.results, input.nu, out_test);
    return AIR_OK;
}
