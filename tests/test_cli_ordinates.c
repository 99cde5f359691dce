/* Method ordinates by the command: options, levels of quality, and input without sense. */
#include <math.h>
#include <stdint.h>

#include "cli_run.h"

/* A density grid of 4^3 voxels in a cube of 1 m, the first of which holds `odd`, the others
 * `value`. */
static void write_grid(const char *name, uint32_t side, float odd, float value)
{
    enum { HEADER = 48, MOST = 64 };
    unsigned char bytes[HEADER + MOST * sizeof(float)] = {'V', 'O', 'L', 3};
    const uint32_t words[5] = {1, side, 4, 4, 1};
    const float bounds[6] = {-0.5f, 0.0f, -0.5f, 0.5f, 1.0f, 0.5f};
    memcpy(bytes + 4, words, sizeof words);
    memcpy(bytes + 24, bounds, sizeof bounds);
    for (size_t i = 0; i < MOST; i++) {
        memcpy(bytes + HEADER + i * sizeof(float), i == 0 ? &odd : &value, sizeof(float));
    }
    cli_write_bytes(name, bytes, HEADER + (size_t)side * 16 * sizeof(float));
}

static cli_directory enter(void)
{
    cli_directory directory;
    cli_enter(&directory);
    write_grid("good.vol", 4, 1.0f, 2.0f);
    write_grid("zero.vol", 4, 0.0f, 0.0f);
    write_grid("none.vol", 0, 0.0f, 0.0f);
    write_grid("negative.vol", 4, -1.0f, 2.0f);
    write_grid("nan.vol", 4, NAN, 2.0f);
    write_grid("infinite.vol", 4, INFINITY, 2.0f);
    cli_write_text("flat.json", "{\"media\":[{\"sigma_s\":1,\"boundary\":{\"box\":{\"min\":[0,0,0],"
                                "\"max\":[1,0,1]}}}]}");
    return directory;
}

static cli_result run(const cli_directory *directory, const char *const *more)
{
    const char *arguments[CLI_ARGUMENT_MAX] = {"render", "lit.gltf",    "--width", "16", "--spp",
                                               "4",      "--max-depth", "4",       "-q"};
    size_t count = 9;
    for (size_t i = 0; more[i] != NULL; i++) {
        arguments[count++] = more[i];
    }
    return cli_run(directory, arguments);
}

static void input_without_sense_is_refused_and_nothing_written(void **state)
{
    (void)state;
    static const struct {
        const char *arguments[12];
        int exit_code;
        const char *says;
    } cases[] = {
        {{"--medium", "grid=nan.vol,sigma_s=1"}, 1, "nan.vol: voxel (0, 0, 0) channel 0 is nan"},
        {{"--medium", "grid=infinite.vol,sigma_s=1"}, 1, "channel 0 is inf, must be finite"},
        {{"--medium", "grid=none.vol,sigma_s=1"}, 1, "none.vol: byte 8: size 0"},
        {{"--medium", "box=0,0,0:0,0,0,sigma_s=1"}, 1, "column 1 (box): expected a number above 0"},
        {{"--with", "flat.json"}, 1, "flat.json: $.media[0].boundary"},
        {{"--medium", "grid=good.vol,sigma_s=1", "--cells", "256", "--bands", "10"},
         1,
         "cells with 10 bands need 5"},
        {{"--cells", "1"}, 2, "--cells: expected a whole number from 2 to 256, got \"1\""},
        {{"--directions", "0"}, 2, "--directions: expected a whole number from 1 to 4096"},
        {{"--patches", "5000"}, 2, "--patches: expected a whole number from 1 to 4096"},
        {{"--bands", "11"}, 2, "--bands: expected a whole number from 1 to 10"},
        {{"--sweeps", "0"}, 2, "--sweeps: expected a whole number from 1"},
        {{"--steps", "4097"}, 2, "--steps: expected a whole number from 1 to 4096"},
        {{"--march", "65"}, 2, "--march: expected a whole number from 1 to 64"},
        {{"--angles", "4"}, 2, "--angles: expected PxA"},
        {{"--angles", "5x12"}, 2, "P even, 8 to 64, and A a multiple of 4, 16 to 128, got 5x12"},
        {{"--angles", "4x8", "--bands", "5"}, 2, "--angles: expected for 5 bands PxA"},
        {{"--angles", "66x128"}, 2, "got 66x128"},
        {{"--method", "ordinates:best"}, 1, "ordinates[:dom|cm|six|literal|shdom]"},
        {{"--quality", "quick"}, 2, "expected interactive, draft, medium or high"},
    };
    cli_directory directory = enter();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *arguments[16] = {"--method", "ordinates", "-o", "never.exr"};
        const size_t entries = cli_count_entries();
        memcpy(arguments + 4, cases[i].arguments, 12 * sizeof arguments[0]);
        cli_result result = run(&directory, arguments);
        if (result.exit_code != cases[i].exit_code ||
            cli_count_lines(result.err, "airlight: error: ") != 1 ||
            strstr(result.err, cases[i].says) == NULL) {
            fail_msg("case %zu: exit code %d, expected %d and \"%s\"; it said:\n%s", i,
                     result.exit_code, cases[i].exit_code, cases[i].says, result.err);
        }
        assert_int_equal(cli_count_entries(), entries);
        cli_free(&result);
    }
    cli_leave(&directory);
}

/* Smoke that has not yet begun is no error, and neither is a grid with a few values below 0. */
static void odd_grids_are_rendered_with_a_warning(void **state)
{
    (void)state;
    static const char *const says[2] = {
        "no value of its density grid is above 0",
        "negative.vol: 1 negative values were set to 0",
    };
    static const char *const grids[2] = {"grid=zero.vol,sigma_s=1", "grid=negative.vol,sigma_s=1"};
    cli_directory directory = enter();
    for (size_t i = 0; i < 2; i++) {
        const char *const arguments[] = {"--method", "ordinates", "--medium", grids[i],
                                         "--cells",  "6",         NULL};
        cli_result result = run(&directory, arguments);
        assert_int_equal(result.exit_code, 0);
        assert_int_equal(cli_count_lines(result.err, "airlight: warning: "), 1);
        assert_non_null(strstr(result.err, says[i]));
        cli_free(&result);
    }
    cli_leave(&directory);
}

/* Renders to a film, whose fingerprint tells settings apart. */
static char *film_of(const cli_directory *directory, const char *const *options)
{
    const char *arguments[20] = {"-o", "out.film", "--medium", "grid=good.vol,sigma_s=4"};
    for (size_t i = 0; options[i] != NULL; i++) {
        arguments[4 + i] = options[i];
    }
    cli_result result = run(directory, arguments);
    assert_int_equal(result.exit_code, 0);
    cli_free(&result);
    const char *const compare[] = {"merge", "out.film", "first.film", "-o", "sum.film", NULL};
    result = cli_run(directory, compare);
    char *const says = result.err;
    free(result.out);
    return says;
}

static void every_option_reaches_the_settings(void **state)
{
    (void)state;
    static const char *const options[][3] = {
        {"--cells", "7"},    {"--directions", "3"}, {"--patches", "3"}, {"--bands", "5"},
        {"--angles", "6x8"}, {"--sweeps", "3"},     {"--steps", "3"},   {"--march", "3"},
        {"--no-prefilter"},  {"--importance"},      {"--no-residuum"},  {"--no-bilateral"},
    };
    static const char *const base[] = {"--method", "ordinates", "--quality", "interactive",
                                       "--cells",  "6",         NULL};
    cli_directory directory = enter();
    free(film_of(&directory, base));
    assert_int_equal(rename("out.film", "first.film"), 0);
    char *says = film_of(&directory, base);
    assert_non_null(strstr(says, "both films hold samples"));
    free(says);
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        const char *arguments[12];
        memcpy(arguments, base, sizeof base);
        memcpy(arguments + 6, options[i], sizeof options[i]);
        says = film_of(&directory, arguments);
        if (strstr(says, "settings") == NULL) {
            fail_msg("%s: %s", options[i][0], says);
        }
        free(says);
    }
    cli_leave(&directory);
}

/* The mean of red of a picture, as --json prints it to nine digits. */
static double mean_of(const cli_directory *directory, const char *const *options)
{
    const char *arguments[24] = {"--medium", "grid=good.vol,sigma_s=4",
                                 "--method", "ordinates",
                                 "--cells",  "6",
                                 "--json",   "-o",
                                 "out.exr"};
    for (size_t i = 0; options[i] != NULL; i++) {
        arguments[9 + i] = options[i];
    }
    cli_result result = run(directory, arguments);
    assert_int_equal(result.exit_code, 0);
    const char *const at = strstr(result.out, "\"mean\": [");
    assert_non_null(at);
    const double mean = strtod(at + strlen("\"mean\": ["), NULL);
    cli_free(&result);
    return mean;
}

/* What a bake shows and what media scatter are each what they are without the other; sums of floats
 * of 24 bits. */
static void a_bake_takes_nothing_from_the_media(void **state)
{
    (void)state;
    static const char *const bake[] = {
        "bake", "lit.gltf", "-o", "lit.lightmap", "--medium", "grid=good.vol,sigma_s=4", "--spp",
        "4",    "-q",       NULL};
    static const char *const all[] = {"--lightmap", "lit.lightmap", NULL};
    static const char *const surfaces[] = {"--lightmap", "lit.lightmap", "--terms", "S0,S+", NULL};
    static const char *const media[] = {"--terms", "M1,M2", NULL};
    cli_directory directory = enter();
    cli_result result = cli_run(&directory, bake);
    assert_int_equal(result.exit_code, 0);
    cli_free(&result);
    const double whole = mean_of(&directory, all), of_media = mean_of(&directory, media);
    const double of_surfaces = mean_of(&directory, surfaces);
    assert_true(of_media > 0.0 && of_surfaces > 0.0);
    assert_true(fabs(of_media + of_surfaces - whole) <= 1e-6 * whole);
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(input_without_sense_is_refused_and_nothing_written),
        cmocka_unit_test(odd_grids_are_rendered_with_a_warning),
        cmocka_unit_test(every_option_reaches_the_settings),
        cmocka_unit_test(a_bake_takes_nothing_from_the_media),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
