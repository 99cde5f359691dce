/* Denoising texels: what goes, what stays, and what is never reached. */
#include "atlas/denoise.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "atlas_fixture.h"
#include "memory_shortage.h"

enum { SIZE = 96, TEXELS = SIZE * SIZE };

/* Two charts, the left and the right half, on planes at right angles; values per texel. */
typedef struct page {
    uint32_t charts[TEXELS];
    float position[3][TEXELS], normal[3][TEXELS], area[TEXELS];
    float truth[3][TEXELS], planes[3][TEXELS], variance[3][TEXELS];
} page;

/* The sum of twelve numbers less six: mean 0, variance 1. */
static double draw_normal(air_rng *rng)
{
    double sum = -6.0;
    for (int i = 0; i < 12; i++) {
        sum += (double)air_rng_float(rng);
    }
    return sum;
}

static void make_surface(page *p)
{
    for (size_t i = 0; i < TEXELS; i++) {
        const double x = (double)(i % SIZE), y = (double)(i / SIZE);
        const bool left = x < SIZE / 2;
        p->charts[i] = left ? 3 : 8;
        p->position[0][i] = left ? (float)(0.1 * x) : 0.0f;
        p->position[1][i] = (float)(0.1 * y);
        p->position[2][i] = left ? 0.0f : (float)(0.1 * (x - SIZE / 2));
        p->normal[0][i] = left ? 0.0f : 1.0f;
        p->normal[2][i] = left ? 1.0f : 0.0f;
        p->area[i] = 1.0f;
    }
}

/* Light that falls off slowly, with a shadow whose edge is a sixteenth of the page wide on the left
 * and sharp on the right. */
static double light_at(size_t texel)
{
    const double x = (double)(texel % SIZE) / SIZE, y = (double)(texel / SIZE) / SIZE;
    const double light = 0.6 + 0.4 * sin(2.0 * x + 3.0 * y);
    const double across = x - 0.3 - 0.3 * y, other = x - 0.75;
    const double soft = fmin(fmax(0.5 + 8.0 * across, 0.0), 1.0);
    return light * (x < 0.5                                        ? 0.1 + 0.9 * soft
                    : other * other + (y - 0.5) * (y - 0.5) < 0.02 ? 0.1
                                                                   : 1.0);
}

/* `samples` samples of a relative standard deviation each: their mean, and the variance of the mean
 * as a program finds it from them. Colours share the noise, as they do where light is white. */
static void make_noise(page *p, double deviation, int samples, uint32_t seed)
{
    static const double tints[3] = {1.0, 0.8, 0.5};
    air_rng rng = air_rng_from_keys(seed, 7);
    for (size_t i = 0; i < TEXELS; i++) {
        double sum = 0.0, squares = 0.0;
        for (int n = 0; n < samples; n++) {
            const double s = 1.0 + deviation * draw_normal(&rng);
            sum += s;
            squares += s * s;
        }
        const double mean = sum / samples;
        const double variance = fmax((squares / samples - mean * mean) / (samples - 1), 0.0);
        for (size_t k = 0; k < 3; k++) {
            const double truth = tints[k] * light_at(i);
            p->truth[k][i] = (float)truth;
            p->planes[k][i] = (float)(truth * mean);
            p->variance[k][i] = (float)(truth * truth * variance);
        }
    }
}

static air_atlas_guides guides_of(const page *p)
{
    return (air_atlas_guides){SIZE,
                              SIZE,
                              p->charts,
                              {p->position[0], p->position[1], p->position[2]},
                              {p->normal[0], p->normal[1], p->normal[2]},
                              p->area};
}

static void denoise(air_context *context, page *p)
{
    float *const planes[3] = {p->planes[0], p->planes[1], p->planes[2]};
    const float *const variance[3] = {p->variance[0], p->variance[1], p->variance[2]};
    const air_atlas_guides guides = guides_of(p);
    const air_atlas_layer layer = {planes, variance, 3};
    air_atlas_denoise_params params;
    air_atlas_denoise_params_default(&params);
    assert_int_equal(air_atlas_denoise(context, &guides, &params, &layer), AIR_OK);
}

static double rmse(const page *p)
{
    double sum = 0.0;
    for (size_t i = 0; i < 3 * TEXELS; i++) {
        const double d =
            (double)p->planes[i / TEXELS][i % TEXELS] - (double)p->truth[i / TEXELS][i % TEXELS];
        sum += d * d;
    }
    return sqrt(sum / (3.0 * TEXELS));
}

/* 30 % of noise in the means of 16 samples, with their estimated variances: the error falls to a
 * quarter or less, and the mean of the page is kept to a percent. */
static void noise_goes(void **state)
{
    static const double deviations[4] = {1.2, 0.4, 0.12, 3.6};
    static page p;
    (void)state;
    air_context *context = atlas_context(2);
    make_surface(&p);
    for (int n = 0; n < 4; n++) {
        double mean[2] = {0.0, 0.0};
        make_noise(&p, deviations[n], 16, (uint32_t)n);
        const double before = rmse(&p);
        denoise(context, &p);
        const double after = rmse(&p);
        for (size_t i = 0; i < 3 * TEXELS; i++) {
            mean[0] += (double)p.planes[i / TEXELS][i % TEXELS];
            mean[1] += (double)p.truth[i / TEXELS][i % TEXELS];
        }
        (void)printf("noise of %.0f %%: RMSE %.4f to %.4f, %.1f times lower; mean off by %.2f %%\n",
                     25.0 * deviations[n], before, after, before / after,
                     100.0 * (mean[0] / mean[1] - 1.0));
        assert_true(after < before / (n == 0 ? 4.0 : 2.5));
        assert_true(n == 3 || fabs(mean[0] / mean[1] - 1.0) < 0.01);
    }
    air_context_destroy(context);
}

/* Is a texel within three texels of the round shadow's rim: inside (1), outside (0), or not (2)? */
static int rim_side(size_t texel)
{
    const double x = (double)(texel % SIZE) / SIZE - 0.75;
    const double y = (double)(texel / SIZE) / SIZE - 0.5;
    const double r = SIZE * (sqrt(x * x + y * y) - sqrt(0.02));
    return fabs(r) > 3.0 ? 2 : r < 0.0 ? 1 : 0;
}

/* The sharp edge keeps its contrast: within three texels of it, means of shadow and of light change
 * by less than 3 % of the step. */
static void edges_of_shadows_stay(void **state)
{
    static page p;
    double sums[2][2] = {{0.0, 0.0}, {0.0, 0.0}}, count[2] = {0.0, 0.0};
    (void)state;
    air_context *context = atlas_context(2);
    make_surface(&p);
    make_noise(&p, 1.2, 16, 11);
    denoise(context, &p);
    for (size_t i = 0; i < TEXELS; i++) {
        const int at = rim_side(i);
        if (at < 2) {
            sums[at][0] += (double)p.planes[0][i];
            sums[at][1] += (double)p.truth[0][i];
            count[at] += 1.0;
        }
    }
    const double step = sums[0][1] / count[0] - sums[1][1] / count[1];
    for (int at = 0; at < 2; at++) {
        const double moved = (sums[at][0] - sums[at][1]) / count[at];
        (void)printf("%s the shadow's rim: off by %.2f %% of the step\n",
                     at == 0 ? "outside" : "inside", 100.0 * moved / step);
        assert_true(count[at] > 100.0 && fabs(moved) < 0.03 * step);
    }
    air_context_destroy(context);
}

/* Even light of 1 with 3 % of noise, and one of about 300 texels with a path of 64 samples that
 * brings 600 times as much: 10 more. Nothing shows a window's border: neighbours differ by less
 * than two deviations of the noise; one firefly over a radius of 14 texels is 0.05 in its middle
 * and four times as much in a corner, which falls by a fourteenth a texel. The light of all is
 * kept. */
static void fireflies_leave_no_squares(void **state)
{
    static page p;
    double most = 0.0, mean[2] = {0.0, 0.0};
    size_t count = 0;
    (void)state;
    air_context *context = atlas_context(2);
    air_rng rng = air_rng_from_keys(31, 7);
    make_surface(&p);
    for (size_t i = 0; i < TEXELS; i++) {
        const bool firefly = air_rng_float(&rng) < 1.0f / 300.0f;
        const double value = 1.0 + 0.03 * draw_normal(&rng) + (firefly ? 10.0 : 0.0);
        count += firefly;
        for (size_t k = 0; k < 3; k++) {
            p.planes[k][i] = (float)value;
            p.variance[k][i] = firefly ? 100.0f : 0.0009f;
            mean[0] += value / (3.0 * TEXELS);
        }
    }
    denoise(context, &p);
    for (size_t i = 0; i < TEXELS; i++) {
        mean[1] += (double)(p.planes[0][i] + p.planes[1][i] + p.planes[2][i]) / (3.0 * TEXELS);
        if (i % SIZE + 1 < SIZE && i % SIZE != SIZE / 2 - 1) {
            const double step = fabs((double)p.planes[0][i + 1] - (double)p.planes[0][i]);
            most = fmax(most, step);
        }
    }
    (void)printf("%zu fireflies: largest step %.4f, mean off by %.3f %%\n", count, most,
                 100.0 * (mean[1] / mean[0] - 1.0));
    assert_true(count > 10 && most < 0.06 && fabs(mean[1] / mean[0] - 1.0) < 0.001);
    air_context_destroy(context);
}

/* Single texels that are bright for certain stay. */
static void what_is_bright_and_certain_stays(void **state)
{
    static page p;
    (void)state;
    air_context *context = atlas_context(2);
    make_surface(&p);
    for (size_t i = 0; i < TEXELS; i++) {
        const bool bright = i % 37 == 0;
        for (size_t k = 0; k < 3; k++) {
            p.planes[k][i] = bright ? 5.0f : 1.0f;
            p.variance[k][i] = bright ? 0.01f : 0.0009f;
        }
    }
    denoise(context, &p);
    for (size_t i = 0; i < TEXELS; i++) {
        const float expected = i % 37 == 0 ? 5.0f : 1.0f;
        assert_float_equal(p.planes[0][i], expected, 0.01f);
    }
    air_context_destroy(context);
}

/* Without variance nothing changes at all, whatever there is. */
static void what_has_converged_stays(void **state)
{
    static page p, before;
    (void)state;
    air_context *context = atlas_context(2);
    make_surface(&p);
    make_noise(&p, 1.2, 16, 3);
    memset(p.variance, 0, sizeof p.variance);
    before = p;
    denoise(context, &p);
    for (size_t k = 0; k < 3; k++) {
        for (size_t i = 0; i < TEXELS; i++) {
            assert_float_equal(p.planes[k][i], before.planes[k][i], 1e-6f);
        }
    }
    air_context_destroy(context);
}

/* Values of 0 and 1 with a variance that would mix anything: what parts them is the chart, then the
 * normal, then a step of 5 texels' height within one chart. */
static void borders_are_not_crossed(void **state)
{
    static page p;
    (void)state;
    air_context *context = atlas_context(2);
    for (int how = 0; how < 3; how++) {
        make_surface(&p);
        for (size_t i = 0; i < TEXELS; i++) {
            const bool left = i % SIZE < SIZE / 2;
            p.charts[i] = how == 0 && !left ? 1 : 0;
            if (how != 1) {
                p.position[0][i] = 0.1f * (float)(i % SIZE);
                p.position[2][i] = how == 2 && !left ? 0.5f : 0.0f;
                p.normal[0][i] = 0.0f;
                p.normal[2][i] = 1.0f;
            }
            for (size_t k = 0; k < 3; k++) {
                p.planes[k][i] = left ? 0.0f : 1.0f;
                p.variance[k][i] = 100.0f;
            }
        }
        denoise(context, &p);
        for (size_t i = 0; i < TEXELS; i++) {
            const float expected = i % SIZE < SIZE / 2 ? 0.0f : 1.0f;
            assert_float_equal(p.planes[0][i], expected, 1e-5f);
        }
    }
    air_context_destroy(context);
}

/* NaN and free texels neither spread nor change. */
static void what_is_not_finite_is_left_out(void **state)
{
    static page p, before;
    (void)state;
    air_context *context = atlas_context(2);
    make_surface(&p);
    make_noise(&p, 1.0, 16, 5);
    for (size_t i = 0; i < TEXELS; i += 7) {
        p.charts[i] = i % 3 == 0 ? AIR_NO_CHART : p.charts[i];
        p.planes[1][i] = i % 3 == 1 ? NAN : p.planes[1][i];
        p.variance[2][i] = i % 3 == 2 ? INFINITY : p.variance[2][i];
    }
    before = p;
    denoise(context, &p);
    for (size_t i = 0; i < TEXELS; i++) {
        if (i % 7 == 0) {
            assert_memory_equal(&p.planes[0][i], &before.planes[0][i], sizeof(float));
            assert_memory_equal(&p.planes[1][i], &before.planes[1][i], sizeof(float));
        } else {
            assert_true(isfinite(p.planes[0][i] + p.planes[1][i] + p.planes[2][i]));
        }
    }
    air_context_destroy(context);
}

/* RMSE of light with shadows (0) and of smooth light (1), both with 30 % of noise, filtered as
 * layers apart or as one. */
static void filter_two(air_context *context, bool together, double out[2])
{
    static page direct, indirect;
    float *planes[2] = {direct.planes[0], indirect.planes[0]};
    const float *variance[2] = {direct.variance[0], indirect.variance[0]};
    air_atlas_denoise_params params;
    air_atlas_denoise_params_default(&params);
    make_surface(&direct);
    make_noise(&direct, 1.2, 16, 21);
    make_noise(&indirect, 1.2, 16, 22);
    for (size_t i = 0; i < TEXELS; i++) {
        const float truth = indirect.truth[0][i];
        indirect.planes[0][i] /= truth;
        indirect.variance[0][i] /= truth * truth;
        indirect.truth[0][i] = 1.0f;
    }
    const air_atlas_guides guides = guides_of(&direct);
    for (size_t k = 0; k < 2; k += together ? 2 : 1) {
        const air_atlas_layer layer = {planes + k, variance + k, together ? 2 : 1};
        assert_int_equal(air_atlas_denoise(context, &guides, &params, &layer), AIR_OK);
    }
    for (size_t k = 0; k < 2; k++) {
        const float *truth = k == 0 ? direct.truth[0] : indirect.truth[0];
        double sum = 0.0;
        for (size_t i = 0; i < TEXELS; i++) {
            sum += pow((double)planes[k][i] - (double)truth[i], 2.0);
        }
        out[k] = sqrt(sum / TEXELS);
    }
}

/* Layers with noise of their own, filtered as one: neighbourhoods are compared by twice as many
 * numbers, which is worth more than what the shadows of the one cost the other. */
static void layers_together_do_better(void **state)
{
    double apart[2], together[2];
    (void)state;
    air_context *context = atlas_context(2);
    filter_two(context, false, apart);
    filter_two(context, true, together);
    (void)printf("shadows and smooth light, RMSE apart: %.4f, %.4f; as one layer: %.4f, %.4f\n",
                 apart[0], apart[1], together[0], together[1]);
    assert_true(together[0] < apart[0]);
    assert_true(together[1] < apart[1]);
    air_context_destroy(context);
}

static void threads_do_not_matter(void **state)
{
    static page both[2];
    (void)state;
    for (size_t n = 0; n < 2; n++) {
        air_context *context = atlas_context(1 + 2 * n);
        make_surface(&both[n]);
        make_noise(&both[n], 1.0, 16, 9);
        denoise(context, &both[n]);
        air_context_destroy(context);
    }
    assert_memory_equal(&both[0], &both[1], sizeof both[0]);
}

static void wrong_arguments_are_refused(void **state)
{
    static page p;
    (void)state;
    air_context *context = atlas_context(1);
    float *const planes[1] = {p.planes[0]};
    const float *const variance[1] = {p.variance[0]};
    for (int i = 0; i < 6; i++) {
        air_atlas_guides guides = guides_of(&p);
        air_atlas_layer layer = {planes, variance, 1};
        air_atlas_denoise_params params;
        air_atlas_denoise_params_default(&params);
        params.radius = i == 0 ? 0 : i == 1 ? 21 : 2;
        params.strength = i == 2 ? 0.0 : 1.0;
        params.normal_angle_rad = i == 3 ? 4.0 : 1.0;
        layer.plane_count = i == 4 ? 17 : 1;
        guides.height = i == 5 ? 0 : SIZE;
        assert_int_equal(air_atlas_denoise(context, &guides, &params, &layer), AIR_ERROR_ARGUMENT);
    }
    air_context_destroy(context);
}

static air_status try_denoise(air_context *context, void *user)
{
    page *const p = user;
    float *const planes[1] = {p->planes[0]};
    const float *const variance[1] = {p->variance[0]};
    const air_atlas_guides guides = guides_of(p);
    const air_atlas_layer layer = {planes, variance, 1};
    air_atlas_denoise_params params;
    air_atlas_denoise_params_default(&params);
    return air_atlas_denoise(context, &guides, &params, &layer);
}

static void want_of_memory_is_reported(void **state)
{
    static page p;
    (void)state;
    make_surface(&p);
    make_noise(&p, 1.0, 4, 9);
    assert_shortage_survived(try_denoise, &p, 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_goes),
        cmocka_unit_test(edges_of_shadows_stay),
        cmocka_unit_test(fireflies_leave_no_squares),
        cmocka_unit_test(what_is_bright_and_certain_stays),
        cmocka_unit_test(what_has_converged_stays),
        cmocka_unit_test(borders_are_not_crossed),
        cmocka_unit_test(what_is_not_finite_is_left_out),
        cmocka_unit_test(layers_together_do_better),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
