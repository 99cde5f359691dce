/* Packing: items apart and on their pages, pages small, errors that say what is needed. */
#include "atlas/pack.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "atlas_fixture.h"
#include "memory_shortage.h"

enum { ITEMS = 400 };

/* Sizes from 1 to 64 texels, many of them small. */
static void make_items(air_pack_item *items, size_t count, uint32_t seed)
{
    air_rng rng = air_rng_from_keys(seed, 3);
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 2; k++) {
            items[i].size[k] = pow(64.0, (double)air_rng_float(&rng));
        }
        items[i].fixed = i % 5 == 0;
    }
}

static air_pack *pack(air_context *context, const air_pack_item *items, size_t count,
                      const air_pack_params *params)
{
    air_pack *self = NULL;
    assert_int_equal(air_pack_create(context, items, count, params, &self), AIR_OK);
    return self;
}

/* Each item has its size, with padding around it that is nobody else's, all on its page. */
static void check_places(const air_pack_item *items, const air_pack *self,
                         const air_pack_params *params)
{
    const uint32_t p = params->padding;
    uint8_t *taken[64] = {NULL};
    assert_true(self->page_count <= 64);
    for (size_t i = 0; i < self->page_count; i++) {
        const air_pack_page page = self->pages[i];
        assert_true(page.width <= params->max_size && page.height <= params->max_size);
        if (params->power_of_two) {
            assert_int_equal(page.width & (page.width - 1), 0);
            assert_int_equal(page.height & (page.height - 1), 0);
        }
        taken[i] = atlas_zeros((size_t)page.width * page.height, 1);
    }
    for (size_t i = 0; i < self->item_count; i++) {
        const air_pack_place *at = &self->places[i];
        const int x = at->turned ? 1 : 0;
        assert_int_equal(at->width, fmax(ceil(items[i].size[x] * self->scale - 1e-6), 1.0));
        assert_int_equal(at->height, fmax(ceil(items[i].size[1 - x] * self->scale - 1e-6), 1.0));
        assert_false(at->turned && (items[i].fixed || !params->turn));
        assert_true(at->page < self->page_count);
        const air_pack_page page = self->pages[at->page];
        assert_true(at->x >= p && at->x + at->width + p <= page.width);
        assert_true(at->y >= p && at->y + at->height + p <= page.height);
        for (size_t v = at->y - p; v < at->y + at->height + p; v++) {
            for (size_t u = at->x - p; u < at->x + at->width + p; u++) {
                assert_int_equal(taken[at->page][v * page.width + u]++, 0);
            }
        }
    }
    for (size_t i = 0; i < self->page_count; i++) {
        free(taken[i]);
    }
}

static void items_are_apart_and_on_their_pages(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    air_pack_item items[ITEMS];
    air_pack_params params;
    for (uint32_t i = 0; i < 16; i++) {
        air_pack_params_default(&params);
        make_items(items, ITEMS, i);
        params.padding = i % 4;
        params.power_of_two = (i & 4) == 0;
        params.turn = (i & 8) == 0;
        params.max_size = i % 3 == 0 ? 129 : 4096;
        air_pack *self = pack(context, items, ITEMS, &params);
        check_places(items, self, &params);
        assert_true(params.max_size == 129 ? self->page_count > 1 : self->page_count == 1);
        assert_true(self->scale == 1.0);
        air_pack_destroy(context, self);
    }
    air_context_destroy(context);
}

/* 400 items fill more than four fifths of a page as small as it can be (their paddings apart), and
 * sixteen squares all of it. */
static void pages_are_small(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    air_pack_item items[ITEMS];
    air_pack_params params;
    air_pack_params_default(&params);
    params.padding = 0;
    params.power_of_two = false;
    make_items(items, ITEMS, 1);
    air_pack *self = pack(context, items, ITEMS, &params);
    (void)printf("%d items: %u x %u, utilisation %.3f\n", ITEMS, self->pages[0].width,
                 self->pages[0].height, self->utilisation);
    assert_true(self->utilisation > 0.8);
    air_pack_destroy(context, self);
    for (size_t i = 0; i < 16; i++) {
        items[i] = (air_pack_item){{15.0, 15.0}, false};
    }
    self = pack(context, items, 16, &params);
    assert_true(self->utilisation == 1.0);
    air_pack_destroy(context, self);
    params.power_of_two = true;
    params.padding = 2; /* 19 texels each: 6 in a row of 128, 3 rows: 64 */
    self = pack(context, items, 16, &params);
    assert_int_equal(self->page_count, 1);
    assert_int_equal(self->pages[0].width * self->pages[0].height, 128 * 64);
    air_pack_destroy(context, self);
    self = pack(context, items, 0, &params); /* nothing on nothing */
    assert_int_equal(self->page_count, 0);
    air_pack_destroy(context, self);
    air_context_destroy(context);
}

/* A stick as long as a page fits lying or standing; fixed ones stay. */
static void sticks_are_turned(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    air_pack_item items[64];
    air_pack_params params;
    air_pack_params_default(&params);
    params.padding = 0;
    params.max_size = 64;
    for (size_t i = 0; i < 64; i++) {
        items[i] = (air_pack_item){{i % 2 == 0 ? 64.0 : 1.0, i % 2 == 0 ? 1.0 : 64.0}, false};
    }
    air_pack *self = pack(context, items, 64, &params);
    assert_int_equal(self->page_count, 1);
    assert_true(self->utilisation == 1.0);
    check_places(items, self, &params);
    air_pack_destroy(context, self);
    params.turn = false;
    self = pack(context, items, 64, &params);
    assert_int_equal(self->page_count, 2);
    air_pack_destroy(context, self);
    air_context_destroy(context);
}

/* Corners of an item go to corners of its place, turned without mirroring. */
static void points_go_with_their_items(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    const air_pack_item items[2] = {{{40.0, 8.0}, false}, {{8.0, 40.0}, false}};
    air_pack_params params;
    air_pack_params_default(&params);
    air_pack *self = pack(context, items, 2, &params);
    assert_true(self->places[0].turned != self->places[1].turned);
    for (size_t i = 0; i < 2; i++) {
        const double corners[3][2] = {{0.0, 0.0}, {items[i].size[0], 0.0}, {0.0, items[i].size[1]}};
        const air_pack_place *at = &self->places[i];
        double p[3][2];
        for (int k = 0; k < 3; k++) {
            air_pack_point(self, i, corners[k], p[k]);
            assert_true(p[k][0] == at->x || p[k][0] == at->x + at->width);
            assert_true(p[k][1] == at->y || p[k][1] == at->y + at->height);
        }
        const double turn =
            (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
        assert_true(turn == 320.0);
    }
    air_pack_destroy(context, self);
    air_context_destroy(context);
}

/* Scaled items fill one page; 1 % more would not (a thousandth is the step, and packing is not
 * monotonic to the last). */
static void density_shrinks_to_fit(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    air_pack_item items[ITEMS];
    air_pack_params params;
    air_pack_params_default(&params);
    params.scale_to_fit = true;
    params.max_size = 256;
    make_items(items, ITEMS, 2);
    items[3].size[0] = 5000.0; /* larger than a page */
    air_pack *self = pack(context, items, ITEMS, &params);
    check_places(items, self, &params);
    assert_int_equal(self->page_count, 1);
    assert_true(self->scale < 252.0 / 5000.0 + 1e-9 && self->scale > 0.04);
    air_pack_destroy(context, self);
    items[3].size[0] = 20.0;
    self = pack(context, items, ITEMS, &params);
    check_places(items, self, &params);
    assert_int_equal(self->page_count, 1);
    const double scale = self->scale;
    (void)printf("scaled by %.3f: utilisation %.3f\n", scale, self->utilisation);
    assert_true(scale > 0.2 && scale < 1.0);
    air_pack_destroy(context, self);
    params.max_size = 4096;
    self = pack(context, items, ITEMS, &params);
    assert_true(self->scale == 1.0);
    air_pack_destroy(context, self);
    params.max_size = 64; /* 400 texels with their paddings need 100 x 100 */
    assert_int_equal(air_pack_create(context, items, ITEMS, &params, &self), AIR_ERROR_ARGUMENT);
    air_context_destroy(context);
}

static void the_same_comes_out_each_time(void **state)
{
    (void)state;
    air_context *contexts[2] = {atlas_context(1), atlas_context(3)};
    air_pack *both[2];
    air_pack_item items[ITEMS];
    air_pack_params params;
    air_pack_params_default(&params);
    params.max_size = 128;
    make_items(items, ITEMS, 7);
    for (int i = 0; i < 2; i++) {
        both[i] = pack(contexts[i], items, ITEMS, &params);
    }
    for (size_t i = 0; i < ITEMS; i++) {
        const air_pack_place *a = &both[0]->places[i], *b = &both[1]->places[i];
        assert_true(a->page == b->page && a->x == b->x && a->y == b->y && a->turned == b->turned);
    }
    for (int i = 0; i < 2; i++) {
        air_pack_destroy(contexts[i], both[i]);
        air_context_destroy(contexts[i]);
    }
}

static void what_does_not_fit_is_named(void **state)
{
    (void)state;
    air_context *context = atlas_context(1);
    air_pack_item items[3] = {{{10.0, 10.0}, false}, {{300.5, 20.0}, false}, {{9.0, 9.0}, false}};
    air_pack_params params;
    air_pack *self;
    air_pack_params_default(&params);
    params.max_size = 256;
    assert_int_equal(air_pack_create(context, items, 3, &params, &self), AIR_ERROR_ARGUMENT);
    assert_null(self);
    assert_non_null(strstr(air_context_last_error(context), "item 1 of 301 x 20"));
    assert_non_null(strstr(air_context_last_error(context), "305 texels"));
    items[1].size[0] = 200.0;
    items[0].size[0] = items[0].size[1] = 200.0;
    params.max_pages = 1;
    params.max_size = 208;
    params.power_of_two = false;
    assert_int_equal(air_pack_create(context, items, 3, &params, &self), AIR_ERROR_ARGUMENT);
    assert_non_null(strstr(air_context_last_error(context), "need 2 pages"));
    params.max_pages = 2;
    self = pack(context, items, 3, &params);
    check_places(items, self, &params);
    air_pack_destroy(context, self);
    items[2].size[1] = -1.0;
    assert_int_equal(air_pack_create(context, items, 3, &params, &self), AIR_ERROR_ARGUMENT);
    items[2].size[1] = INFINITY;
    assert_int_equal(air_pack_create(context, items, 3, &params, &self), AIR_ERROR_ARGUMENT);
    params.padding = 104;
    assert_int_equal(air_pack_create(context, items, 2, &params, &self), AIR_ERROR_ARGUMENT);
    params.max_size = 0;
    assert_int_equal(air_pack_create(context, items, 2, &params, &self), AIR_ERROR_ARGUMENT);
    air_context_destroy(context);
}

static air_status try_pack(air_context *context, void *items)
{
    air_pack_params params;
    air_pack *self = NULL;
    air_pack_params_default(&params);
    params.max_size = 128;
    params.scale_to_fit = true;
    const air_status status = air_pack_create(context, items, 20, &params, &self);
    air_pack_destroy(context, self);
    return status;
}

static void want_of_memory_is_reported(void **state)
{
    (void)state;
    air_pack_item items[20];
    make_items(items, 20, 4);
    assert_shortage_survived(try_pack, items, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(items_are_apart_and_on_their_pages),
        cmocka_unit_test(pages_are_small),
        cmocka_unit_test(sticks_are_turned),
        cmocka_unit_test(points_go_with_their_items),
        cmocka_unit_test(density_shrinks_to_fit),
        cmocka_unit_test(the_same_comes_out_each_time),
        cmocka_unit_test(what_does_not_fit_is_named),
        cmocka_unit_test(want_of_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
