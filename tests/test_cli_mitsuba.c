/* Mitsuba scenes on the command line: what they ask of a picture, parameters, and files outside. */
#include <jansson.h>

#include "cli_run.h"

static const char room[] =
    "<scene version='3.0.0'><default name='spp' value='3'/>"
    "<sensor type='perspective'><transform name='to_world'>"
    "<lookat origin='0 0 5' target='0 0 0' up='0 1 0'/></transform>"
    "<film type='hdrfilm'><integer name='width' value='12'/><integer name='height' value='8'/>"
    "<integer name='crop_offset_x' value='2'/><integer name='crop_width' value='6'/>"
    "<rfilter type='tent'/></film>"
    "<sampler type='independent'><integer name='sample_count' value='$spp'/></sampler></sensor>"
    "<shape type='cube'/><emitter type='constant'/></scene>";

static void enter(cli_directory *directory)
{
    cli_enter(directory);
    cli_write_text("room.xml", room);
}

/* Renders; what --json says of it. */
static json_t *render(const cli_directory *directory, const char *const *arguments)
{
    json_error_t error;
    cli_result result = cli_run(directory, arguments);
    if (result.exit_code != 0)
        fail_msg("exit code %d: %s", result.exit_code, result.err);
    json_t *report = json_loads(result.out, 0, &error);
    assert_non_null(report);
    cli_free(&result);
    return report;
}

static void assert_numbers(json_t *report, const char *key, size_t count, const json_int_t *numbers)
{
    const json_t *value = json_object_get(report, key);
    for (size_t i = 0; i < count; ++i)
        assert_int_equal(
            json_integer_value(json_is_array(value) ? json_array_get(value, i) : value),
            numbers[i]);
}

static void the_film_says_what_the_options_do_not(void **state)
{
    cli_directory directory;
    (void)state;
    enter(&directory);
    const char *plain[] = {"render", "room.xml", "--json", "-o", "a.exr", NULL};
    json_t *report = render(&directory, plain);
    assert_numbers(report, "width", 1, (const json_int_t[]){12});
    assert_numbers(report, "height", 1, (const json_int_t[]){8});
    assert_numbers(report, "crop", 4, (const json_int_t[]){2, 0, 8, 8});
    assert_numbers(report, "samples", 2, (const json_int_t[]){0, 3});
    json_decref(report);
    const char *told[] = {"render", "room.xml", "--json", "-o",     "a.exr",   "-D",
                          "spp=5",  "--width",  "6",      "--crop", "0,0,2,2", NULL};
    report = render(&directory, told);
    assert_numbers(report, "width", 1, (const json_int_t[]){6});
    assert_numbers(report, "height", 1, (const json_int_t[]){4});
    assert_numbers(report, "crop", 4, (const json_int_t[]){0, 0, 2, 2});
    assert_numbers(report, "samples", 2, (const json_int_t[]){0, 5});
    json_decref(report);
    const char *draft[] = {"render", "room.xml",  "--json", "-o",
                           "a.exr",  "--quality", "draft",  NULL};
    report = render(&directory, draft);
    assert_numbers(report, "samples", 2, (const json_int_t[]){0, 16});
    json_decref(report);
    cli_leave(&directory);
}

static void files_outside_need_to_be_allowed(void **state)
{
    cli_directory directory;
    (void)state;
    enter(&directory);
    cli_write_text("lamp.xml", "<scene version='3.0'><emitter type='point'/></scene>");
    assert_int_equal(mkdir("inner", 0777), 0);
    cli_write_text("inner/room.xml",
                   "<scene version='3.0'><include filename='../lamp.xml'/></scene>");
    assert_int_equal(symlink("../lamp.xml", "inner/link.xml"), 0);
    cli_write_text("inner/linked.xml",
                   "<scene version='3.0'><include filename='link.xml'/></scene>");
    const char *refused[] = {"info", "inner/room.xml", NULL};
    const char *linked[] = {"info", "inner/linked.xml", NULL};
    const char *allowed[] = {"info", "inner/room.xml", "--files-anywhere", NULL};
    const char *const *runs[] = {refused, linked, allowed};
    for (size_t i = 0; i < 3; ++i) {
        cli_result result = cli_run(&directory, runs[i]);
        assert_int_equal(result.exit_code, i < 2 ? 1 : 0);
        assert_true((strstr(result.err, "lies outside the scene's folder") != NULL) == (i < 2));
        cli_free(&result);
    }
    remove("inner/room.xml");
    remove("inner/link.xml");
    remove("inner/linked.xml");
    rmdir("inner");
    cli_leave(&directory);
}

static void leniency_says_what_it_does(void **state)
{
    cli_directory directory;
    (void)state;
    enter(&directory);
    cli_write_text("hair.xml", "<scene version='3.0'><shape type='cube'><bsdf type='hair'/></shape>"
                               "<emitter type='constant'/></scene>");
    const char *strict[] = {"info", "hair.xml", NULL};
    const char *lenient[] = {"info", "hair.xml", "--lenient", NULL};
    cli_result result = cli_run(&directory, strict);
    assert_int_equal(result.exit_code, 1);
    cli_free(&result);
    result = cli_run(&directory, lenient);
    assert_int_equal(result.exit_code, 0);
    assert_non_null(strstr(result.err, "a diffuse surface of its colour is taken"));
    cli_free(&result);
    cli_leave(&directory);
}

static void a_sky_and_its_sun_have_owners_of_their_own(void **state)
{
    cli_directory directory;
    (void)state;
    enter(&directory);
    cli_write_text("day.xml", "<scene version='0.6.0'><shape type='cube'/><emitter type='sunsky'>"
                              "<integer name='resolution' value='16'/></emitter>"
                              "<emitter type='point'/><emitter type='point'/></scene>");
    const char *info[] = {"info", "day.xml", "--medium", "box=-2,0,-2:2,2,2,sigma_s=0.1", NULL};
    cli_result result = cli_run(&directory, info);
    assert_int_equal(result.exit_code, 0);
    assert_non_null(strstr(result.out,
                           "\n  \"sky\": path of S0, S+, M1, M2, emission, background\n"
                           "  \"sun\": collimated:exact of S0, M1; path of S+, M2, emission, "
                           "background\n"
                           "  \"point\": path of S0, S+, M1, M2, emission, background\n"
                           "  \"point\": path of S0, S+, M1, M2, emission, background\n"));
    cli_free(&result);
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_film_says_what_the_options_do_not),
        cmocka_unit_test(files_outside_need_to_be_allowed),
        cmocka_unit_test(leniency_says_what_it_does),
        cmocka_unit_test(a_sky_and_its_sun_have_owners_of_their_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
