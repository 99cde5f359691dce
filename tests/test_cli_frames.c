/* Sequences of frames: files in and out, cameras that turn, interrupts, and bad numbers. */
#include <jansson.h>

#include "cli_result.h"

/* Smoke of a file for each frame around the lamp; 32 x 16 pixels. */
#define SMOKE                                                                                      \
    "lit.gltf", "--width", "32", "--max-depth", "3", "--spp", "16", "--medium",                    \
        "grid=smoke.##.raw,grid_size=4,4,4,grid_box=-1,0,-1:1,2,1,sigma_s=2"

enum { SMOKE_SIDE = 4, SMOKE_VALUES = SMOKE_SIDE * SMOKE_SIDE * SMOKE_SIDE };

/* A ball of smoke that rises and grows. */
static void write_smoke(int frame)
{
    float values[SMOKE_VALUES];
    char name[32];
    for (int i = 0; i < SMOKE_VALUES; i++) {
        const int x = i % SMOKE_SIDE, y = i / SMOKE_SIDE % SMOKE_SIDE;
        values[i] = x + frame > y ? 0.25f * (float)(frame + x) : 0.0f;
    }
    snprintf(name, sizeof name, "smoke.%02d.raw", frame);
    cli_write_bytes(name, values, sizeof values);
}

static void enter(cli_directory *directory)
{
    cli_enter(directory);
    for (int frame = 1; frame <= 4; frame++) {
        write_smoke(frame);
    }
}

/* The command fails so, and one line on stderr is "airlight: error: " and this. */
static void run_badly(const cli_directory *directory, const char *const *arguments, int exit_code,
                      const char *message)
{
    char line[256];
    cli_result result = cli_run(directory, arguments);
    snprintf(line, sizeof line, "airlight: error: %s", message);
    if (result.exit_code != exit_code || cli_count_lines(result.err, line) != 1 ||
        cli_count_lines(result.err, "airlight: error: ") != 1) {
        fail_msg("exit code %d: %s", result.exit_code, result.err);
    }
    cli_free(&result);
}

static void expect_attribute(const cli_directory *directory, const char *path, const char *name,
                             const char *expected)
{
    char *const value = cli_attribute(directory, path, name);
    assert_non_null(value);
    assert_string_equal(value, expected);
    free(value);
}

/* ---- what is rendered ---- */

static void a_frame_of_a_sequence_has_the_bytes_of_that_frame_alone(void **state)
{
    (void)state;
    static const char *const all[] = {"render",      SMOKE, "--frames",   "1-4", "-o",
                                      "all.##.film", "-o",  "all.##.pfm", NULL};
    static const char *const alone[] = {"render",       SMOKE, "--frames",    "3", "-o",
                                        "alone.#.film", "-o",  "alone.#.pfm", NULL};
    cli_directory directory;
    enter(&directory);
    cli_run_well(&directory, all);
    cli_run_well(&directory, alone);
    assert_true(cli_same_bytes("all.03.film", "alone.3.film"));
    assert_true(cli_same_bytes("all.03.pfm", "alone.3.pfm"));
    assert_false(cli_same_bytes("all.02.pfm", "all.03.pfm"));
    cli_leave(&directory);
}

static void turning_the_camera_does_not_depend_on_the_frames_before(void **state)
{
    (void)state;
    static const char *const turning[] = {"render", SMOKE, "--frames",    "1-3", "--orbit",
                                          "30",     "-o",  "turn.#.film", NULL};
    static const char *const alone[] = {"render", SMOKE, "--frames",   "3", "--orbit",
                                        "30",     "-o",  "alone.film", NULL};
    static const char *const still[] = {"render", SMOKE, "--frames", "3", "-o", "still.film", NULL};
    static const char *const none[] = {"render", SMOKE, "--frames",  "3", "--orbit",
                                       "0",      "-o",  "none.film", NULL};
    cli_directory directory;
    enter(&directory);
    cli_run_well(&directory, turning);
    cli_run_well(&directory, alone);
    cli_run_well(&directory, still);
    cli_run_well(&directory, none);
    assert_true(cli_same_bytes("turn.3.film", "alone.film"));
    assert_false(cli_same_bytes("turn.3.film", "still.film"));
    assert_true(cli_same_bytes("none.film", "still.film"));
    cli_leave(&directory);
}

static double relative_rmse(const cli_directory *directory, const char *a, const char *b)
{
    const char *const arguments[] = {"diff", a, b, "--json", NULL};
    cli_result result = cli_run(directory, arguments);
    assert_int_equal(result.exit_code, 0);
    json_t *const metrics = json_loads(result.out, 0, NULL);
    const double value = json_real_value(json_object_get(metrics, "relative-rmse"));
    json_decref(metrics);
    cli_free(&result);
    return value;
}

/* The scene's camera is at (0, 3, 3) and looks at the origin; the smoke, about the axis x = z = 0,
 * is thicker towards +X. */
static void the_camera_turns_counterclockwise_about_the_media(void **state)
{
    (void)state;
    static const char *const turned[] = {"render", SMOKE, "--frames",   "1", "--orbit",
                                         "90",     "-o",  "turned.exr", NULL};
    static const char *const placed[] = {"render", SMOKE, "--frames",   "1", "--with",
                                         "x.json", "-o",  "placed.exr", NULL};
    static const char *const other[] = {"render", SMOKE, "--frames",  "1", "--orbit",
                                        "-90",    "-o",  "other.exr", NULL};
    cli_directory directory;
    enter(&directory);
    cli_write_text("x.json", "{\"camera\":{\"position\":[3,3,0],\"look_at\":[0,0,0],"
                             "\"fov_y_degrees\":45.83662361,\"aspect\":2}}");
    cli_run_well(&directory, turned);
    cli_run_well(&directory, placed);
    cli_run_well(&directory, other);
    /* The same rays up to roundings; those that send a path another way are a few. */
    assert_true(relative_rmse(&directory, "turned.exr", "placed.exr") < 0.01);
    assert_true(relative_rmse(&directory, "other.exr", "placed.exr") > 0.05);
    cli_leave(&directory);
}

static void frames_go_by_their_step_and_carry_their_number(void **state)
{
    (void)state;
    static const char *const arguments[] = {
        "render",     "lit.gltf", "--width",
        "32",         "--medium", "grid=smoke.##.raw,grid_size=4,4,4,sigma_s=2",
        "--frames",   "1-4/2",    "--layers",
        "--samples",  "16:32",    "-o",
        "s.####.exr", "--json",   NULL};
    cli_directory directory;
    enter(&directory);
    const size_t entries = cli_count_entries();
    cli_result result = cli_run(&directory, arguments);
    assert_int_equal(result.exit_code, 0);
    assert_int_equal(cli_count_entries(), entries + 2);
    expect_attribute(&directory, "s.0001.exr", "airlight:frame-number", "1");
    expect_attribute(&directory, "s.0003.exr", "airlight:frame-number", "3");
    expect_attribute(&directory, "s.0003.exr", "airlight:samples", "16:32");
    size_t count = 0;
    for (char *line = strtok(result.out, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        json_t *const object = json_loads(line, 0, NULL);
        assert_int_equal(json_integer_value(json_object_get(object, "frame")), 2 * count + 1);
        json_decref(object);
        count++;
    }
    assert_int_equal(count, 2);
    cli_free(&result);
    cli_leave(&directory);
}

static void the_default_output_has_room_for_the_number(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", SMOKE, "--frames", "2-3", NULL};
    cli_directory directory;
    enter(&directory);
    cli_run_well(&directory, arguments);
    assert_true(cli_exists("lit.0002.exr") && cli_exists("lit.0003.exr"));
    cli_leave(&directory);
}

static void progress_tells_the_frame(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", SMOKE,        "--frames", "2-3", "-o",
                                            "p#.pfm", "--progress", "json",     NULL};
    cli_directory directory;
    enter(&directory);
    cli_result result = cli_run(&directory, arguments);
    assert_int_equal(result.exit_code, 0);
    size_t of_frame[4] = {0};
    for (char *line = strtok(result.err, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        json_t *const object = json_loads(line, 0, NULL);
        const json_t *const frame = json_object_get(object, "frame");
        if (strcmp(json_string_value(json_object_get(object, "event")), "progress") == 0) {
            assert_in_range(json_integer_value(frame), 2, 3);
            of_frame[json_integer_value(frame)]++;
        }
        json_decref(object);
    }
    assert_true(of_frame[2] > 0 && of_frame[3] > 0);
    cli_free(&result);
    cli_leave(&directory);
}

/* ---- when it ends early ---- */

static void a_missing_frame_stops_and_those_done_stay(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", SMOKE,     "--frames", "3-6",
                                            "-o",     "m.#.pfm", NULL};
    cli_directory directory;
    enter(&directory);
    run_badly(&directory, arguments, 1,
              "frame 5: smoke.05.raw: cannot be opened: No such file or directory");
    assert_true(cli_exists("m.3.pfm") && cli_exists("m.4.pfm") && !cli_exists("m.5.pfm"));
    cli_leave(&directory);
}

static void without_frames_a_name_with_hashes_says_what_is_missing(void **state)
{
    (void)state;
    static const char *const arguments[] = {"render", SMOKE, NULL};
    static const char *const info[] = {
        "info",    "lit.gltf", "--medium", "grid=smoke.##.raw,grid_size=4,4,4,sigma_s=2",
        "--frame", "2",        NULL};
    cli_directory directory;
    enter(&directory);
    run_badly(&directory, arguments, 1,
              "smoke.##.raw: there is no such file, and # stands for the number of a frame: "
              "expected one (--frames of airlight render");
    cli_run_well(&directory, info);
    cli_leave(&directory);
}

static void an_interrupt_leaves_whole_frames_and_exit_code_130(void **state)
{
    (void)state;
    /* Each frame takes a fifth of a second at least, all of them two hours. */
    static const char *const arguments[] = {
        "render",  "lit.gltf", "--width", "32", "--medium", "sigma_s=0.1", "--frames",
        "1-36000", "--time",   "0.2",     "-o", "i.#.exr",  NULL};
    cli_directory directory;
    enter(&directory);
    const pid_t child = cli_start(&directory, arguments);
    cli_interrupt_at(&directory, child, "i.2.exr", NULL);
    expect_attribute(&directory, "i.1.exr", "airlight:frame-number", "1");
    expect_attribute(&directory, "i.2.exr", "airlight:frame-number", "2");
    cli_leave(&directory);
}

/* Events are not counted, so that light may be taken over. */
#define SMOKE_IN_CELLS                                                                             \
    "render", "lit.gltf", "--width", "32", "--spp", "4", "--max-depth", "unlimited", "--cells",    \
        "8", "--method", "ordinates", "-v", "--medium",                                            \
        "grid=smoke.##.raw,grid_size=4,4,4,grid_box=-1,0,-1:1,2,1,sigma_s=2"

/* Frames of ordinates begin where those before ended, near enough that one sees no difference. */
static void frames_begin_from_those_before_unless_told_not_to(void **state)
{
    (void)state;
    static const char *const runs[3][24] = {
        {SMOKE_IN_CELLS, "--frames", "1-3", "-o", "warm.#.exr", "-o", "warm.#.film"},
        {SMOKE_IN_CELLS, "--frames", "1-3", "-o", "cold.#.exr", "-o", "cold.#.film",
         "--no-warm-start"},
        {SMOKE_IN_CELLS, "--frames", "3", "-o", "alone.#.exr", "-o", "alone.#.film"},
    };
    cli_directory directory;
    enter(&directory);
    for (int i = 0; i < 3; i++) {
        cli_result result = cli_run(&directory, runs[i]);
        assert_int_equal(result.exit_code, 0);
        assert_int_equal(strstr(result.err, "begun from the picture before") != NULL, i == 0);
        cli_free(&result);
    }
    assert_true(cli_same_bytes("warm.1.film", "cold.1.film"));
    assert_true(cli_same_bytes("cold.3.film", "alone.3.film"));
    assert_false(cli_same_bytes("warm.3.film", "cold.3.film"));
    /* A sweep changes light by less than 1e-3 at the end; a hundredth is left of a solution. */
    assert_true(relative_rmse(&directory, "warm.3.exr", "cold.3.exr") < 0.01);
    cli_leave(&directory);
}

/* ---- what is refused ---- */

static void frames_that_make_no_sense_are_refused(void **state)
{
    (void)state;
    static const char *const bad[][2] = {
        {"5-2", "--frames: expected A-B with A <= B"},
        {"5-7/0", "--frames: expected A-B with A <= B and a step of at least 1"},
        {"-3", "--frames: expected N, A-B or A-B/STEP in whole numbers from 0 to 999999999"},
        {"x", "--frames: expected N, A-B"},
        {"1-2-3", "--frames: expected N, A-B"},
        {"1-", "--frames: expected N, A-B"},
        {"1.5", "--frames: expected N, A-B"},
        {"1000000000", "--frames: expected N, A-B"},
        {"99999999999999999999999", "--frames: expected N, A-B"},
        {"0-100000", "--frames: expected at most 100000 frames, got 100001"},
        {"0-999999999", "--frames: expected at most 100000 frames"},
    };
    cli_directory directory;
    enter(&directory);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const char *const arguments[] = {"render", "lit.gltf", "--frames", bad[i][0],
                                         "-o",     "a.#.pfm",  NULL};
        run_badly(&directory, arguments, 2, bad[i][1]);
    }
    cli_leave(&directory);
}

static void outputs_that_cannot_be_sequences_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *output;
        int exit_code;
        const char *message;
    } bad[] = {
        {"a.pfm", 2, "a.pfm: expected a run of # in the name, for the number of each of 2 frames"},
        {"a##########.pfm", 2, "a##########.pfm: 10 # in a run, expected at most 9"},
        {"a#b#.pfm", 2, "a#b#.pfm: several runs of # in the name"},
        {"a.#.tga", 2, "a.9.tga: expected an output that ends in .exr"},
        {"nowhere/a.#.pfm", 1, "nowhere/a.9.pfm: cannot write: No such file or directory"},
        {"a.##.pfm", 2, "a.10.pfm: given twice as an output"},
    };
    static const char *const orbit[] = {"render", "lit.gltf", "--orbit", "3", NULL};
    cli_directory directory;
    enter(&directory);
    const size_t entries = cli_count_entries();
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const char *const arguments[] = {"render",      "lit.gltf", "--frames", "9-10", "-o",
                                         bad[i].output, "-o",       "a.#.pfm",  NULL};
        run_badly(&directory, arguments, bad[i].exit_code, bad[i].message);
    }
    run_badly(&directory, orbit, 2, "--orbit: expected --frames with it");
    assert_int_equal(cli_count_entries(), entries);
    cli_leave(&directory);
}

/* ---- comparing sequences ---- */

static void diff_measures_how_sequences_flicker(void **state)
{
    (void)state;
    static const char *const a[] = {"render", SMOKE, "--frames", "1-4", "-o", "a.#.exr", NULL};
    static const char *const b[] = {"render", SMOKE, "--frames", "1-4", "--seed",
                                    "1",      "-o",  "b.##.exr", NULL};
    static const char *const same[] = {"diff",    "--temporal",   "a.#.exr",
                                       "a.#.exr", "--frames",     "1-4",
                                       "--json",  "--fail-above", "temporal-difference=0",
                                       NULL};
    static const char *const other[] = {
        "diff", "--temporal",     "a.#.exr", "b.##.exr",     "--frames",
        "1-4",  "--false-colour", "d.png",   "--fail-above", "temporal-difference=0",
        NULL};
    cli_directory directory;
    enter(&directory);
    cli_run_well(&directory, a);
    cli_run_well(&directory, b);
    cli_result result = cli_run(&directory, same);
    assert_int_equal(result.exit_code, 0);
    json_t *const metrics = json_loads(result.out, 0, NULL);
    assert_true(json_real_value(json_object_get(metrics, "temporal-variance-a")) > 0.0);
    assert_true(json_real_value(json_object_get(metrics, "temporal-ratio")) == 1.0);
    assert_true(json_real_value(json_object_get(metrics, "temporal-ratio-of-means")) == 1.0);
    assert_int_equal(json_real_value(json_object_get(metrics, "frames")), 4);
    assert_null(json_object_get(metrics, "rmse"));
    json_decref(metrics);
    cli_free(&result);
    run_badly(&directory, other, 1, "temporal-difference is ");
    assert_true(cli_exists("d.png"));
    cli_leave(&directory);
}

static void diff_refuses_sequences_it_cannot_compare(void **state)
{
    (void)state;
    static const struct {
        const char *a, *b, *frames;
        int exit_code;
        const char *message;
    } bad[] = {
        {"a.#.exr", "b.exr", "1-4", 2, "b.exr: expected a run of # in the name"},
        {"a.#.exr", "b.#.exr", "1-2", 2, "--frames: expected at least three frames"},
        {"a.#.exr", "b.#.exr", "1-4", 1, "frame 1: a.1.exr: cannot be opened"},
    };
    static const char *const alone[] = {"diff", "--temporal", "a.#.exr", "b.#.exr", NULL};
    cli_directory directory;
    enter(&directory);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const char *const arguments[] = {"diff",     "--temporal",  bad[i].a, bad[i].b,
                                         "--frames", bad[i].frames, NULL};
        run_badly(&directory, arguments, bad[i].exit_code, bad[i].message);
    }
    run_badly(&directory, alone, 2, "--temporal and --frames: expected both or neither");
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_of_a_sequence_has_the_bytes_of_that_frame_alone),
        cmocka_unit_test(turning_the_camera_does_not_depend_on_the_frames_before),
        cmocka_unit_test(the_camera_turns_counterclockwise_about_the_media),
        cmocka_unit_test(frames_go_by_their_step_and_carry_their_number),
        cmocka_unit_test(the_default_output_has_room_for_the_number),
        cmocka_unit_test(progress_tells_the_frame),
        cmocka_unit_test(a_missing_frame_stops_and_those_done_stay),
        cmocka_unit_test(without_frames_a_name_with_hashes_says_what_is_missing),
        cmocka_unit_test(frames_begin_from_those_before_unless_told_not_to),
        cmocka_unit_test(an_interrupt_leaves_whole_frames_and_exit_code_130),
        cmocka_unit_test(frames_that_make_no_sense_are_refused),
        cmocka_unit_test(outputs_that_cannot_be_sequences_are_refused),
        cmocka_unit_test(diff_measures_how_sequences_flicker),
        cmocka_unit_test(diff_refuses_sequences_it_cannot_compare),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
