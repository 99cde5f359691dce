/* Bad input to the command: one message that says what was expected where, the exit code, and
 * nothing left behind. */
#include "cli_run.h"

typedef struct bad_case {
    const char *arguments[16];
    int exit_code;
    const char *says; /* part of the message */
} bad_case;

static void check_case(const cli_directory *directory, const bad_case *c)
{
    const size_t entries = cli_count_entries();
    cli_result result = cli_run(directory, c->arguments);
    const size_t errors = cli_count_lines(result.err, "airlight: error: ");
    if (result.exit_code != c->exit_code || errors != 1 || strstr(result.err, c->says) == NULL) {
        print_error("airlight");
        for (size_t i = 0; c->arguments[i] != NULL; i++) {
            print_error(" %s", c->arguments[i]);
        }
        print_error(": exit code %d, expected %d with one error that says \"%s\"; it said:\n%s",
                    result.exit_code, c->exit_code, c->says, result.err);
        fail();
    }
    assert_string_equal(result.out, "");
    assert_int_equal(cli_count_entries(), entries);
    cli_free(&result);
}

static void check_cases(const bad_case *cases, size_t count)
{
    cli_directory directory;
    cli_enter(&directory);
    for (size_t i = 0; i < count; i++) {
        check_case(&directory, &cases[i]);
    }
    cli_leave(&directory);
}

#define CHECK_CASES(cases) check_cases(cases, sizeof(cases) / sizeof(cases)[0])

static void options_that_do_not_exist_are_named_with_the_nearest_one(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"rendr", "lit.gltf"},
         2,
         "unknown command \"rendr\" (did you mean render?); expected one of render, bake"},
        {{"shine", "lit.gltf"},
         2,
         "unknown command \"shine\"; expected one of render, bake, info, diff, merge, convert"},
        {{"render", "lit.gltf", "--qualtiy", "draft"},
         2,
         "unknown option --qualtiy of render (did you mean --quality?)"},
        {{"render", "lit.gltf", "--max-dpeth=1"}, 2, "(did you mean --max-depth?)"},
        {{"render", "lit.gltf", "--zzzzzzzz"}, 2, "(airlight render --help lists them)"},
        {{"render", "lit.gltf", "-Z"}, 2, "unknown option -Z of render"},
        {{"diff", "--spp", "4", "a.exr", "b.exr"}, 2, "unknown option --spp of diff"},
    };
    CHECK_CASES(cases);
}

static void values_out_of_range_are_refused_with_the_range(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"render", "lit.gltf", "--spp", "0"},
         2,
         "--spp: expected a whole number from 1 to 1073741824, got \"0\""},
        {{"render", "lit.gltf", "--spp=-1"}, 2, "got \"-1\""},
        {{"render", "lit.gltf", "--spp", "1e3"}, 2, "got \"1e3\""},
        {{"render", "lit.gltf", "--spp", "99999999999999999999"},
         2,
         "--spp: expected a whole number"},
        {{"render", "lit.gltf", "--spp", ""}, 2, "--spp: expected N, got \"\""},
        {{"render", "lit.gltf", "--spp"}, 2, "--spp: a value is missing"},
        {{"render", "lit.gltf", "--output", "--half"}, 2, "--output: a value is missing"},
        {{"render", "lit.gltf", "--half=1"}, 2, "--half: takes no value"},
        {{"render", "lit.gltf", "-t0"}, 2, "--threads: expected a whole number from 1 to 4096"},
        {{"render", "lit.gltf", "--seed", "18446744073709551616"},
         2,
         "--seed: expected a whole number"},
        {{"render", "lit.gltf", "--time", "0"}, 2, "--time: expected a number from 0.001 to"},
        {{"render", "lit.gltf", "--time", "nan"}, 2, "--time: expected a number"},
        {{"render", "lit.gltf", "--exposure", "bright"},
         2,
         "from -40 to 40, or auto, got \"bright\""},
        {{"render", "lit.gltf", "--filter", "bx"},
         2,
         "expected box, point, tent, gaussian or mitchell, got \"bx\" (did you mean box?)"},
        {{"render", "lit.gltf", "--terms", "S0,M3"},
         2,
         "--terms: expected S0, S+, M1, M2, emission or background"},
        {{"render", "lit.gltf", "--terms", "S0,"}, 2, "--terms: expected S0"},
        {{"render", "lit.gltf", "--samples", "32:16"}, 2, "--samples: expected A:B with A < B"},
        {{"render", "lit.gltf", "--samples", "8:16"}, 2, "A a multiple of 16"},
        {{"render", "lit.gltf", "--samples", "16"}, 2, "--samples: expected A:B"},
        {{"render", "lit.gltf", "--samples", "0:16", "--spp", "4"},
         2,
         "--spp and --samples: expected one of the two"},
        {{"render", "lit.gltf", "--spp", "30", "--variance", "8"},
         2,
         "--variance: expected a multiple of 8 samples"},
        {{"render", "lit.gltf", "--variance", "--time", "5"},
         2,
         "--variance and --time: expected one of the two"},
        {{"render", "lit.gltf", "--crop", "0,0,9"}, 2, "--crop: expected X0,Y0,X1,Y1"},
        {{"render", "lit.gltf", "--width", "64", "--crop", "0,0,65,9"},
         2,
         "--crop: expected X0 < X1 <= 64 and Y0 < Y1 <= 32"},
        {{"render", "lit.gltf", "--cpu", "avx"},
         2,
         "--cpu: expected auto, c, sse4.2, avx2 or avx512"},
        {{"diff", "a.exr", "b.exr", "--fail-above", "rmsee=1"},
         2,
         "no metric is called \"rmsee\" (did you mean rmse?)"},
        {{"diff", "a.exr", "b.exr", "--fail-above", "rmse"},
         2,
         "--fail-above: expected METRIC=NUMBER"},
    };
    CHECK_CASES(cases);
}

static void too_few_and_too_many_arguments_are_refused(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"render"}, 2, "render: expected SCENE, got 0 arguments"},
        {{"render", "lit.gltf", "other.gltf"}, 2, "unexpected argument \"other.gltf\""},
        {{"diff", "a.exr"}, 2, "diff: expected A B, got 1 argument "},
        {{"merge", "a.film"}, 2, "merge: expected an output"},
        {{"convert", "a.exr"}, 2, "convert: expected IN OUT"},
    };
    CHECK_CASES(cases);
}

static void missing_files_are_named(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"render", "absent.gltf"}, 1, "absent.gltf"},
        {{"info", "absent.glb"}, 1, "absent.glb"},
        {{"render", "lit.gltf", "--with", "absent.json"}, 1, "absent.json"},
        {{"render", "lit.gltf", "--environment", "absent.hdr"}, 1, "absent.hdr"},
        {{"diff", "absent.exr", "other.exr"}, 1, "absent.exr"},
        {{"merge", "absent.film", "-o", "out.film"}, 1, "absent.film"},
        {{"convert", "absent.exr", "out.png"}, 1, "absent.exr"},
        {{"convert", "absent.vdb", "out.nvdb"}, 1, "absent.vdb"},
    };
    CHECK_CASES(cases);
}

static void outputs_are_checked_before_the_work(void **state)
{
    (void)state;
    /* The scene does not exist: what is wrong with the output is said first. */
    static const bad_case cases[] = {
        {{"render", "absent.gltf", "-o", "picture.tiff"},
         2,
         "picture.tiff: expected an output that ends in .exr, .png"},
        {{"render", "absent.gltf", "-o", "picture"}, 2, "expected an output that ends in"},
        {{"render", "absent.gltf", "-o", "no/such/place.exr"},
         1,
         "no/such/place.exr: cannot write: No such file"},
        {{"render", "absent.gltf", "-o", "a.exr", "-o", "a.exr"}, 2, "a.exr: given twice"},
        {{"render", "absent.gltf", "-o", "folder.exr"},
         1,
         "folder.exr: cannot write: is a directory"},
        {{"diff", "a.exr", "b.exr", "--false-colour", "no/place.png"},
         1,
         "no/place.png: cannot write"},
        {{"diff", "a.exr", "b.exr", "--false-colour", "out.exr"},
         2,
         "out.exr: expected an output that ends in .png"},
        {{"merge", "absent.film", "-o", "out.jpg"}, 2, "out.jpg: expected an output that ends in"},
        {{"convert", "absent.exr", "out.hdr"},
         2,
         "out.hdr: expected an output that ends in .exr, .png, .pfm or .ktx2"},
        {{"convert", "absent.vdb", "out.vdb"}, 2, "out.vdb: expected an output that ends in .nvdb"},
    };
    cli_directory directory;
    cli_enter(&directory);
    assert_int_equal(mkdir("folder.exr", 0700), 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        check_case(&directory, &cases[i]);
    }
    cli_leave(&directory);
}

static void a_huge_image_is_refused_with_the_bytes_it_needs(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        /* 65535^2 pixels, three doubles for the film and three for the pass. */
        {{"render", "lit.gltf", "--width", "65535", "--height", "65535"},
         2,
         "need at least 206152138800 bytes"},
        {{"render", "lit.gltf", "--width", "65536"},
         2,
         "--width: expected a whole number from 1 to 65535"},
    };
    CHECK_CASES(cases);
}

static void scenes_that_are_broken_are_refused_with_the_place(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"render", "text.gltf"}, 1, "text.gltf"},
        {{"render", "stub.glb"}, 1, "stub.glb"},
        {{"render", "bufferless.gltf"}, 1, "nowhere.bin"},
        {{"render", "draco.gltf"}, 1, "KHR_draco_mesh_compression"},
        {{"render", "keyed.gltf"}, 1, "fogg"},
        {{"render", "lit.gltf", "--with", "broken.json"}, 1, "broken.json"},
        {{"info", "keyed.gltf"}, 1, "keyed.airlight.json"},
        {{"render", "lit.gltf", "--camera", "Nobody"},
         1,
         "--camera: expected a name or an index of 0 \"Slant\""},
        {{"render", "lit.gltf", "--method", "magic"}, 1, "\"magic\""},
    };
    cli_directory directory;
    cli_enter(&directory);
    cli_write_text("text.gltf", "this is no JSON");
    cli_write_text("stub.glb", "glTF");
    cli_write_scene("bufferless.gltf", "nowhere.bin", CLI_LAMP);
    cli_write_scene("draco.gltf", "quad.bin",
                    "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],");
    cli_write_scene("keyed.gltf", "quad.bin", CLI_LAMP);
    cli_write_text("keyed.airlight.json", "{\"fogg\": 1}");
    cli_write_text("broken.json", "{\"media\": [}");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        check_case(&directory, &cases[i]);
    }
    cli_leave(&directory);
}

static void media_without_sense_are_refused(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"render", "lit.gltf", "--medium", "sigma_s=-1"}, 1, "(sigma_s): expected"},
        {{"render", "lit.gltf", "--medium", "sigma_s=nan"}, 1, "(sigma_s): expected"},
        {{"render", "lit.gltf", "--medium", "sigma_s=1,g=1"}, 1, "(g): expected"},
        {{"render", "lit.gltf", "--medium", "sigmas=1"}, 1, "did you mean \"sigma_s\""},
        {{"render", "lit.gltf", "--medium", "visibility=0"}, 1, "(visibility): expected"},
    };
    CHECK_CASES(cases);
}

static void a_scene_without_light_names_the_ways_to_add_one(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"render", "dark.gltf"}, 1, "no light in the scene"},
        {{"render", "dark.gltf", "--terms", "S0,emission"}, 1, "--environment constant=1,1,1"},
        {{"render", "dark.gltf"}, 1, "--with FILE"},
    };
    cli_directory directory;
    cli_enter(&directory);
    cli_write_scene("dark.gltf", "quad.bin", "");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        check_case(&directory, &cases[i]);
    }
    cli_leave(&directory);
}

static void images_and_films_that_are_broken_are_refused(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {{"diff", "text.exr", "text.exr"}, 1, "text.exr"},
        {{"info", "text.exr"}, 1, "text.exr"},
        {{"info", "text.film"}, 1, "text.film"},
        {{"convert", "text.exr", "out.png"}, 1, "text.exr"},
        {{"convert", "text.film", "out.png"}, 2, "airlight merge text.film"},
        {{"merge", "text.film", "-o", "out.exr"}, 1, "text.film"},
    };
    cli_directory directory;
    cli_enter(&directory);
    cli_write_text("text.exr", "no picture");
    cli_write_text("text.film", "no film");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        check_case(&directory, &cases[i]);
    }
    cli_leave(&directory);
}

static void a_failed_run_leaves_the_old_output_as_it_was(void **state)
{
    (void)state;
    static const char *const arguments[] = {"convert", "text.exr", "old.png", NULL};
    cli_directory directory;
    cli_enter(&directory);
    cli_write_text("text.exr", "no picture");
    cli_write_text("old.png", "old");
    cli_result result = cli_run(&directory, arguments);
    char *const old = cli_read_text("old.png");
    assert_int_equal(result.exit_code, 1);
    assert_string_equal(old, "old");
    free(old);
    cli_free(&result);
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_that_do_not_exist_are_named_with_the_nearest_one),
        cmocka_unit_test(values_out_of_range_are_refused_with_the_range),
        cmocka_unit_test(too_few_and_too_many_arguments_are_refused),
        cmocka_unit_test(missing_files_are_named),
        cmocka_unit_test(outputs_are_checked_before_the_work),
        cmocka_unit_test(a_huge_image_is_refused_with_the_bytes_it_needs),
        cmocka_unit_test(scenes_that_are_broken_are_refused_with_the_place),
        cmocka_unit_test(media_without_sense_are_refused),
        cmocka_unit_test(a_scene_without_light_names_the_ways_to_add_one),
        cmocka_unit_test(images_and_films_that_are_broken_are_refused),
        cmocka_unit_test(a_failed_run_leaves_the_old_output_as_it_was),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
