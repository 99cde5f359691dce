/* Images as containers of named planes and attributes. */
#include "failing_allocator.h"
#include "image_fixture.h"

static void new_images_are_zero_and_know_their_channels(void **state)
{
    static const char *const names[3] = {"S0.R", "A", "variance.G"};
    image_fixture *self = *state;
    air_image *image = image_make(self, 5, 3, 3, names);
    assert_int_equal(air_image_width(image), 5);
    assert_int_equal(air_image_height(image), 3);
    assert_int_equal(air_image_channel_count(image), 3);
    for (size_t c = 0; c < 3; c++) {
        assert_string_equal(air_image_channel_name(image, c), names[c]);
        assert_int_equal(air_image_find_channel(image, names[c]), c);
        for (size_t i = 0; i < 15; i++) {
            assert_true(air_image_plane_const(image, c)[i] == 0.0f);
        }
    }
    assert_int_equal(air_image_find_channel(image, "S0"), -1);
    assert_null(air_image_channel_name(image, 3));
    assert_null(air_image_plane(image, 3));
    assert_null(air_image_plane_const(image, 3));
    air_image_destroy(image);
    air_image_destroy(NULL);
}

static void planes_do_not_overlap(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 7, 4);
    image_fill(image, 1.0f, 2.0f, 3.0f);
    for (size_t c = 0; c < 3; c++) {
        for (size_t i = 0; i < 28; i++) {
            assert_true(air_image_plane(image, c)[i] == (float)(c + 1));
        }
    }
    air_image_destroy(image);
}

static void impossible_images_are_refused(void **state)
{
    static const char *const good[1] = {"Y"};
    static const char *const twice[2] = {"Y", "Y"};
    static const char *const empty[1] = {""};
    static const char *const missing[1] = {NULL};
    const struct {
        size_t width, height, count;
        const char *const *names;
    } cases[] = {{0, 1, 1, good},     {1, 0, 1, good},  {65536, 1, 1, good},
                 {1, 65536, 1, good}, {1, 1, 0, good},  {1, 1, 1024, good},
                 {1, 1, 2, twice},    {1, 1, 1, empty}, {1, 1, 1, missing}};
    image_fixture *self = *state;
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        air_image *image = NULL;
        assert_int_equal(air_image_create(self->context, cases[i].width, cases[i].height,
                                          cases[i].count, cases[i].names, &image),
                         AIR_ERROR_ARGUMENT);
        assert_null(image);
    }
}

static void attributes_are_set_replaced_and_removed(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 1, 1);
    assert_null(air_image_attribute(image, "a"));
    assert_int_equal(air_image_set_attribute(image, "a", "1"), AIR_OK);
    assert_int_equal(air_image_set_attribute(image, "b", "2"), AIR_OK);
    assert_int_equal(air_image_set_attribute(image, "c", ""), AIR_OK);
    assert_int_equal(air_image_set_attribute(image, "a", "one"), AIR_OK);
    assert_int_equal(air_image_attribute_count(image), 3);
    assert_string_equal(air_image_attribute(image, "a"), "one");
    assert_string_equal(air_image_attribute(image, "c"), "");
    assert_int_equal(air_image_set_attribute(image, "b", NULL), AIR_OK);
    assert_int_equal(air_image_set_attribute(image, "never", NULL), AIR_OK);
    assert_int_equal(air_image_attribute_count(image), 2);
    assert_string_equal(air_image_attribute_name(image, 0), "a");
    assert_string_equal(air_image_attribute_name(image, 1), "c");
    assert_null(air_image_attribute_name(image, 2));
    assert_null(air_image_attribute(image, "b"));
    air_image_destroy(image);
}

static void attribute_names_have_limits(void **state)
{
    image_fixture *self = *state;
    air_image *image = image_make_rgb(self, 1, 1);
    char name[257];
    memset(name, 'n', 256);
    name[256] = '\0';
    assert_int_equal(air_image_set_attribute(image, "", "x"), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_image_set_attribute(image, NULL, "x"), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_image_set_attribute(image, name, "x"), AIR_ERROR_ARGUMENT);
    assert_int_equal(air_image_set_attribute(image, name + 1, "x"), AIR_OK);
    assert_int_equal(air_image_attribute_count(image), 1);
    air_image_destroy(image);
}

/* Creates an image with an attribute under an allocator that fails after `allowed` allocations. */
static air_status build_under(long allowed, long *out_live)
{
    static const char *const names[2] = {"R", "G"};
    failing_allocator allocator;
    air_context_params params = failing_params(&allocator, 1000);
    air_context *context = NULL;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    atomic_store(&allocator.remaining, allowed);
    air_image *image = NULL;
    air_status status = air_image_create(context, 4, 4, 2, names, &image);
    if (status == AIR_OK) {
        status = air_image_set_attribute(image, "key", "value");
        air_image_destroy(image);
    }
    atomic_store(&allocator.remaining, 1000);
    air_context_destroy(context);
    *out_live = atomic_load(&allocator.live);
    return status;
}

static void allocation_failures_are_reported_and_leak_nothing(void **state)
{
    (void)state;
    air_status status = AIR_ERROR_MEMORY;
    long live = 0;
    long allowed = 0;
    while (status != AIR_OK) {
        assert_true(allowed < 100);
        status = build_under(allowed, &live);
        assert_true(status == AIR_OK || status == AIR_ERROR_MEMORY);
        assert_int_equal(live, 0);
        allowed++;
    }
    assert_true(allowed > 5); /* the image, its two arrays, two names, the attribute */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(new_images_are_zero_and_know_their_channels,
                                        image_fixture_start, image_fixture_finish),
        cmocka_unit_test_setup_teardown(planes_do_not_overlap, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test_setup_teardown(impossible_images_are_refused, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test_setup_teardown(attributes_are_set_replaced_and_removed,
                                        image_fixture_start, image_fixture_finish),
        cmocka_unit_test_setup_teardown(attribute_names_have_limits, image_fixture_start,
                                        image_fixture_finish),
        cmocka_unit_test(allocation_failures_are_reported_and_leak_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
