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
        WIDTH, HEIGHT, p->depth, {p->normal[0], p->normal[1], p->normal[2]}};
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
    const air_denoise_guides guides = {SIDE, SIDE, NULL, {NULL, NULL, NULL}};
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
        const air_denoise_guides guides = {sizes[i][0], sizes[i][1], NULL, {NULL, NULL, NULL}};
        assert_int_equal(air_denoise_planes(context, &guides, &params, &plane, 1), AIR_OK);
        assert_true(values[0] >= 1.0f && values[4] <= 5.0f);
    }
    const air_denoise_guides guides = {5, 1, NULL, {NULL, NULL, NULL}};
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
