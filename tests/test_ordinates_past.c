/* What method ordinates keeps from picture to picture: light resampled, skies and importance. */
#include "render/ordinates/past.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/ordinates_lights.h"
#include "cmocka_test.h"
#include "core/host.h"

enum { BANDS = 2, NUMBERS = BANDS * BANDS * AIR_DOM_STRIDE, KEY = 5 };

static const air_dom_params dom_params = {.bands = BANDS, .delta_m = true};
static const double ones[3] = {1.0, 1.0, 1.0};

static air_context *make_context(void)
{
    air_context *context;
    assert_int_equal(air_context_create(NULL, &context), AIR_OK);
    return context;
}

static ord_domain make_domain(float x, float y, float z, float cell_m, size_t side)
{
    ord_domain out = {.origin = {x, y, z}, .cell_m = cell_m, .size = {side, side + 1, side + 2}};
    out.cells = side * (side + 1) * (side + 2);
    return out;
}

/* A field that is linear in space, other in each number of a cell, at a cell's centre held within
 * bounds. */
static float linear(const ord_domain *domain, size_t cell, size_t number, const ord_domain *bounds)
{
    const float slopes[3] = {0.7f, -0.4f, 0.2f};
    float sum = 5.0f + (float)(ptrdiff_t)number;
    size_t at[3];
    ord_domain_cell(domain, cell, at);
    for (int axis = 0; axis < 3; axis++) {
        const float half = 0.5f * bounds->cell_m, low = bounds->origin[axis] + half;
        const float high =
            bounds->origin[axis] + (float)(ptrdiff_t)bounds->size[axis] * bounds->cell_m - half;
        const float place =
            domain->origin[axis] + ((float)(ptrdiff_t)at[axis] + 0.5f) * domain->cell_m;
        sum += slopes[axis] * fminf(fmaxf(place, low), high);
    }
    return number % AIR_DOM_STRIDE == 3 ? 0.0f : sum;
}

/* A past that holds the field in the domain; to be finished. */
static void keep_linear(air_context *context, const ord_domain *domain, ord_past *out)
{
    ord_past_init(context, out);
    float *const moments = air_allocate(context, domain->cells * NUMBERS, sizeof *moments);
    assert_non_null(moments);
    for (size_t i = 0; i < domain->cells * NUMBERS; i++) {
        moments[i] = linear(domain, i / NUMBERS, i % NUMBERS, domain);
    }
    ord_past_keep_light(out, domain, &dom_params, ones, KEY, moments);
}

/* Trilinear is exact for what is linear; beyond the outermost centres their light holds. */
static void light_is_resampled_between_boxes(void **state)
{
    air_context *const context = make_context();
    const ord_domain old = make_domain(-1.0f, 0.5f, 2.0f, 0.25f, 6);
    const ord_domain others[4] = {old, make_domain(-0.9f, 0.6f, 2.2f, 0.25f, 5),
                                  make_domain(-1.0f, 0.5f, 2.0f, 0.11f, 9),
                                  make_domain(-2.0f, 0.0f, 1.0f, 0.5f, 7)};
    const double twice[3] = {2.0, 1.0, 0.5};
    ord_past past;
    (void)state;
    keep_linear(context, &old, &past);
    for (int n = 0; n < 4; n++) {
        const size_t count = others[n].cells * NUMBERS;
        float *const moments = malloc(count * sizeof *moments);
        assert_non_null(moments);
        ord_past_begin(&past);
        assert_true(ord_past_light_at(&past, &others[n], &dom_params, twice, moments));
        assert_true(past.history != 0);
        for (size_t i = 0; i < count; i++) {
            const float scale = i % AIR_DOM_STRIDE < 3 ? (float)twice[i % AIR_DOM_STRIDE] : 1.0f;
            const float expected = scale * linear(&others[n], i / NUMBERS, i % NUMBERS, &old);
            assert_float_equal(moments[i], expected, 2e-5f);
        }
        free(moments);
    }
    ord_past_finish(&past);
    air_context_destroy(context);
}

/* On a lattice that moved with its medium the light stays in its cells. */
static void light_goes_along_with_the_lattice(void **state)
{
    air_context *const context = make_context();
    const ord_domain old = make_domain(0.0f, 0.0f, 0.0f, 0.25f, 3);
    ord_domain moved = old;
    float moments[3 * 4 * 5 * NUMBERS];
    ord_past past;
    (void)state;
    keep_linear(context, &old, &past);
    moved.origin[1] += 0.7f;
    moved.lattice.base[1] += 0.7f;
    moved.goes_on = true;
    assert_true(ord_past_light_at(&past, &moved, &dom_params, ones, moments));
    for (size_t i = 0; i < old.cells * NUMBERS; i++) {
        assert_float_equal(moments[i], linear(&old, i / NUMBERS, i % NUMBERS, &old), 1e-5f);
    }
    ord_past_finish(&past);
    air_context_destroy(context);
}

static void light_that_does_not_fit_is_not_used(void **state)
{
    air_context *const context = make_context();
    const ord_domain old = make_domain(0.0f, 0.0f, 0.0f, 0.25f, 3);
    const double dark[3] = {0.0, 0.0, 0.0};
    air_dom_params other = dom_params;
    float moments[3 * 4 * 5 * NUMBERS];
    ord_past past;
    (void)state;
    ord_past_init(context, &past);
    assert_false(ord_past_light_at(NULL, &old, &dom_params, ones, moments));
    assert_false(ord_past_light_at(&past, &old, &dom_params, ones, moments));
    ord_past_finish(&past);
    keep_linear(context, &old, &past);
    other.bands = BANDS + 1;
    assert_false(ord_past_light_at(&past, &old, &other, ones, moments));
    other = dom_params;
    other.delta_m = false;
    assert_false(ord_past_light_at(&past, &old, &other, ones, moments));
    assert_false(ord_past_light_at(&past, &old, &dom_params, dark, moments));
    assert_true(past.history == 0);
    ord_past_finish(&past);
    air_context_destroy(context);
}

static void a_solution_is_that_of_the_same_problem(void **state)
{
    air_context *const context = make_context();
    const ord_domain old = make_domain(0.0f, 0.0f, 0.0f, 0.25f, 3);
    float moments[3 * 4 * 5 * NUMBERS];
    ord_past past;
    (void)state;
    ord_past_init(context, &past);
    assert_false(ord_past_solution(&past, 0, moments));
    ord_past_finish(&past);
    keep_linear(context, &old, &past);
    assert_false(ord_past_solution(&past, KEY + 1, moments));
    assert_true(past.history == 0);
    assert_true(ord_past_solution(&past, KEY, moments));
    assert_true(past.history != 0);
    for (size_t i = 0; i < old.cells * NUMBERS; i++) {
        assert_true(moments[i] == linear(&old, i / NUMBERS, i % NUMBERS, &old));
    }
    ord_past_finish(&past);
    air_context_destroy(context);
}

/* ---- skies ---- */

enum { WIDE = 8, HIGH = 4 };

static float *make_pixels(float value)
{
    float *const pixels = malloc(WIDE * HIGH * 3 * sizeof *pixels);
    assert_non_null(pixels);
    for (int i = 0; i < WIDE * HIGH * 3; i++) {
        pixels[i] = value + (float)(i % 7);
    }
    return pixels;
}

/* Found by its values, wherever they are; gone when a picture did without it. */
static void skies_are_found_by_their_values(void **state)
{
    air_context *const context = make_context();
    const ord_domain domain = make_domain(0.0f, 0.0f, 0.0f, 1.0f, 1);
    air_environment_ordinates *first, *again, *other;
    air_environment_map map;
    air_environment_choice choice;
    air_ordinate a[4], b[4];
    ord_past past;
    (void)state;
    float *const pixels = make_pixels(1.0f), *const copy = make_pixels(1.0f);
    float *const changed = make_pixels(2.0f);
    ord_past_init(context, &past);
    air_environment_map_default(&map);
    map.pixels = pixels;
    map.width = WIDE;
    map.height = HIGH;
    map.pixel_stride = 3;
    map.row_stride = 3 * WIDE;
    air_environment_choice_default(&choice);
    choice.count = 4;
    ord_past_begin(&past);
    assert_int_equal(ord_past_prepare_sky(&past, context, &map, &first), AIR_OK);
    assert_int_equal(air_environment_ordinates_choose(context, first, &choice, a), AIR_OK);
    ord_past_release_sky(&past, first);
    ord_past_end(&past, &domain);
    free(pixels);
    map.pixels = copy;
    ord_past_begin(&past);
    assert_int_equal(ord_past_prepare_sky(&past, context, &map, &again), AIR_OK);
    assert_ptr_equal(again, first);
    assert_int_equal(air_environment_ordinates_choose(context, again, &choice, b), AIR_OK);
    assert_memory_equal(a, b, sizeof a);
    ord_past_end(&past, &domain);
    map.pixels = changed;
    ord_past_begin(&past);
    assert_int_equal(ord_past_prepare_sky(&past, context, &map, &other), AIR_OK);
    assert_ptr_not_equal(other, first);
    assert_int_equal(past.sky_count, 2);
    ord_past_end(&past, &domain);
    assert_int_equal(past.sky_count, 1);
    ord_past_finish(&past);
    free(copy);
    free(changed);
    air_context_destroy(context);
}

/* ---- importance ---- */

static void importance_is_mixed_with_that_of_the_last_whole_picture(void **state)
{
    air_context *const context = make_context();
    const ord_domain domain = make_domain(0.0f, 0.0f, 0.0f, 1.0f, 1);
    static const float values[4] = {1.0f, 2.0f, 6.0f, 6.0f},
                       expected[4] = {1.0f, 1.2f, 2.16f, 2.16f};
    float map[ORD_IMPORTANCE_TEXELS];
    ord_past past;
    (void)state;
    ord_past_init(context, &past);
    for (int n = 0; n < 4; n++) {
        for (int i = 0; i < ORD_IMPORTANCE_TEXELS; i++) {
            map[i] = values[n];
        }
        ord_past_begin(&past);
        ord_past_mix_importance(&past, map);
        assert_float_equal(map[7], expected[n], 1e-6f);
        if (n != 2) { /* the third picture failed */
            ord_past_end(&past, &domain);
        }
    }
    ord_past_mix_importance(NULL, map);
    ord_past_finish(&past);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_is_resampled_between_boxes),
        cmocka_unit_test(light_goes_along_with_the_lattice),
        cmocka_unit_test(light_that_does_not_fit_is_not_used),
        cmocka_unit_test(a_solution_is_that_of_the_same_problem),
        cmocka_unit_test(skies_are_found_by_their_values),
        cmocka_unit_test(importance_is_mixed_with_that_of_the_last_whole_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
