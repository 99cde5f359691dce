/* What the command does when all is well, and when it is interrupted. */
#include <jansson.h>

#include "cli_result.h"

/* A draft small enough to take no time: 32 x 16 pixels. */
#define SMALL "lit.gltf", "--width", "32", "--medium", "sigma_s=0.1", "--max-depth", "3"

static void help_of_every_command_goes_to_stdout_with_exit_code_0(void **state)
{
    (void)state;
    static const char *const commands[] = {"render", "bake", "info", "diff", "merge", "convert"};
    cli_directory directory;
    cli_enter(&directory);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        const char *const arguments[] = {commands[i], "--help", NULL};
        cli_result result = cli_run(&directory, arguments);
        assert_int_equal(result.exit_code, 0);
        assert_int_equal(cli_count_lines(result.out, "Usage: airlight "), 1);
        assert_int_equal(cli_count_lines(result.out, "Examples:"), 1);
        assert_string_equal(result.err, "");
        cli_free(&result);
    }
    cli_leave(&directory);
}

static void render_writes_the_outputs_asked_for_and_nothing_else(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render",          SMALL,     "--spp", "4",      "-o",
                                            "a.exr",           "-oa.png", "-o",    "a.film", "-q",
                                            "--write-partial", "0.1",     NULL};
    cli_directory directory;
    cli_enter(&directory);
    const size_t entries = cli_count_entries();
    cli_result result = cli_run(&directory, arguments);
    assert_string_equal(result.err, "");
    assert_string_equal(result.out, "");
    assert_int_equal(result.exit_code, 0);
    assert_true(cli_exists("a.exr") && cli_exists("a.png") && cli_exists("a.film"));
    assert_int_equal(cli_count_entries(), entries + 3);
    cli_free(&result);
    cli_leave(&directory);
}

static void render_writes_an_exr_of_the_scenes_name_by_default(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", SMALL, "--spp", "1", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, arguments);
    assert_true(cli_exists("lit.exr"));
    cli_leave(&directory);
}

static void an_exr_tells_how_it_was_made(void **state)
{
    (void)state;
    static const char *const arguments[] = {
        "render",   SMALL,        "--samples", "16:20", "--seed",  "7", "--crop",
        "2,3,12,9", "--exposure", "1.5",       "-o",    "a b.exr", NULL};
    static const char *const expected[][2] = {
        {"airlight:seed", "7"},
        {"airlight:samples", "16:20"},
        {"airlight:exposure", "1.5000"},
        {"airlight:crop", "2,3,12,9"},
        {"airlight:frame", "32x16"},
        {"airlight:max-depth", "3"},
        {"airlight:filter", "box"},
        {"airlight:camera", "Slant"},
        {"airlight:light-units", "photometric"},
        {"airlight:command",
         "airlight render lit.gltf --width 32 --medium sigma_s=0.1 --max-depth 3 --samples 16:20 "
         "--seed 7 --crop 2,3,12,9 --exposure 1.5 -o 'a b.exr'"},
    };
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, arguments);
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        char *const value = cli_attribute(&directory, "a b.exr", expected[i][0]);
        assert_non_null(value);
        assert_string_equal(value, expected[i][1]);
        free(value);
    }
    assert_null(cli_attribute(&directory, "a b.exr", "airlight:partial"));
    cli_leave(&directory);
}

static void statistics_come_as_json_on_stdout(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render",   SMALL, "--spp",  "4",
                                            "--height", "8",   "--json", NULL};
    cli_directory directory;
    cli_enter(&directory);
    json_t *const statistics = cli_run_json(&directory, arguments);
    assert_int_equal(json_integer_value(json_object_get(statistics, "width")), 32);
    assert_int_equal(json_integer_value(json_object_get(statistics, "height")), 8);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(statistics, "samples"), 1)),
                     4);
    assert_true(json_real_value(json_object_get(statistics, "peak_memory_bytes")) > 0.0);
    const double mean = json_real_value(json_array_get(json_object_get(statistics, "mean"), 0));
    assert_true(mean > 0.0); /* a lamp over a floor: not black */
    assert_true(json_is_false(json_object_get(statistics, "interrupted")));
    json_decref(statistics);
    cli_leave(&directory);
}

static void films_of_parts_merge_to_the_bytes_of_one_run(void **state)
{
    (void)state;
    static const char *const first[] = {"render", SMALL, "--samples", "0:16", "-o", "a.film", NULL};
    static const char *const second[] = {"render", SMALL,    "--samples", "16:32",
                                         "-o",     "b.film", NULL};
    static const char *const whole[] = {"render", SMALL,        "--samples", "0:32",
                                        "-o",     "whole.film", NULL};
    static const char *const merge[] = {"merge",       "a.film", "b.film",     "-o",
                                        "merged.film", "-o",     "merged.exr", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, first);
    cli_run_well(&directory, second);
    cli_run_well(&directory, whole);
    cli_run_well(&directory, merge);
    assert_true(cli_same_bytes("whole.film", "merged.film"));
    char *const samples = cli_attribute(&directory, "merged.exr", "airlight:samples");
    assert_string_equal(samples, "0:32");
    free(samples);
    cli_leave(&directory);
}

static void films_of_different_pictures_do_not_merge(void **state)
{
    (void)state;
    static const char *const a[] = {"render", SMALL, "--spp", "16", "-o", "a.film", NULL};
    static const char *const b[] = {"render", SMALL, "--samples", "16:32", "--seed",
                                    "2",      "-o",  "b.film",    NULL};
    static const char *const seeds[] = {"merge", "a.film", "b.film", "-o", "c.film", NULL};
    static const char *const twice[] = {"merge", "a.film", "a.film", "-o", "c.film", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, a);
    cli_run_well(&directory, b);
    const char *const *const merges[] = {seeds, twice};
    static const char *const says[] = {"airlight: error: b.film: ", "airlight: error: a.film: "};
    for (size_t i = 0; i < 2; i++) {
        cli_result result = cli_run(&directory, merges[i]);
        assert_int_equal(result.exit_code, 1);
        assert_int_equal(cli_count_lines(result.err, says[i]), 1);
        assert_int_equal(cli_count_lines(result.err, "airlight: error: "), 1);
        assert_false(cli_exists("c.film"));
        cli_free(&result);
    }
    cli_leave(&directory);
}

static void threads_and_tiles_do_not_change_the_bytes(void **state)
{
    (void)state;
    static const char *const one[] = {"render", SMALL, "--spp",    "8", "-t",
                                      "1",      "-o",  "one.film", NULL};
    static const char *const two[] = {"render",      SMALL, "--spp", "8",        "-t", "2",
                                      "--tile-size", "5",   "-o",    "two.film", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, one);
    cli_run_well(&directory, two);
    assert_true(cli_same_bytes("one.film", "two.film"));
    cli_leave(&directory);
}

static void an_interrupt_leaves_a_marked_picture_and_exit_code_130(void **state)
{
    (void)state;
    /* Would take many minutes; a minute's limit keeps a failing test from hanging. */
    static const char *const arguments[] = {
        "render", SMALL, "--spp",  "1000000000",      "--time", "60", "-o",
        "a.exr",  "-o",  "a.film", "--write-partial", "0.1",    NULL};
    cli_directory directory;
    cli_enter(&directory);
    const pid_t child = cli_start(&directory, arguments);
    cli_interrupt_at(&directory, child, "a.partial.film", "a.exr");
    assert_false(cli_exists("a.partial.exr") || cli_exists("a.partial.film"));
    static const char *const outputs[] = {"a.exr", "a.film"};
    for (size_t i = 0; i < sizeof outputs / sizeof outputs[0]; i++) {
        char *const partial = cli_attribute(&directory, outputs[i], "airlight:partial");
        assert_non_null(partial);
        assert_string_equal(partial, "interrupted");
        free(partial);
    }
    cli_leave(&directory);
}

static void a_time_budget_ends_the_run_well(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", SMALL, "--time", "0.2", "--json", NULL};
    cli_directory directory;
    cli_enter(&directory);
    json_t *const statistics = cli_run_json(&directory, arguments);
    assert_true(json_integer_value(json_array_get(json_object_get(statistics, "samples"), 1)) >=
                16);
    json_decref(statistics);
    cli_leave(&directory);
}

static void progress_as_json_makes_every_line_an_object(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", "lit.gltf",   "--width", "32", "--spp",
                                            "4",      "--progress", "json",    NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_result result = cli_run(&directory, arguments);
    assert_int_equal(result.exit_code, 0);
    size_t count = 0;
    for (char *line = strtok(result.err, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        json_t *const object = json_loads(line, 0, NULL);
        assert_true(json_is_string(json_object_get(object, "event")));
        json_decref(object);
        count++;
    }
    assert_true(count >= 2); /* the missing medium, and what was written */
    cli_free(&result);
    cli_leave(&directory);
}

static void a_scene_without_a_medium_is_warned_of(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", "lit.gltf", "--width", "8",
                                            "--spp",  "1",        "-q",      NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_result result = cli_run(&directory, arguments);
    assert_int_equal(result.exit_code, 0);
    assert_int_equal(cli_count_lines(result.err, "airlight: warning: lit.gltf: no medium"), 1);
    cli_free(&result);
    cli_leave(&directory);
}

static void diff_prints_metrics_and_fails_above_a_limit(void **state)
{
    (void)state;
    static const char *const a[] = {"render", SMALL, "--spp", "4", "-o", "a.exr", NULL};
    static const char *const b[] = {"render", SMALL, "--spp", "4", "--seed",
                                    "1",      "-o",  "b.exr", NULL};
    static const char *const compare[] = {"diff", "a.exr", "b.exr", "--json", NULL};
    static const char *const strict[] = {"diff",   "a.exr",          "b.exr", "--fail-above",
                                         "rmse=0", "--false-colour", "d.png", NULL};
    static const char *const same[] = {"diff",   "a.exr",        "a.exr",  "--fail-above",
                                       "rmse=0", "--fail-above", "flip=0", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, a);
    cli_run_well(&directory, b);
    json_t *const metrics = cli_run_json(&directory, compare);
    assert_true(json_real_value(json_object_get(metrics, "rmse")) > 0.0);
    assert_int_equal(json_real_value(json_object_get(metrics, "pixels")), 32 * 16);
    assert_null(json_object_get(metrics, "sidak-p"));
    json_decref(metrics);
    cli_result result = cli_run(&directory, strict);
    assert_int_equal(result.exit_code, 1);
    assert_int_equal(cli_count_lines(result.err, "airlight: error: rmse is "), 1);
    assert_true(cli_exists("d.png"));
    cli_free(&result);
    cli_run_well(&directory, same);
    cli_leave(&directory);
}

static void diff_tests_expectations_where_an_image_has_variances(void **state)
{
    (void)state;
    static const char *const a[] = {"render", SMALL, "--spp", "32", "--variance",
                                    "8",      "-o",  "a.exr", NULL};
    static const char *const b[] = {"render", SMALL, "--spp", "32",    "--variance=8",
                                    "--seed", "1",   "-o",    "b.exr", NULL};
    /* Both are unbiased: a Sidak-corrected p below 1e-4 would come about once in ten thousand
     * seeds, and these are fixed. */
    static const char *const compare[] = {"diff",         "a.exr",        "b.exr", "--json",
                                          "--fail-below", "sidak-p=1e-4", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, a);
    cli_run_well(&directory, b);
    json_t *const metrics = cli_run_json(&directory, compare);
    assert_true(json_real_value(json_object_get(metrics, "tests")) > 0.0);
    json_decref(metrics);
    char *const replicates = cli_attribute(&directory, "a.exr", "airlight:variance-replicates");
    assert_string_equal(replicates, "8");
    free(replicates);
    cli_leave(&directory);
}

static void convert_of_a_png_gives_the_same_png(void **state)
{
    (void)state;
    static const char *const render[] = {"render", SMALL, "--spp", "4", "-o", "a.png", NULL};
    static const char *const convert[] = {"convert", "a.png", "b.png", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, render);
    cli_run_well(&directory, convert);
    assert_true(cli_same_bytes("a.png", "b.png"));
    cli_leave(&directory);
}

static void convert_takes_the_exposure_an_exr_carries(void **state)
{
    (void)state;
    static const char *const render[] = {"render", SMALL,   "--spp", "4",     "--exposure", "2",
                                         "-o",     "a.exr", "-o",    "a.png", NULL};
    static const char *const convert[] = {"convert", "a.exr", "b.png", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_run_well(&directory, render);
    cli_run_well(&directory, convert);
    assert_true(cli_same_bytes("a.png", "b.png"));
    cli_leave(&directory);
}

static void convert_reads_vdb_files_by_the_optional_converter(void **state)
{
    (void)state;
    static const char *const volume = AIR_SHARED_DIR "/scenes/vdb/torus01.vdb";
    static const char *const arguments[] = {"convert", volume, "torus.nvdb", NULL};
    static const char *const render[] = {
        "render", "lit.gltf", "--width", "8", "--spp", "1", "--medium", "grid=torus.nvdb,sigma_s=1",
        NULL};
    if (!cli_exists(volume)) {
        print_message("no %s\n", volume);
        skip();
    }
    cli_directory directory;
    cli_enter(&directory);
    cli_result result = cli_run(&directory, arguments);
    if (result.exit_code == 0) {
        cli_run_well(&directory, render);
    } else {
        /* Built without OpenVDB. */
        assert_int_equal(result.exit_code, 1);
        assert_int_equal(cli_count_lines(result.err, "airlight: error: "), 1);
        assert_non_null(
            strstr(result.err, "airlight-vdb2nvdb, which is neither beside airlight nor on PATH"));
        assert_false(cli_exists("torus.nvdb"));
    }
    cli_free(&result);
    cli_leave(&directory);
}

static void info_tells_of_a_scene_in_text_and_json(void **state)
{
    (void)state;
    static const char *const text[] = {"info", "lit.gltf", NULL};
    static const char *const json[] = {"info", "lit.gltf", "--json", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_result result = cli_run(&directory, text);
    assert_int_equal(result.exit_code, 0);
    assert_non_null(strstr(result.out, "triangles: 2\n"));
    assert_non_null(strstr(result.out, "\"Slant\""));
    cli_free(&result);
    json_t *const description = cli_run_json(&directory, json);
    assert_int_equal(json_array_size(json_object_get(description, "cameras")), 1);
    json_decref(description);
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(help_of_every_command_goes_to_stdout_with_exit_code_0),
        cmocka_unit_test(render_writes_the_outputs_asked_for_and_nothing_else),
        cmocka_unit_test(render_writes_an_exr_of_the_scenes_name_by_default),
        cmocka_unit_test(an_exr_tells_how_it_was_made),
        cmocka_unit_test(statistics_come_as_json_on_stdout),
        cmocka_unit_test(films_of_parts_merge_to_the_bytes_of_one_run),
        cmocka_unit_test(films_of_different_pictures_do_not_merge),
        cmocka_unit_test(threads_and_tiles_do_not_change_the_bytes),
        cmocka_unit_test(an_interrupt_leaves_a_marked_picture_and_exit_code_130),
        cmocka_unit_test(a_time_budget_ends_the_run_well),
        cmocka_unit_test(progress_as_json_makes_every_line_an_object),
        cmocka_unit_test(a_scene_without_a_medium_is_warned_of),
        cmocka_unit_test(diff_prints_metrics_and_fails_above_a_limit),
        cmocka_unit_test(diff_tests_expectations_where_an_image_has_variances),
        cmocka_unit_test(convert_of_a_png_gives_the_same_png),
        cmocka_unit_test(convert_takes_the_exposure_an_exr_carries),
        cmocka_unit_test(convert_reads_vdb_files_by_the_optional_converter),
        cmocka_unit_test(info_tells_of_a_scene_in_text_and_json),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
