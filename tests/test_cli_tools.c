/* airlight table and airlight denoise: what they write, and what they say to wrong input. */
#include "cli_run.h"

static void assert_run(const cli_directory *directory, const char *const *arguments, int exit_code,
                       const char *out, const char *err)
{
    cli_result result = cli_run(directory, arguments);
    if (result.exit_code != exit_code || strstr(result.out, out) == NULL ||
        strstr(result.err, err) == NULL) {
        fail_msg("%s %s: exit code %d, out \"%.200s\", err \"%.300s\"", arguments[0], arguments[1],
                 result.exit_code, result.out, result.err);
    }
    cli_free(&result);
}

static void tables_are_built_told_of_and_plotted(void **state)
{
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    const char *const build[] = {"table", "build", "ltsd", "--loss", "l3", "-o", "t.json", NULL};
    const char *const info[] = {"table", "info", "t.json", NULL};
    const char *const plot[] = {"table", "plot", "uniform", "--g", "0.9", NULL};
    const char *const no_file[] = {"table", "build", "mix", NULL};
    const char *const no_kind[] = {"table", "build", "ggx", "-o", "x.json", NULL};
    const char *const no_action[] = {"table", "burn", "mix", NULL};
    const char *const absent[] = {"table", "info", "absent.json", NULL};
    assert_run(&directory, build, 0, "", "");
    assert_run(&directory, info, 0, "kind: ltsd\nloss: l3\n", "");
    assert_run(&directory, plot, 0, "cosine_to_peak,phase,fit,difference\n-1,", "");
    assert_run(&directory, no_file, 2, "", "expected ltsd, mix, ltc or impulse, and -o FILE");
    assert_run(&directory, no_kind, 2, "", "kind \"ggx\" is not known");
    assert_run(&directory, no_action, 2, "", "expected build, info or plot");
    assert_run(&directory, absent, 1, "", "absent.json");
    assert_false(cli_exists("x.json"));
    const char *const ltc[] = {"table", "build", "ltc", "-o", "l.json", NULL};
    const char *const ltc_info[] = {"table", "info", "l.json", NULL};
    const char *const ltc_plot[] = {"table", "plot", "ltc", NULL};
    assert_run(&directory, ltc, 0, "", "");
    assert_run(&directory, ltc_info, 0, "kind: ltc\n", "");
    assert_run(&directory, ltc_plot, 2, "", "expected ltsd, mix, cosine, uniform or impulse");
    cli_leave(&directory);
}

static void impulse_tables_are_built_told_of_and_plotted(void **state)
{
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    const char *const build[] = {"table", "build",   "impulse",   "--bins",    "8", "--angles",
                                 "2",     "--knots", "0,0.5",     "--bounces", "2", "--form",
                                 "sh3",   "-o",      "t.impulse", NULL};
    const char *const info[] = {"table", "info", "t.impulse", NULL};
    const char *const plot[] = {"table",     "plot", "impulse",  "--bins", "8",
                                "--bounces", "1",    "--angles", "2",      NULL};
    const char *const falling[] = {"table", "build", "impulse", "--knots",
                                   "0.5,0", "-o",    "x",       NULL};
    const char *const words[] = {"table", "build", "impulse", "--knots", "0,a", "-o", "x", NULL};
    const char *const no_file[] = {"table", "build", "impulse", NULL};
    assert_run(&directory, build, 0, "", "");
    assert_run(&directory, info, 0, "kind: impulse\nform: sh3\nbins: 8", "");
    assert_run(&directory, plot, 0, "tau,point_1,point_all", "");
    assert_run(&directory, falling, 2, "", "rising");
    assert_run(&directory, words, 2, "", "--knots: expected");
    assert_run(&directory, no_file, 2, "", "-o FILE");
    assert_false(cli_exists("x"));
    cli_leave(&directory);
}

static void pictures_with_guides_are_denoised(void **state)
{
    static const char scene[] = AIR_SOURCE_DIR "/scenes/roombeam/roombeam.gltf";
    cli_directory directory;
    (void)state;
    cli_enter(&directory);
    const char *const render[] = {"render", scene, "--width", "40",    "--spp",
                                  "2",      "-q",  "-o",      "a.exr", NULL};
    const char *const guided[] = {"render",   scene, "--width", "40",    "--spp", "2",
                                  "--guides", "-q",  "-o",      "g.exr", NULL};
    const char *const bare[] = {"denoise", "a.exr", "b.exr", NULL};
    const char *const good[] = {"denoise", "g.exr", "b.exr", "--levels", "2", NULL};
    const char *const scaled[] = {"denoise", "g.exr", "c.exr", "--scale", "1.5", NULL};
    const char *const terms[] = {"denoise", "g.exr", "c.exr", "--terms", "M1", NULL};
    assert_run(&directory, render, 0, "", "");
    assert_run(&directory, guided, 0, "", "");
    assert_run(&directory, bare, 1, "", "render --guides");
    assert_false(cli_exists("b.exr"));
    assert_run(&directory, good, 0, "", "wrote b.exr");
    assert_true(cli_exists("b.exr"));
    assert_run(&directory, scaled, 2, "", "--scale");
    assert_run(&directory, terms, 1, "", "render --layers");
    assert_false(cli_exists("c.exr"));
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_built_told_of_and_plotted),
        cmocka_unit_test(impulse_tables_are_built_told_of_and_plotted),
        cmocka_unit_test(pictures_with_guides_are_denoised),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
