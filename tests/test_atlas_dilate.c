/* Filling free texels: held against a search over all texels. */
#include "atlas/dilate.h"

#include <math.h>
#include <string.h>

#include "atlas_fixture.h"
#include "memory_shortage.h"

enum { WIDTH = 53, HEIGHT = 41, TEXELS = WIDTH * HEIGHT };

typedef struct page {
    uint32_t charts[TEXELS];
    float planes[2][TEXELS];
} page;

/* A share of the texels is covered, by charts 0 to 3; values name the texel. */
static void make_page(page *p, float share, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, 4);
    for (size_t i = 0; i < TEXELS; i++) {
        const bool covered = air_rng_float(&rng) < share;
        p->charts[i] = covered ? air_rng_next(&rng) % 4 : AIR_NO_CHART;
        p->planes[0][i] = covered ? (float)i : -1.0f;
        p->planes[1][i] = covered ? 1e6f + (float)i : -2.0f;
    }
}

/* The covered texel of the charts asked for, in the rectangle, that is nearest; -1: none in reach.
 */
static ptrdiff_t nearest_to(const page *p, size_t texel, const air_dilate_gutter *in, double radius)
{
    const int64_t x = (int64_t)(texel % WIDTH), y = (int64_t)(texel / WIDTH);
    int64_t best = INT64_MAX;
    ptrdiff_t found = -1;
    for (int64_t v = in->y; v < in->y + in->height; v++) {
        for (int64_t u = in->x; u < in->x + in->width; u++) {
            const size_t at = (size_t)(v * WIDTH + u);
            const int64_t d = (u - x) * (u - x) + (v - y) * (v - y);
            const bool counts = p->charts[at] != AIR_NO_CHART &&
                                (in->chart == AIR_NO_CHART || in->chart == p->charts[at]);
            if (counts && d < best && (double)d <= radius * radius) {
                best = d;
                found = (ptrdiff_t)at;
            }
        }
    }
    return found;
}

static bool is_inside(const air_dilate_gutter *g, size_t texel)
{
    const size_t x = texel % WIDTH, y = texel / WIDTH;
    return x >= g->x && x < g->x + g->width && y >= g->y && y < g->y + g->height;
}

static void check_page(const page *before, const page *after, const air_dilate_params *params)
{
    const air_dilate_gutter all = {0, 0, WIDTH, HEIGHT, AIR_NO_CHART};
    const double radius = params->everything ? 1e9 : params->radius;
    for (size_t i = 0; i < TEXELS; i++) {
        ptrdiff_t from = (ptrdiff_t)i;
        if (before->charts[i] == AIR_NO_CHART) {
            const air_dilate_gutter *in = &all;
            for (size_t g = 0; g < params->gutter_count; g++) {
                in = is_inside(&params->gutters[g], i) ? &params->gutters[g] : in;
            }
            in = nearest_to(before, i, in, 1e9) < 0 ? &all : in;
            from = nearest_to(before, i, in, radius);
        }
        const size_t at = from < 0 ? i : (size_t)from;
        assert_true(after->planes[0][i] == before->planes[0][at]);
        assert_true(after->planes[1][i] == before->planes[1][at]);
    }
}

static void dilate(air_context *context, page *p, const air_dilate_params *params)
{
    float *const planes[2] = {p->planes[0], p->planes[1]};
    assert_int_equal(air_dilate(context, WIDTH, HEIGHT, p->charts, params, planes, 2), AIR_OK);
}

/* From full pages to one covered texel and none, near and far, on one thread and three. */
static void free_texels_take_the_nearest(void **state)
{
    static const float shares[5] = {0.5f, 0.1f, 0.01f, 0.002f, 0.0f};
    static page before, after, other;
    (void)state;
    air_context *contexts[2] = {atlas_context(1), atlas_context(3)};
    for (uint32_t i = 0; i < 20; i++) {
        air_dilate_params params;
        air_dilate_params_default(&params);
        params.radius = i % 3 == 0 ? 2.0 : 7.5;
        params.everything = i % 4 == 3;
        make_page(&before, shares[i % 5], i);
        after = other = before;
        dilate(contexts[0], &after, &params);
        dilate(contexts[1], &other, &params);
        check_page(&before, &after, &params);
        assert_memory_equal(&after, &other, sizeof after);
    }
    air_context_destroy(contexts[0]);
    air_context_destroy(contexts[1]);
}

/* Gutters take their own chart's only; one whose chart has no texel takes what is near. */
static void gutters_take_their_own_chart(void **state)
{
    static page before, after;
    static const air_dilate_gutter gutters[4] = {
        {0, 0, 20, 15, 0}, {20, 0, 33, 15, 1}, {5, 16, 11, 20, 2}, {30, 20, 10, 10, 77}};
    (void)state;
    air_context *context = atlas_context(2);
    for (uint32_t i = 0; i < 10; i++) {
        air_dilate_params params;
        air_dilate_params_default(&params);
        params.everything = i % 2 == 0;
        params.gutters = gutters;
        params.gutter_count = 4;
        make_page(&before, i < 5 ? 0.1f : 0.02f, 100 + i);
        after = before;
        dilate(context, &after, &params);
        check_page(&before, &after, &params);
    }
    air_context_destroy(context);
}

static void wrong_arguments_are_refused(void **state)
{
    static page p;
    static const air_dilate_gutter gutter = {50, 0, 4, 4, 0};
    float *const planes[1] = {p.planes[0]};
    (void)state;
    air_context *context = atlas_context(1);
    air_dilate_params params;
    air_dilate_params_default(&params);
    assert_int_equal(air_dilate(context, 0, HEIGHT, p.charts, &params, planes, 1),
                     AIR_ERROR_ARGUMENT);
    assert_int_equal(air_dilate(context, 65536, 65536, p.charts, &params, planes, 1),
                     AIR_ERROR_ARGUMENT);
    params.radius = NAN;
    assert_int_equal(air_dilate(context, WIDTH, HEIGHT, p.charts, &params, planes, 1),
                     AIR_ERROR_ARGUMENT);
    params.radius = 1.0;
    params.gutters = &gutter;
    params.gutter_count = 1;
    assert_int_equal(air_dilate(context, WIDTH, HEIGHT, p.charts, &params, planes, 1),
                     AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "gutter 0"));
    air_context_destroy(context);
}

static air_status try_dilate(air_context *context, void *user)
{
    page *const p = user;
    float *const planes[1] = {p->planes[0]};
    air_dilate_params params;
    air_dilate_params_default(&params);
    return air_dilate(context, WIDTH, HEIGHT, p->charts, &params, planes, 1);
}

static void want_of_memory_is_reported(void **state)
{
    static page p;
    (void)state;
    make_page(&p, 0.1f, 1);
    assert_shortage_survived(try_dilate, &p, 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(free_texels_take_the_nearest),
        cmocka_unit_test(gutters_take_their_own_chart),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
