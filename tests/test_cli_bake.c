/* `airlight bake`: what it writes, how it fails, that it goes on where it was interrupted. */
#include <jansson.h>

#include "cli_result.h"

#define QUICK "lit.gltf", "--spp", "2", "--texels-per-metre", "3", "--media", "attenuate"

static void assert_run(const cli_directory *directory, const char *const *arguments, int exit_code,
                       const char *says)
{
    cli_result result = cli_run(directory, arguments);
    if (result.exit_code != exit_code || strstr(result.err, says) == NULL) {
        fail_msg("exit code %d, expected %d; \"%s\" does not say \"%s\"", result.exit_code,
                 exit_code, result.err, says);
    }
    cli_free(&result);
}

static void assert_json(const char *path, const char *key)
{
    json_error_t error;
    json_t *value = json_load_file(path, 0, &error);
    if (value == NULL) {
        fail_msg("%s: line %d: %s", path, error.line, error.text);
    }
    if (json_object_get(value, key) == NULL) {
        fail_msg("%s has no \"%s\"", path, key);
    }
    json_decref(value);
}

static void all_outputs_are_written(void **state)
{
    static const char *const arguments[] = {"bake",          QUICK,
                                            "--targets",     "lightmap,vertices",
                                            "--probes",      "auto=2",
                                            "--probes",      "probes.txt",
                                            "--probes",      "grid=-1,1,-1:1,1,1:3,1,2",
                                            "--gltf",        "lit.glb",
                                            "--godot",       "godot",
                                            "--bevy",        "bevy",
                                            "--rgbm",        "rgbm",
                                            "--directional", "-o",
                                            "out",           NULL};
    static const char *const files[] = {
        "out/lightmap.json",    "out/page-0.exr", "out/vertices-0.exr",  "out/probes.json",
        "out/cuts.bin",         "lit.glb",        "godot/lightmap.tres", "godot/lightmap.exr",
        "bevy/lightmap-0.ktx2", "bevy/bevy.json", "rgbm/rgbm.json"};
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    cli_write_text("probes.txt", "# three\n0 1 0\n\n 1.5,1,0\t\r\n-1\t1e0 .5\n");
    cli_result result = cli_run(&directory, arguments);
    if (result.exit_code != 0) {
        fail_msg("exit code %d: %s", result.exit_code, result.err);
    }
    assert_string_equal(result.out, "");
    assert_non_null(strstr(result.err, " 4 vertices, 13 probes with 2 samples, media attenuate"));
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        if (!cli_exists(files[i])) {
            fail_msg("%s is missing", files[i]);
        }
    }
    assert_false(cli_exists("out/bake.progress"));
    assert_json("out/lightmap.json", "pages");
    assert_json("out/probes.json", "sets");
    assert_json("bevy/bevy.json", "meshes");
    assert_json("rgbm/rgbm.json", "pages");
    cli_free(&result);
    cli_leave(&directory);
}

static void the_folder_has_the_scenes_name_by_default(void **state)
{
    static const char *const arguments[] = {"bake", QUICK, NULL};
    static const char *const probes_only[] = {"bake", QUICK,  "--probes", "auto=2",
                                              "-o",   "only", NULL};
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    assert_run(&directory, arguments, 0, "wrote lit.lightmap");
    assert_true(cli_exists("lit.lightmap/lightmap.json"));
    /* asked for probes, it makes no pages */
    assert_run(&directory, probes_only, 0, "baked 0 texels");
    assert_false(cli_exists("only/page-0.exr"));
    cli_leave(&directory);
}

static void threads_change_no_byte_of_the_pages(void **state)
{
    static const char *const one[] = {"bake", QUICK, "-t", "1", "-o", "one", NULL};
    static const char *const two[] = {"bake", QUICK, "-t", "2", "-o", "two", NULL};
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    assert_run(&directory, one, 0, "");
    assert_run(&directory, two, 0, "");
    assert_true(cli_same_bytes("one/page-0.exr", "two/page-0.exr"));
    assert_true(cli_same_bytes("one/cuts.bin", "two/cuts.bin"));
    cli_leave(&directory);
}

/* Each says what is wrong, by the exit code too, and leaves nothing behind. */
static void errors_say_what_is_wrong(void **state)
{
    static const struct {
        const char *arguments[10];
        int exit_code;
        const char *says;
    } cases[] = {
        {{"bake"}, 2, "expected SCENE, got 0 arguments"},
        {{"bake", "lit.gltf", "--no-such-option"}, 2, "--no-such-option"},
        {{"bake", "lit.gltf", "--media", "fog"}, 2, "--media"},
        {{"bake", "lit.gltf", "--spp", "0"}, 2, "--spp"},
        {{"bake", "lit.gltf", "--targets", "walls"}, 2, "--targets"},
        {{"bake", "dark.gltf"}, 1, "dark.gltf: no light in the scene"},
        {{"bake", "absent.gltf"}, 1, "absent.gltf"},
        {{"bake", "lit.gltf", "--uv", "file"}, 1, "it has no TEXCOORD_1"},
        {{"bake", "lit.gltf", "--page-size", "16", "--padding", "64"}, 1, "padding is 64"},
        {{"bake", "lit.gltf", "--probes", "auto=0"}, 2, "auto=SPACING with a positive number"},
        {{"bake", "lit.gltf", "--probes", "auto=1m"}, 2, "auto=SPACING with a positive number"},
        {{"bake", "lit.gltf", "--probes", "auto=1e-9"}, 1, "probes along one side"},
        {{"bake", "lit.gltf", "--probes", "grid=0,0,0:1,1,1"}, 2, "with two corners and a count"},
        {{"bake", "lit.gltf", "--probes", "grid=0,0,0:1,1,1:2,2,2.5"},
         2,
         "a count along each axis"},
        {{"bake", "lit.gltf", "--probes", "grid=0,0,0:1,1,1:2,0,2"}, 2, "a count along each axis"},
        {{"bake", "lit.gltf", "--probes", "grid=0,nan,0:1,1,1:2,2,2"}, 1, "finite numbers"},
        {{"bake", "lit.gltf", "--probes", "absent.txt"}, 2, "a file that can be read"},
        {{"bake", "lit.gltf", "--probes", "bad.txt"}, 1, "bad.txt: line 4: expected three numbers"},
        {{"bake", "lit.gltf", "--probes", "four.txt"}, 1, "four.txt: line 1: expected three"},
        {{"bake", "lit.gltf", "--probes", "none.txt"}, 1, "none.txt: no position in it"},
        {{"bake", "lit.gltf", "--probes", "nan.txt"}, 1, "position 1 is not finite"},
        {{"bake", "lit.gltf", "-o", "quad.bin"}, 1, "quad.bin: cannot make this folder: a file"},
        {{"bake", "lit.gltf", "-o", "no/such/folder"}, 1, "no/such/folder: cannot make"},
    };
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    cli_write_scene("dark.gltf", "quad.bin", "");
    cli_write_text("bad.txt", "# positions\n0 1 0\n\n1 2\n");
    cli_write_text("four.txt", "1 2 3 4\n");
    cli_write_text("none.txt", "# nothing\n");
    cli_write_text("nan.txt", "1 2 3\n1 nan 3\n");
    const size_t entries = cli_count_entries();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_run(&directory, cases[i].arguments, cases[i].exit_code, cases[i].says);
        if (cli_count_entries() != entries) {
            fail_msg("case %zu (%s) leaves something behind", i, cases[i].says);
        }
    }
    cli_leave(&directory);
}

/* A line longer than any position is one line still. */
static void long_lines_of_positions_are_counted_once(void **state)
{
    static const char *const arguments[] = {"bake", QUICK, "--probes", "long.txt", NULL};
    char text[2048];
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    memset(text, 'x', sizeof text);
    text[0] = '#';
    strcpy(text + 1500, "\n0 1 0\nwrong\n");
    cli_write_text("long.txt", text);
    assert_run(&directory, arguments, 1, "long.txt: line 3: expected three numbers");
    cli_leave(&directory);
}

static void another_file_in_the_place_of_progress_is_left_alone(void **state)
{
    static const char *const arguments[] = {"bake", QUICK, "-o", "out", NULL};
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    assert_int_equal(mkdir("out", 0700), 0);
    cli_write_text("out/bake.progress", "notes about progress");
    assert_run(&directory, arguments, 1, "out/bake.progress: expected the progress of a bake");
    char *text = cli_read_text("out/bake.progress");
    assert_string_equal(text, "notes about progress");
    free(text);
    cli_leave(&directory);
}

static off_t size_of(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 ? status.st_size : 0;
}

/* 800 texels with 2048 samples are a second of work in 13 jobs; it is interrupted as soon as
 * the first of them is done. */
static void an_interrupted_bake_goes_on(void **state)
{
#define LONG                                                                                       \
    "bake", "lit.gltf", "--spp", "2048", "--texels-per-metre", "7", "--media", "attenuate", "-t",  \
        "1", "-o"
    static const char *const interrupted[] = {LONG, "out", NULL};
    static const char *const whole[] = {LONG, "whole", NULL};
#undef LONG
    const struct timespec pause = {.tv_nsec = 2000000};
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    const pid_t child = cli_start(&directory, interrupted);
    for (int i = 0; i < 15000 && size_of("out/bake.progress") <= 16; i++) {
        nanosleep(&pause, NULL);
    }
    kill(child, SIGINT);
    cli_result result = cli_finish(&directory, child);
    assert_int_equal(result.exit_code, 130);
    assert_int_equal(cli_count_lines(result.err, "airlight: error: "), 0);
    cli_free(&result);
    assert_true(size_of("out/bake.progress") > 16);
    assert_false(cli_exists("out/lightmap.json") || cli_exists("out/page-0.exr"));
    assert_run(&directory, interrupted, 0, "(resumed); wrote out");
    assert_false(cli_exists("out/bake.progress"));
    assert_run(&directory, whole, 0, "; wrote whole");
    assert_true(cli_same_bytes("out/page-0.exr", "whole/page-0.exr"));
    assert_true(cli_same_bytes("out/lightmap.json", "whole/lightmap.json"));
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_outputs_are_written),
        cmocka_unit_test(the_folder_has_the_scenes_name_by_default),
        cmocka_unit_test(threads_change_no_byte_of_the_pages),
        cmocka_unit_test(errors_say_what_is_wrong),
        cmocka_unit_test(long_lines_of_positions_are_counted_once),
        cmocka_unit_test(another_file_in_the_place_of_progress_is_left_alone),
        cmocka_unit_test(an_interrupted_bake_goes_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
