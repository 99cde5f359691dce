#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "image/film.h"

enum { WIDTH = 3, HEIGHT = 2, PIXELS = WIDTH * HEIGHT };

static air_context *context;

static int set_up(void **state)
{
    (void)state;
    return air_context_create(NULL, &context) == AIR_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    air_context_destroy(context);
    return 0;
}

static air_film *make_film(void)
{
    air_film description, *film;
    memset(&description, 0, sizeof description);
    description.width = WIDTH;
    description.height = HEIGHT;
    description.crop[2] = WIDTH;
    description.crop[3] = HEIGHT;
    description.seed = 7;
    air_film_layout_add(&description.layout, AIR_SLOT_TERM, "S0", 3);
    air_film_layout_add(&description.layout, AIR_SLOT_TERM, "M1", 3);
    assert_int_equal(air_film_create(context, &description, &film), AIR_OK);
    return film;
}

/* What sample s of a pixel adds to sum k: values whose sum depends on the order of adding. */
static double sample_value(size_t pixel, uint32_t s, uint32_t k)
{
    const uint32_t bits = ((uint32_t)pixel * 747796405u + s * 2891336453u + k * 277803737u) >> 3;
    return (double)bits * 1e-3 + 1.0 / (1.0 + s);
}

/* Adds samples [begin, end) as a render pass does. */
static void add_samples(air_film *film, uint32_t begin, uint32_t end)
{
    const uint32_t stride = film->layout.stride;
    double block[8], sums[(AIR_FILM_MAX_LEVELS + 1) * 8];
    air_block_stack stack = {.stride = stride, .sums = sums};
    while (begin < end) {
        const uint32_t stop = air_film_node_end(begin, end);
        air_film_node node;
        assert_int_equal(air_film_node_create(film, begin, stop, &node), AIR_OK);
        for (size_t pixel = 0; pixel < PIXELS; pixel++) {
            for (uint32_t b = begin; b < stop; b += AIR_FILM_BLOCK) {
                memset(block, 0, sizeof block);
                for (uint32_t s = b; s < stop && s < b + AIR_FILM_BLOCK; s++) {
                    for (uint32_t k = 0; k < stride; k++) {
                        block[k] += sample_value(pixel, s, k);
                    }
                }
                air_block_stack_push(&stack, block);
            }
            air_block_stack_total(&stack, node.sums + pixel * stride);
        }
        assert_int_equal(air_film_add(film, &node), AIR_OK);
        begin = stop;
    }
}

static void assert_same_sums(const air_film *a, const air_film *b)
{
    assert_int_equal(a->node_count, b->node_count);
    for (size_t i = 0; i < a->node_count; i++) {
        assert_int_equal(a->nodes[i].begin, b->nodes[i].begin);
        assert_int_equal(a->nodes[i].end, b->nodes[i].end);
        assert_memory_equal(a->nodes[i].sums, b->nodes[i].sums,
                            PIXELS * a->layout.stride * sizeof(double));
    }
}

static void any_split_at_blocks_gives_the_same_bytes(void **state)
{
    (void)state;
    static const uint32_t ends[] = {16, 48, 64, 112, 250};
    for (size_t e = 0; e < sizeof ends / sizeof *ends; e++) {
        air_film *whole = make_film();
        add_samples(whole, 0, ends[e]);
        for (uint32_t cut = 16; cut < ends[e]; cut += 16) {
            air_film *first = make_film(), *second = make_film();
            add_samples(first, 0, cut);
            add_samples(second, cut, ends[e]);
            assert_int_equal(air_film_merge(second, first), AIR_OK); /* in any order */
            assert_same_sums(second, whole);
            air_film_destroy(first);
            air_film_destroy(second);
        }
        air_film_destroy(whole);
    }
}

static void merging_refuses_what_does_not_fit(void **state)
{
    (void)state;
    air_film *a = make_film(), *b = make_film();
    add_samples(a, 0, 32);
    add_samples(b, 16, 48);
    assert_int_equal(air_film_merge(a, b), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "0:32"));
    air_film_destroy(b);
    b = make_film();
    b->seed = 8;
    add_samples(b, 32, 48);
    assert_int_equal(air_film_merge(a, b), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "seeds"));
    air_film_destroy(a);
    air_film_destroy(b);
}

static void terms_sum_to_beauty_and_a_ratio_divides_its_sums(void **state)
{
    (void)state;
    air_film description, *film;
    air_film_node node;
    air_image *image;
    memset(&description, 0, sizeof description);
    description.width = description.height = description.crop[2] = description.crop[3] = 1;
    air_film_layout_add(&description.layout, AIR_SLOT_TERM, "S0", 3);
    air_film_layout_add(&description.layout, AIR_SLOT_RATIO, "M1", 12);
    air_film_layout_add(&description.layout, AIR_SLOT_GUIDE, "depth", 1);
    assert_int_equal(air_film_create(context, &description, &film), AIR_OK);
    assert_int_equal(air_film_node_create(film, 0, 16, &node), AIR_OK);
    const double sums[16] = {16,
                             32,
                             48,
                             /* analytic */ 8,
                             8,
                             8,
                             /* unoccluded */ 4,
                             4,
                             0,
                             /* occluded */ 1,
                             3,
                             0,
                             /* plain */ 0,
                             8,
                             4,
                             /* depth */ 80};
    memcpy(node.sums, sums, sizeof sums);
    assert_int_equal(air_film_add(film, &node), AIR_OK);
    assert_int_equal(air_film_resolve(film, NULL, &image), AIR_OK);
    assert_int_equal(air_image_channel_count(image), 10);
    const float expected[10] = {1.125f, 2.875f, 3.25f,  1.0f,  2.0f,
                                3.0f,   0.125f, 0.875f, 0.25f, 5.0f};
    for (size_t c = 0; c < 10; c++) {
        assert_float_equal(air_image_plane(image, c)[0], expected[c], 0.0f);
    }
    assert_string_equal(air_image_channel_name(image, 6), "M1.R");
    assert_string_equal(air_image_channel_name(image, 9), "depth.Z");
    air_image_destroy(image);
    air_film_destroy(film);
}

static void an_empty_film_does_not_resolve(void **state)
{
    (void)state;
    air_film *film = make_film();
    air_image *image = (air_image *)&film;
    assert_int_equal(air_film_resolve(film, NULL, &image), AIR_ERROR_ARGUMENT);
    assert_null(image);
    air_film_destroy(film);
}

static void make_path(char path[64], const char *name)
{
    (void)snprintf(path, 64, "%s-%ld.film", name, (long)getpid());
}

static void a_film_comes_back_from_its_file(void **state)
{
    (void)state;
    char path[64];
    air_film *film = make_film(), *back;
    make_path(path, "round-trip");
    add_samples(film, 0, 48);
    assert_int_equal(air_film_set_attribute(film, "airlight:seed", "7"), AIR_OK);
    assert_int_equal(air_film_save(film, path), AIR_OK);
    assert_int_equal(air_film_load(context, path, &back), AIR_OK);
    assert_same_sums(film, back);
    assert_string_equal(back->attributes[0].value, "7");
    assert_int_equal(air_film_merge(back, film), AIR_ERROR_ARGUMENT);
    air_film_destroy(film);
    air_film_destroy(back);
    (void)remove(path);
}

static void every_truncation_of_a_film_file_is_refused(void **state)
{
    (void)state;
    char path[64];
    void *data;
    size_t size;
    air_film *film = make_film(), *back;
    make_path(path, "truncated");
    add_samples(film, 0, 16);
    assert_int_equal(air_film_set_attribute(film, "a", "b"), AIR_OK);
    assert_int_equal(air_film_save(film, path), AIR_OK);
    assert_int_equal(air_file_read(context, path, &data, &size), AIR_OK);
    for (size_t cut = 0; cut < size; cut++) {
        assert_int_equal(air_file_write(context, path, data, cut), AIR_OK);
        assert_int_equal(air_film_load(context, path, &back), AIR_ERROR_FORMAT);
        assert_null(back);
        assert_non_null(strstr(air_context_last_error(context), path));
    }
    air_free(context, data);
    air_film_destroy(film);
    (void)remove(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_split_at_blocks_gives_the_same_bytes),
        cmocka_unit_test(merging_refuses_what_does_not_fit),
        cmocka_unit_test(terms_sum_to_beauty_and_a_ratio_divides_its_sums),
        cmocka_unit_test(an_empty_film_does_not_resolve),
        cmocka_unit_test(a_film_comes_back_from_its_file),
        cmocka_unit_test(every_truncation_of_a_film_file_is_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
