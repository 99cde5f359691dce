/* Rendering as callers see it: the same bytes however the work is cut up, terms that sum, variances
 * that are true. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "image/film.h"
#include "small_room.h"

enum { WIDTH = 24, HEIGHT = 16 };

static air_context *make_context(size_t threads)
{
    air_context_params params;
    air_context *context;
    air_context_params_default(&params);
    params.thread_count = threads;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    return context;
}

static air_render_params small_picture(uint32_t begin, uint32_t end)
{
    air_render_params params;
    air_render_params_default(&params);
    params.width = WIDTH;
    params.height = HEIGHT;
    params.sample_begin = begin;
    params.sample_end = end;
    params.max_depth = 6;
    params.layers = true;
    return params;
}

static void assert_same_film(const air_film *a, const air_film *b)
{
    assert_int_equal(a->node_count, b->node_count);
    for (size_t i = 0; i < a->node_count; i++) {
        assert_memory_equal(a->nodes[i].sums, b->nodes[i].sums,
                            air_film_pixel_count(a) * a->layout.stride * sizeof(double));
    }
}

static void threads_and_tiles_change_no_byte(void **state)
{
    (void)state;
    air_film *reference = NULL;
    for (size_t threads = 1; threads <= 3; threads++) {
        air_context *context = make_context(threads);
        air_snapshot *snapshot;
        air_film *film;
        air_render_params params = small_picture(0, 32);
        params.tile_size = threads == 2 ? 5 : 32;
        params.guides = true;
        assert_int_equal(room_make(context, true, &snapshot), AIR_OK);
        assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
        air_snapshot_release(snapshot);
        if (reference == NULL) {
            reference = film;
            continue; /* the first context is kept for its film */
        }
        assert_same_film(film, reference);
        air_film_destroy(film);
        air_context_destroy(context);
    }
    air_context *context = reference->context;
    air_film_destroy(reference);
    air_context_destroy(context);
}

static void halves_merge_to_the_bytes_of_the_whole(void **state)
{
    (void)state;
    air_context *context = make_context(2);
    air_snapshot *snapshot;
    air_film *whole, *first, *second;
    assert_int_equal(room_make(context, true, &snapshot), AIR_OK);
    air_render_params params = small_picture(0, 64);
    assert_int_equal(air_render(context, snapshot, &params, &whole), AIR_OK);
    params = small_picture(0, 32);
    assert_int_equal(air_render(context, snapshot, &params, &first), AIR_OK);
    params = small_picture(32, 64);
    assert_int_equal(air_render(context, snapshot, &params, &second), AIR_OK);
    assert_int_equal(air_film_merge(first, second), AIR_OK);
    assert_same_film(first, whole);
    air_film_destroy(whole);
    air_film_destroy(first);
    air_film_destroy(second);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void a_crop_is_that_part_of_the_picture(void **state)
{
    (void)state;
    air_context *context = make_context(2);
    air_snapshot *snapshot;
    air_film *whole, *part;
    assert_int_equal(room_make(context, false, &snapshot), AIR_OK);
    air_render_params params = small_picture(0, 16);
    assert_int_equal(air_render(context, snapshot, &params, &whole), AIR_OK);
    params.crop[0] = 7;
    params.crop[1] = 3;
    params.crop[2] = 12;
    params.crop[3] = 9;
    assert_int_equal(air_render(context, snapshot, &params, &part), AIR_OK);
    const size_t stride = whole->layout.stride;
    for (size_t y = 3; y < 9; y++) {
        assert_memory_equal(part->nodes[0].sums + (y - 3) * 5 * stride,
                            whole->nodes[0].sums + (y * WIDTH + 7) * stride,
                            5 * stride * sizeof(double));
    }
    air_film_destroy(whole);
    air_film_destroy(part);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static double term_sum(const air_film *film, const char *name)
{
    for (uint32_t s = 0; s < film->layout.slot_count; s++) {
        if (strcmp(film->layout.slots[s].name, name) == 0) {
            double sum = 0.0;
            for (size_t p = 0; p < air_film_pixel_count(film); p++) {
                sum +=
                    film->nodes[0].sums[p * film->layout.stride + film->layout.slots[s].offset + 1];
            }
            return sum;
        }
    }
    fail_msg("no term %s", name);
    return 0.0;
}

/* A term on its own uses the numbers it uses in company, so it is not only equal in the mean: what
 * differs is which rays share a packet, hence last bits. Checked to 1e-4 of the picture's sum. */
static void terms_run_apart_sum_to_beauty(void **state)
{
    (void)state;
    air_context *context = make_context(2);
    air_snapshot *snapshot;
    for (int with_grid = 0; with_grid < 2; with_grid++) {
        air_film *all;
        assert_int_equal(room_make(context, with_grid != 0, &snapshot), AIR_OK);
        air_render_params params = small_picture(0, 64);
        assert_int_equal(air_render(context, snapshot, &params, &all), AIR_OK);
        double beauty = 0.0;
        for (int t = 0; t < AIR_TERM_COUNT; t++) {
            beauty += term_sum(all, air_term_name((air_term)t));
        }
        for (int t = 0; t < AIR_TERM_COUNT; t++) {
            air_film *one;
            params.terms = 1u << t;
            assert_int_equal(air_render(context, snapshot, &params, &one), AIR_OK);
            const char *name = air_term_name((air_term)t);
            const double alone = term_sum(one, name), together = term_sum(all, name);
            assert_true(together > 0.0);
            assert_true(fabs(alone - together) <= 1e-4 * beauty);
            air_film_destroy(one);
        }
        air_film_destroy(all);
        air_snapshot_release(snapshot);
    }
    air_context_destroy(context);
}

/* The mean of 64 independent pictures' squared deviations against the variance each claims. A
 * pixel's ratio scatters by sqrt(2/15) relative, so the mean over 384 pixels and 16 pictures is
 * known to below 2 %; light-tailed or not, 15 % is far outside. */
static void the_variance_is_that_of_the_mean(void **state)
{
    (void)state;
    enum { PICTURES = 16, PIXELS = WIDTH * HEIGHT };
    static double mean[PIXELS], square[PIXELS], claimed[PIXELS];
    air_context *context = make_context(2);
    air_snapshot *snapshot;
    assert_int_equal(room_make(context, false, &snapshot), AIR_OK);
    for (uint64_t i = 0; i < PICTURES; i++) {
        air_film *film;
        air_image *image;
        air_render_params params = small_picture(0, 64);
        params.seed = i + 1;
        params.variance_replicates = 16;
        assert_int_equal(air_render(context, snapshot, &params, &film), AIR_OK);
        assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
        const float *g = air_image_plane(image, 1);
        const float *v =
            air_image_plane(image, (size_t)air_image_find_channel(image, "variance.G"));
        for (size_t p = 0; p < PIXELS; p++) {
            mean[p] += (double)g[p] / PICTURES;
            square[p] += (double)g[p] * (double)g[p] / PICTURES;
            claimed[p] += (double)v[p] / PICTURES;
        }
        air_image_destroy(image);
        air_film_destroy(film);
    }
    double observed_sum = 0.0, claimed_sum = 0.0;
    for (size_t p = 0; p < PIXELS; p++) {
        observed_sum += (square[p] - mean[p] * mean[p]) * PICTURES / (PICTURES - 1);
        claimed_sum += claimed[p];
    }
    assert_true(claimed_sum > 0.0);
    assert_true(fabs(observed_sum / claimed_sum - 1.0) < 0.15);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static bool stop_at_once(void *user, double fraction, const char *what)
{
    (void)user;
    (void)fraction;
    (void)what;
    return false;
}

static void an_interrupted_render_keeps_whole_passes(void **state)
{
    (void)state;
    air_context_params context_params;
    air_context *context;
    air_snapshot *snapshot;
    air_film *film;
    uint32_t begin, end;
    air_context_params_default(&context_params);
    context_params.progress = stop_at_once;
    assert_int_equal(air_context_create(&context_params, &context), AIR_OK);
    assert_int_equal(room_make(context, false, &snapshot), AIR_OK);
    air_render_params params = small_picture(0, 64);
    params.tile_size = 4;
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_INTERRUPTED);
    air_film_samples(film, &begin, &end);
    assert_int_equal(end, 0);
    air_film_destroy(film);
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

static void bad_parameters_are_named(void **state)
{
    (void)state;
    air_context *context = make_context(1);
    air_snapshot *snapshot;
    air_film *film;
    assert_int_equal(room_make(context, false, &snapshot), AIR_OK);
    air_render_params params = small_picture(8, 64);
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "8:64"));
    params = small_picture(0, 64);
    params.width = 70000;
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "70000"));
    params = small_picture(0, 64);
    params.methods = "lamp=path";
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "lamp"));
    params.methods = "magic";
    assert_int_equal(air_render(context, snapshot, &params, &film), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "magic"));
    air_snapshot_release(snapshot);
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_and_tiles_change_no_byte),
        cmocka_unit_test(halves_merge_to_the_bytes_of_the_whole),
        cmocka_unit_test(a_crop_is_that_part_of_the_picture),
        cmocka_unit_test(terms_run_apart_sum_to_beauty),
        cmocka_unit_test(the_variance_is_that_of_the_mean),
        cmocka_unit_test(an_interrupted_render_keeps_whole_passes),
        cmocka_unit_test(bad_parameters_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
