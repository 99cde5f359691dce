/* The denoiser: what a weighted mean must keep, what its guides must keep apart. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/airlight.h"
#include "cmocka_test.h"
#include "core/random.h"

enum { WIDTH = 37, HEIGHT = 21, PIXELS = WIDTH * HEIGHT };

typedef struct picture {
    float depth[PIXELS], normal[3][PIXELS];
    float a[PIXELS], b[PIXELS];
} picture;

static air_context *make_context(size_t threads)
{
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.thread_count = threads;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

/* Noise on two walls, one nearer than the other, with sky between. */
static void make_picture(picture *p)
{
    air_rng rng = air_rng_from_keys(3, 1);
    memset(p, 0, sizeof *p);
    for (int i = 0; i < PIXELS; i++) {
        const int x = i % WIDTH;
        p->depth[i] = x < 12 ? 2.0f : x < 16 ? 0.0f : 9.0f;
        p->normal[x < 12 ? 0 : 2][i] = p->depth[i] > 0.0f ? 1.0f : 0.0f;
        p->b[i] = air_rng_float(&rng);
        p->a[i] = p->b[i] * air_rng_float(&rng);
    }
}

static air_denoise_guides guides_of(const picture *p)
{
    return (air_denoise_guides){
        WIDTH, HEIGHT, p->depth, {p->normal[0], p->normal[1], p->normal[2]}, NULL};
}

static void denoise(air_context *context, picture *p, float scale)
{
    float *const planes[2] = {p->a, p->b};
    const air_denoise_guides guides = guides_of(p);
    air_denoise_params params;
    air_denoise_params_default(&params);
    params.scale = scale;
    assert_int_equal(air_denoise_planes(context, &guides, &params, planes, 2), AIR_OK);
}

static void constants_stay(void **state)
{
    static picture p;
    air_context *context = make_context(2);
    (void)state;
    make_picture(&p);
    for (int i = 0; i < PIXELS; i++) {
        p.a[i] = 0.7f;
        p.b[i] = 3.0f;
    }
    denoise(context, &p, 1.0f);
    for (int i = 0; i < PIXELS; i++) {
        /* three quotients of sums of 25 terms */
        assert_float_equal(p.a[i], 0.7f, 3.0f * 25.0f * 6e-8f);
        assert_float_equal(p.b[i], 3.0f, 3.0f * 3.0f * 25.0f * 6e-8f);
    }
    air_context_destroy(context);
}

/* Equal weights keep 0 <= a <= b, and the same bytes come from any number of threads. */
static void order_is_kept_by_any_number_of_threads(void **state)
{
    static picture first, p;
    (void)state;
    for (size_t threads = 1; threads <= 3; threads++) {
        air_context *context = make_context(threads);
        make_picture(&p);
        denoise(context, &p, 0.8f);
        for (int i = 0; i < PIXELS; i++) {
            assert_true(p.a[i] >= 0.0f && p.a[i] <= p.b[i]);
        }
        if (threads == 1) {
            first = p;
        }
        assert_memory_equal(&p, &first, sizeof p);
        air_context_destroy(context);
    }
}

/* What is beyond an edge in depth, of sky, or of normals does not matter: a plane that is 0 on one
 * side and 1 on the other stays so (exp(-|ln 4.5| / 1) is the most that depth alone lets through,
 * normals at right angles nothing). */
static void edges_are_not_crossed(void **state)
{
    static picture p;
    air_context *context = make_context(2);
    (void)state;
    make_picture(&p);
    for (int i = 0; i < PIXELS; i++) {
        p.a[i] = p.b[i] = i % WIDTH < 12 ? 0.0f : i % WIDTH < 16 ? 5.0f : 1.0f;
    }
    denoise(context, &p, 1.0f);
    for (int i = 0; i < PIXELS; i++) {
        const int x = i % WIDTH;
        const float expected = x < 12 ? 0.0f : x < 16 ? 5.0f : 1.0f;
        assert_float_equal(p.a[i], expected, 1e-5f);
    }
    air_context_destroy(context);
}

/* The variance of independent noise falls by the sum of the squared weights: of one level of the
 * spline (70/256)^2. In the middle of a flat picture, away from borders. */
static void noise_falls_as_the_weights_say(void **state)
{
    enum { SIDE = 200 };
    float *plane = malloc(SIDE * SIDE * sizeof *plane);
    const air_denoise_guides guides = {SIDE, SIDE, NULL, {NULL, NULL, NULL}, NULL};
    air_denoise_params params;
    air_context *context = make_context(2);
    air_rng rng = air_rng_from_keys(5, 5);
    double before = 0.0, after = 0.0;
    (void)state;
    for (int i = 0; i < SIDE * SIDE; i++) {
        plane[i] = air_rng_float(&rng) - 0.5f;
        before += (double)plane[i] * (double)plane[i];
    }
    air_denoise_params_default(&params);
    params.levels = 1;
    assert_int_equal(air_denoise_planes(context, &guides, &params, &plane, 1), AIR_OK);
    for (int i = 0; i < SIDE * SIDE; i++) {
        after += (double)plane[i] * (double)plane[i];
    }
    const double expected = (70.0 / 256.0) * (70.0 / 256.0);
    /* 40,000 pixels, of which some 25 hang together: 5 % is more than three standard deviations */
    assert_true(fabs(after / before / expected - 1.0) <= 0.05);
    free(plane);
    air_context_destroy(context);
}

/* At scale s the first level has the share 21 s^2 of the spline, the others nothing: no value in
 * [0, 1] moves by more than that. */
static void a_small_scale_is_the_identity(void **state)
{
    static picture p, before;
    air_context *context = make_context(1);
    (void)state;
    make_picture(&p);
    before = p;
    denoise(context, &p, 1e-3f);
    for (int i = 0; i < PIXELS; i++) {
        assert_float_equal(p.b[i], before.b[i], 21e-6f + 1e-6f);
    }
    air_context_destroy(context);
}

static void what_is_not_finite_stays_and_spoils_nothing(void **state)
{
    static picture p;
    air_context *context = make_context(2);
    (void)state;
    make_picture(&p);
    p.a[100] = NAN;
    p.b[200] = INFINITY;
    p.depth[300] = NAN;
    denoise(context, &p, 1.0f);
    for (int i = 0; i < PIXELS; i++) {
        assert_true(i == 100 ? isnan(p.a[i]) : isfinite(p.a[i]));
        assert_true(i == 200 ? isinf(p.b[i]) : isfinite(p.b[i]));
    }
    air_context_destroy(context);
}

static void small_pictures_and_wrong_parameters(void **state)
{
    static const size_t sizes[4][2] = {{1, 1}, {3, 1}, {1, 5}, {0, 4}};
    air_context *context = make_context(1);
    air_denoise_params params;
    float values[5] = {1.0f, 2.0f, 3.0f, 4.0f, 5.0f};
    float *plane = values;
    (void)state;
    air_denoise_params_default(&params);
    params.levels = AIR_DENOISE_MAX_LEVELS;
    for (int i = 0; i < 4; i++) {
        const air_denoise_guides guides = {
            sizes[i][0], sizes[i][1], NULL, {NULL, NULL, NULL}, NULL};
        assert_int_equal(air_denoise_planes(context, &guides, &params, &plane, 1), AIR_OK);
        assert_true(values[0] >= 1.0f && values[4] <= 5.0f);
    }
    const air_denoise_guides guides = {5, 1, NULL, {NULL, NULL, NULL}, NULL};
    params.levels = AIR_DENOISE_MAX_LEVELS + 1;
    assert_int_equal(air_denoise_planes(context, &guides, &params, &plane, 1), AIR_ERROR_ARGUMENT);
    params.levels = 1;
    params.scale = 0.0f;
    assert_int_equal(air_denoise_planes(context, &guides, &params, &plane, 1), AIR_ERROR_ARGUMENT);
    params.scale = NAN;
    assert_int_equal(air_denoise_planes(context, &guides, &params, &plane, 1), AIR_ERROR_ARGUMENT);
    air_context_destroy(context);
}

/* A texture evenly lit is what its albedo says, to rounding, and other channels are kept. */
static void images_are_filtered_without_their_texture(void **state)
{
    static const char *const names[] = {"R",        "G",        "B",        "depth.Z",
                                        "albedo.R", "albedo.G", "albedo.B", "mask"};
    air_context *context = make_context(1);
    air_image *image, *out;
    (void)state;
    assert_int_equal(air_image_create(context, WIDTH, HEIGHT, 8, names, &image), AIR_OK);
    for (size_t i = 0; i < PIXELS; i++) {
        const float albedo = i % 3 == 0 ? 0.2f : 0.9f;
        for (size_t c = 0; c < 3; c++) {
            air_image_plane(image, c)[i] = 4.0f * albedo;
            air_image_plane(image, 4 + c)[i] = albedo;
        }
        air_image_plane(image, 3)[i] = 1.0f;
        air_image_plane(image, 7)[i] = (float)i;
    }
    assert_int_equal(air_image_set_attribute(image, "airlight:seed", "7"), AIR_OK);
    air_denoise_params params;
    air_denoise_params_default(&params);
    assert_int_equal(air_image_denoise(context, image, &params, &out), AIR_OK);
    for (size_t i = 0; i < PIXELS; i++) {
        const float expected = air_image_plane(image, 0)[i];
        assert_float_equal(air_image_plane(out, 0)[i], expected, 1e-5f);
        assert_true(air_image_plane(out, 7)[i] == (float)i);
    }
    assert_string_equal(air_image_attribute(out, "airlight:seed"), "7");
    air_image_destroy(out);
    air_image_destroy(image);
    assert_int_equal(air_image_create(context, 4, 4, 3, names, &image), AIR_OK);
    assert_int_equal(air_image_denoise(context, image, &params, &out), AIR_ERROR_ARGUMENT);
    assert_null(out);
    assert_non_null(strstr(air_context_last_error(context), "depth.Z"));
    air_image_destroy(image);
    air_context_destroy(context);
}

/* Lengths of normals do not matter, and one above 1 does not make weights grow without bound. */
static void only_the_direction_of_normals_counts(void **state)
{
    static picture unit, longer;
    air_context *context = make_context(1);
    (void)state;
    make_picture(&unit);
    make_picture(&longer);
    for (int i = 0; i < PIXELS; i++) {
        for (int k = 0; k < 3; k++) {
            longer.normal[k][i] *= 1.5f;
        }
    }
    denoise(context, &unit, 1e-3f);
    denoise(context, &longer, 1e-3f);
    for (int i = 0; i < PIXELS; i++) {
        assert_true(isfinite(unit.a[i]) && unit.a[i] == longer.a[i] && unit.b[i] == longer.b[i]);
    }
    air_context_destroy(context);
}

/* A step in the value that is wide against value_width is kept, where nothing else tells. */
static void a_value_keeps_its_steps(void **state)
{
    static float value[PIXELS], plane[PIXELS];
    const air_denoise_guides guides = {.width = WIDTH, .height = HEIGHT, .value = value};
    float *const planes[1] = {plane};
    air_context *context = make_context(2);
    air_denoise_params params;
    (void)state;
    for (int i = 0; i < PIXELS; i++) {
        value[i] = plane[i] = i % WIDTH < 20 ? 0.25f : 0.75f;
    }
    air_denoise_params_default(&params);
    params.value_width = 0.02f;
    assert_int_equal(air_denoise_planes(context, &guides, &params, planes, 1), AIR_OK);
    for (int i = 0; i < PIXELS; i++) {
        assert_float_equal(plane[i], value[i], 1e-6f); /* e^-25 0.5 */
    }
    params.value_width = 0.0f;
    assert_int_equal(air_denoise_planes(context, &guides, &params, planes, 1), AIR_ERROR_ARGUMENT);
    air_context_destroy(context);
}

/* Mean squared errors of the shares of a half shadow at x = 18, visible with probability 0.1 left
 * of it and 0.9 on the right, as sampled and smoothed. */
typedef struct share_errors {
    double raw, smooth;
} share_errors;

static double share_error(const float *whole, const float *visible)
{
    double sum = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        const float open = i % WIDTH < 18 ? 0.1f : 0.9f;
        const double d = (double)(visible[i] / whole[i]) - (double)open;
        assert_true(visible[i] >= 0.0f && visible[i] <= whole[i]);
        sum += d * d / PIXELS;
    }
    return sum;
}

static share_errors half_shadow(air_context *context, int samples)
{
    static float whole[PIXELS], visible[PIXELS];
    const air_denoise_guides guides = {.width = WIDTH, .height = HEIGHT};
    float *const of_whole[1] = {whole}, *const of_visible[1] = {visible};
    air_rng rng = air_rng_from_keys(17, (uint32_t)samples);
    for (int i = 0; i < PIXELS; i++) {
        const float open = i % WIDTH < 18 ? 0.1f : 0.9f;
        whole[i] = visible[i] = 0.0f;
        for (int k = 0; k < samples; k++) {
            const float amount = air_rng_float(&rng) / (float)samples;
            whole[i] += amount;
            visible[i] += air_rng_float(&rng) < open ? amount : 0.0f;
        }
    }
    const double raw = share_error(whole, visible);
    assert_int_equal(air_denoise_shares(context, &guides, samples, of_whole, of_visible, 1),
                     AIR_OK);
    return (share_errors){raw, share_error(whole, visible)};
}

/* What is sampled falls by 16 from 4 to 64 samples; a filter that stayed as it is would leave the
 * edge's blur. A quarter is what bench_arealight_shadow asks for, too. However many there are, the
 * filter is no loss. */
static void shares_converge_at_edges(void **state)
{
    air_context *context = make_context(2);
    (void)state;
    const share_errors few = half_shadow(context, 4), many = half_shadow(context, 64);
    const share_errors most = half_shadow(context, 2048);
    assert_true(many.smooth <= 0.25 * few.smooth);
    assert_true(few.smooth <= 0.1 * few.raw);
    assert_true(many.smooth <= 0.1 * many.raw);
    assert_true(most.smooth <= 0.5 * most.raw);
    air_context_destroy(context);
}

/* ---- images ---- */

enum { LAYERED = 19 };

static const char *const layered[LAYERED] = {
    "R",        "G",        "B",          "depth.Z",    "normal.X",   "normal.Y", "normal.Z",
    "albedo.R", "albedo.G", "albedo.B",   "S0.R",       "S0.G",       "S0.B",     "M1.R",
    "M1.G",     "M1.B",     "emission.R", "emission.G", "emission.B",
};

/* A wall whose albedo has stripes, in a haze that glows evenly, with a bright sign: all of it what
 * the filter should keep, to rounding. */
static air_image *make_layered(air_context *context)
{
    air_image *image;
    assert_int_equal(air_image_create(context, WIDTH, HEIGHT, LAYERED, layered, &image), AIR_OK);
    for (size_t i = 0; i < PIXELS; i++) {
        const float albedo = i % 3 == 0 ? 0.2f : 0.9f;
        const float sign = i % WIDTH == 5 ? 30.0f : 0.0f;
        air_image_plane(image, 3)[i] = 2.0f;
        air_image_plane(image, 6)[i] = 1.0f;
        for (size_t c = 0; c < 3; c++) {
            air_image_plane(image, 7 + c)[i] = albedo;
            air_image_plane(image, 10 + c)[i] = 4.0f * albedo;
            air_image_plane(image, 13 + c)[i] = 0.5f;
            air_image_plane(image, 16 + c)[i] = sign;
            air_image_plane(image, c)[i] = 4.0f * albedo + 0.5f + sign;
        }
    }
    return image;
}

static void layers_are_filtered_by_what_concerns_them(void **state)
{
    air_context *context = make_context(2);
    air_image *image = make_layered(context), *out;
    air_denoise_params params;
    (void)state;
    air_denoise_params_default(&params);
    assert_int_equal(air_image_denoise(context, image, &params, &out), AIR_OK);
    for (size_t k = 0; k < LAYERED; k++) {
        for (size_t i = 0; i < PIXELS; i++) {
            const float kept = air_image_plane(image, k)[i];
            assert_float_equal(air_image_plane(out, k)[i], kept, 1e-5f * fabsf(kept));
        }
    }
    air_image_destroy(out);
    air_image_destroy(image);
    air_context_destroy(context);
}

/* Of the terms that are left out not a bit changes. */
static void chosen_terms_alone_are_filtered(void **state)
{
    air_context *context = make_context(2);
    air_image *image = make_layered(context), *out;
    air_denoise_params params;
    air_rng rng = air_rng_from_keys(2, 9);
    (void)state;
    for (size_t k = 10; k < 16; k++) {
        for (size_t i = 0; i < PIXELS; i++) {
            air_image_plane(image, k)[i] = air_rng_float(&rng);
        }
    }
    air_denoise_params_default(&params);
    params.terms = 1u << AIR_TERM_M1;
    assert_int_equal(air_image_denoise(context, image, &params, &out), AIR_OK);
    const size_t bytes = PIXELS * sizeof(float);
    assert_memory_equal(air_image_plane(out, 10), air_image_plane(image, 10), bytes);
    assert_memory_not_equal(air_image_plane(out, 13), air_image_plane(image, 13), bytes);
    air_image_destroy(out);
    air_image_destroy(image);
    air_context_destroy(context);
}

/* Guides in threes are there as a whole or not at all; variances of the noisy picture go. */
static void guides_are_whole_and_variances_go(void **state)
{
    static const char *const partial[5] = {"R", "G", "B", "depth.Z", "normal.Z"};
    static const char *const varied[5] = {"R", "G", "B", "depth.Z", "variance.R"};
    air_context *context = make_context(1);
    air_image *image, *out;
    air_denoise_params params;
    (void)state;
    air_denoise_params_default(&params);
    assert_int_equal(air_image_create(context, 4, 4, 5, partial, &image), AIR_OK);
    assert_int_equal(air_image_denoise(context, image, &params, &out), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "normal.X"));
    air_image_destroy(image);
    assert_int_equal(air_image_create(context, 4, 4, 5, varied, &image), AIR_OK);
    assert_int_equal(air_image_denoise(context, image, &params, &out), AIR_OK);
    assert_null(air_image_channel_name(out, 4));
    air_image_destroy(out);
    params.terms = 1u << AIR_TERM_M1;
    assert_int_equal(air_image_denoise(context, image, &params, &out), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "--layers"));
    air_image_destroy(image);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constants_stay),
        cmocka_unit_test(order_is_kept_by_any_number_of_threads),
        cmocka_unit_test(edges_are_not_crossed),
        cmocka_unit_test(noise_falls_as_the_weights_say),
        cmocka_unit_test(a_small_scale_is_the_identity),
        cmocka_unit_test(what_is_not_finite_stays_and_spoils_nothing),
        cmocka_unit_test(small_pictures_and_wrong_parameters),
        cmocka_unit_test(images_are_filtered_without_their_texture),
        cmocka_unit_test(only_the_direction_of_normals_counts),
        cmocka_unit_test(a_value_keeps_its_steps),
        cmocka_unit_test(shares_converge_at_edges),
        cmocka_unit_test(layers_are_filtered_by_what_concerns_them),
        cmocka_unit_test(chosen_terms_alone_are_filtered),
        cmocka_unit_test(guides_are_whole_and_variances_go),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
