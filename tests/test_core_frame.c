/* Names of sequences: the run of #, its length, and what is refused. */
#include "airlight/frame.h"

#include "scene_fixture.h"

static void expect_path(air_context *context, const char *path, int64_t frame, const char *expected)
{
    char buffer[64];
    assert_int_equal(air_frame_path(context, path, frame, buffer, sizeof buffer), AIR_OK);
    assert_string_equal(buffer, expected);
}

static void the_run_becomes_the_number_with_zeros_up_to_its_length(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    expect_path(context, "a.####.exr", 7, "a.0007.exr");
    expect_path(context, "a.####.exr", 0, "a.0000.exr");
    expect_path(context, "a#", 12, "a12");
    expect_path(context, "#########", 1, "000000001");
    expect_path(context, "#########", AIR_FRAME_MAX, "999999999");
    expect_path(context, "a_##_b.vol", 3, "a_03_b.vol");
    air_context_destroy(context);
}

static void numbers_longer_than_the_run_are_written_whole(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    expect_path(context, "a.##.exr", 12345, "a.12345.exr");
    air_context_destroy(context);
}

static void only_the_last_part_of_a_path_is_looked_at(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    size_t digits = 9;
    expect_path(context, "shots#1/##/a.##.exr", 5, "shots#1/##/a.05.exr");
    expect_path(context, "C#/a.exr", 5, "C#/a.exr");
    assert_int_equal(air_frame_digits(context, "C#/a.exr", &digits), AIR_OK);
    assert_int_equal(digits, 0);
    assert_int_equal(air_frame_digits(context, "C#/a.###", &digits), AIR_OK);
    assert_int_equal(digits, 3);
    air_context_destroy(context);
}

static void what_is_no_sequence_is_refused(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    char buffer[16] = "untouched";
    size_t digits = 5;
    static const char *const bad[][2] = {
        {"a##########.exr", "a##########.exr: 10 # in a run, expected at most 9"},
        {"a#b#.exr", "a#b#.exr: several runs of # in the name"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(air_frame_digits(context, bad[i][0], &digits), AIR_ERROR_ARGUMENT);
        fixture_expect_message(context, bad[i][1]);
        assert_int_equal(air_frame_path(context, bad[i][0], 1, buffer, sizeof buffer),
                         AIR_ERROR_ARGUMENT);
    }
    static const int64_t frames[] = {AIR_FRAME_NONE, -5, INT64_MIN, (int64_t)AIR_FRAME_MAX + 1,
                                     INT64_MAX};
    for (size_t i = 0; i < sizeof frames / sizeof frames[0]; i++) {
        assert_int_equal(air_frame_path(context, "a#", frames[i], buffer, sizeof buffer),
                         AIR_ERROR_ARGUMENT);
        fixture_expect_message(context, "expected 0 to 999999999");
    }
    assert_int_equal(air_frame_path(context, NULL, 1, buffer, 1), AIR_ERROR_ARGUMENT);
    assert_int_equal(digits, 5);
    assert_string_equal(buffer, "untouched");
    air_context_destroy(context);
}

static void a_path_needs_room_for_its_end(void **state)
{
    (void)state;
    air_context *context = fixture_context();
    char buffer[11] = "untouched";
    assert_int_equal(air_frame_path(context, "a.####.exr", 7, buffer, 10), AIR_ERROR_ARGUMENT);
    fixture_expect_message(context, "at frame 7 the path has 10 bytes, expected at most 9");
    assert_string_equal(buffer, "untouched");
    assert_int_equal(air_frame_path(context, "a.####.exr", 7, buffer, 11), AIR_OK);
    assert_string_equal(buffer, "a.0007.exr");
    air_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_run_becomes_the_number_with_zeros_up_to_its_length),
        cmocka_unit_test(numbers_longer_than_the_run_are_written_whole),
        cmocka_unit_test(only_the_last_part_of_a_path_is_looked_at),
        cmocka_unit_test(what_is_no_sequence_is_refused),
        cmocka_unit_test(a_path_needs_room_for_its_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
