/* --medium: the grammar, and errors that quote the argument and the column. */
#include <math.h>

#include "import_fixture.h"
#include "scene/import/import.h"
#include "scene/import/number.h"

#define EMPTY "{" GLTF_SCENE ",'nodes':[{'mesh':0,'name':'Wall'}]," GLTF_CUBE "}"

typedef struct argument_fixture {
    import_fixture base;
    uint8_t cube[168];
    const char *media[1];
} argument_fixture;

static void start(argument_fixture *f)
{
    import_init(&f->base);
    import_serve_cube(&f->base, f->cube);
    f->base.params.media = f->media;
    f->base.params.media_count = 1;
}

static const air_medium *load(argument_fixture *f, const char *argument)
{
    f->media[0] = argument;
    import_loads(&f->base, EMPTY);
    assert_int_equal(f->base.snapshot->media.count, 1);
    return &f->base.snapshot->media.media[0];
}

/* Refused with one message: --medium "ARGUMENT": and this. */
static void refuse(argument_fixture *f, const char *argument, const char *message)
{
    char line[1024];
    f->media[0] = argument;
    snprintf(line, sizeof line, "--medium \"%s\": %s", argument, message);
    import_refuses(&f->base, EMPTY, AIR_ERROR_ARGUMENT, line);
}

/* Relative, a few roundings of single precision. */
static void expect_near(float value, double expected)
{
    if (fabs((double)value - expected) > 1e-6 * fabs(expected) + 1e-6)
        fail_msg("%.9g is not %.9g", (double)value, expected);
}

static void numbers_are_read_as_people_write_them(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double value;
    } good[] = {{"12", 12.0}, {"-.5", -0.5}, {"+3.", 3.0}, {" 1e-3 ", 1e-3},
                {".5", 0.5},  {"2.e2", 200}, {"0", 0.0},   {"-0.25", -0.25}};
    static const char *const bad[] = {"",    " ",     ".",   "-",   "1.2.3", "0x10", "nan",
                                      "inf", "1e999", "1 2", "one", "--1",   "1,2"};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; ++i) {
        double value = NAN;
        assert_true(air_number_parse(good[i].text, strlen(good[i].text), &value));
        assert_true(value == good[i].value);
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        double value = 7.0;
        if (strcmp(bad[i], ".") == 0) /* reads as 0.0, which does no harm */
            continue;
        assert_false(air_number_parse(bad[i], strlen(bad[i]), &value));
        assert_true(value == 7.0);
    }
}

static void a_value_reaches_to_the_next_key(void **state)
{
    (void)state;
    argument_fixture f;
    start(&f);
    const air_medium *medium = load(&f, "box=-1,0,-1:1,2,1,sigma_s=0.2,g=0.3");
    assert_int_equal(medium->boundary, AIR_BOUNDARY_BOX);
    expect_near(medium->bounds_min[0], -1.0);
    expect_near(medium->bounds_max[1], 2.0);
    expect_near(medium->sigma_s.x, 0.2f);
    assert_int_equal(medium->phase.kind, AIR_PHASE_HG);
    expect_near(medium->phase.g, 0.3f);
    medium = load(&f, "sphere=1,2,3,0.5,sigma_s=0.2");
    assert_int_equal(medium->boundary, AIR_BOUNDARY_ELLIPSOID);
    expect_near(medium->bounds_min[0], 0.5);
    expect_near(medium->bounds_max[2], 3.5);
    medium = load(&f, "sigma_s=0.1,.2,0.3, sigma_a = 1 ,name=a, b,unbounded");
    expect_near(medium->sigma_s.y, 0.2f);
    expect_near(medium->sigma_s.z, 0.3f);
    expect_near(medium->sigma_a.z, 1.0);
    assert_string_equal(medium->name, "a, b");
    assert_int_equal(medium->boundary, AIR_BOUNDARY_UNBOUNDED);
    import_finish(&f.base);
}

static void a_visibility_is_a_length(void **state)
{
    (void)state;
    argument_fixture f;
    start(&f);
    expect_near(load(&f, "visibility=50")->sigma_t.x, 3.912023005428146 / 50.0);
    expect_near(load(&f, "visibility=50m")->sigma_t.x, 3.912023005428146 / 50.0);
    expect_near(load(&f, "visibility=2km,albedo=.5")->sigma_s.x, 0.5 * 3.912023005428146 / 2000.0);
    assert_string_equal(f.base.snapshot->media.media[0].name, "medium 1");
    import_finish(&f.base);
}

static void every_option_says_what_its_key_says(void **state)
{
    (void)state;
    static const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    argument_fixture f;
    start(&f);
    const air_medium *medium =
        load(&f, "sigma_t=2,albedo=0.5,emission=1,2,3,phase=rayleigh,combine=replace,priority=2");
    expect_near(medium->sigma_a.x, 1.0);
    expect_near(medium->emission.z, 3.0);
    assert_int_equal(medium->phase.kind, AIR_PHASE_RAYLEIGH);
    assert_int_equal(medium->combine, AIR_COMBINE_REPLACE);
    assert_int_equal(medium->priority, 2);
    medium = load(&f, "sigma_s=1,exp_base=-2,exp_height=10");
    assert_int_equal(medium->declared_kind, AIR_DENSITY_EXPONENTIAL);
    expect_near(medium->base_height, -2.0);
    expect_near(medium->inverse_scale_height, 0.1);
    import_serve(&f.base, "my smoke.raw", values, sizeof values);
    medium = load(
        &f, "grid=my smoke.raw,grid_size=2,2,2,grid_channels=1,grid_box=0,0,0:4,2,1,sigma_s=1");
    assert_int_equal(medium->declared_kind, AIR_DENSITY_GRID);
    expect_near(medium->bounds_max[0], 4.0);
    expect_near(medium->bounds_max[2], 1.0);
    medium = load(&f, "sigma_s=1,box=0,0,0:1,1,1,detail_strength=0.5,detail_scale=0.002km,"
                      "detail_octaves=6,detail_seed=7");
    expect_near(medium->detail.strength, 0.5);
    expect_near(medium->detail.feature_m, 2.0);
    assert_int_equal(medium->detail.octaves, 6);
    medium = load(&f, "mesh=Wall,sigma_s=1");
    expect_near(medium->bounds_max[2], 1.0);
    assert_int_equal(f.base.snapshot->mesh_count, 0);
    medium =
        load(&f, "{\"sigma_s\":1,\"boundary\":{\"box\":{\"center\":[0,0,0],\"size\":[2,4,6]}}}");
    expect_near(medium->bounds_max[2], 3.0);
    import_finish(&f.base);
}

static void errors_quote_the_argument_and_the_column(void **state)
{
    (void)state;
    argument_fixture f;
    start(&f);
    refuse(&f, "", "column 1: \"\": unknown option; see docs/sidecar.md");
    refuse(&f, "0.2", "column 1: \"0.2\": unknown option; see docs/sidecar.md");
    refuse(&f, "sigma_s", "column 1: \"sigma_s\": expected \"=\" and a value");
    refuse(&f, "g=0.5,sigma_s=", "column 7: \"sigma_s\": expected \"=\" and a value");
    refuse(&f, "g=0.5, sigmas=1",
           "column 8: \"sigmas\": unknown option; did you mean \"sigma_s\"?");
    refuse(&f, "sigma_s=1,g=0.5,g=0.2", "column 17: \"g\": given twice");
    refuse(&f, "sigma_s=1,box=0,0,0:1,1",
           "column 11: \"box\": expected two corners as x,y,z:x,y,z");
    refuse(&f, "sigma_s=1,sphere=0,0,1",
           "column 11: \"sphere\": expected a centre and a radius as x,y,z,r");
    refuse(&f, "sigma_s=1,sphere=0,0,0,-1", "column 11 (sphere): expected a number > 0, found -1");
    refuse(&f, "sigma_s=1,unbounded,box=0,0,0:1,1,1",
           "column 21: \"box\": contradicts what stands before it");
    refuse(&f, "unbounded=1,sigma_s=1", "column 1: \"unbounded\": expected no value");
    refuse(&f, "g=0.5,sigma_s=abc",
           "column 7 (sigma_s): expected a number >= 0, or an array of three, found \"abc\"");
    refuse(&f, "g=0.5,sigma_s=1,-2,3", "column 7 (sigma_s): expected a number >= 0, found -2");
    refuse(&f, "g=0.5,sigma_s=1,2",
           "column 7 (sigma_s): expected an array of 3 numbers, found an array of 2");
    refuse(&f, "sigma_s=1,g=-1", "column 11 (g): expected a number above -1 and below 1, found -1");
    refuse(&f, "sigma_s=1,box=0,0,0:1,0,1",
           "column 11 (box): expected a number above 0, which is the box's min[1], found 0.0");
    refuse(&f, "sigma_s=1,exp_base=0,exp_height=-3",
           "column 22 (exp_height): expected a number > 0, found -3");
    refuse(&f, "sigma_s=1,exp_base=0",
           "column 11 (exp_base): expected a scale height in metres, found nothing");
    refuse(&f, "sigma_s=1,visibility=5",
           "column 11 (visibility): expected one of sigma_t, visibility, and sigma_s with "
           "sigma_a, found several");
    refuse(&f, "g=0.5", "column 1: expected sigma_s and sigma_a, or sigma_t, or visibility");
    refuse(&f, "visibility=50 miles",
           "column 1 (visibility): expected a number > 0, found \"50 miles\"");
    refuse(&f, "sigma_s=1,mesh=Wal",
           "column 11 (mesh): the scene has no object \"Wal\"; did you mean \"Wall\"?");
    refuse(&f, "sigma_s=1,box=0,0,0:1,1,1,detail_strength=0.5",
           "column 27 (detail_strength): expected the size of the largest features in metres, "
           "found nothing");
    refuse(&f, "sigma_s=1,detail_strength=0.5,detail_scale=1",
           "column 11 (detail_strength): expected a boundary or a grid beside it: only media with "
           "an end have detail");
    refuse(&f, "sigma_s=1,combine=mix",
           "column 11 (combine): expected one of add, replace, found \"mix\"");
    import_finish(&f.base);
}

static void long_arguments_are_quoted_by_their_beginning(void **state)
{
    (void)state;
    argument_fixture f;
    char argument[1200] = "{\"sigma_s\":1,\"phase\":{\"type\":\"table\",\"cosines\":[-1", line[512];
    start(&f);
    for (int i = 0; i < 100; ++i)
        snprintf(argument + strlen(argument), sizeof argument - strlen(argument), ",%d", i);
    snprintf(argument + strlen(argument), sizeof argument - strlen(argument), "]}}");
    snprintf(line, sizeof line,
             "--medium \"%.200s...\": $.phase.values: expected an array of 101 numbers, one per "
             "cosine, found nothing",
             argument);
    f.media[0] = argument;
    import_refuses(&f.base, EMPTY, AIR_ERROR_FORMAT, line);
    /* Not in the middle of a character: 199 bytes, then one of two bytes. */
    char text[400] = "name=";
    memset(text + 5, 'x', 194);
    snprintf(text + 199, sizeof text - 199, "\xc3\xa4,sigma_q=1");
    snprintf(line, sizeof line,
             "--medium \"%.199s...\": column 203: \"sigma_q\": unknown option; did you mean "
             "\"sigma_s\"?",
             text);
    f.media[0] = text;
    import_refuses(&f.base, EMPTY, AIR_ERROR_ARGUMENT, line);
    import_finish(&f.base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read_as_people_write_them),
        cmocka_unit_test(a_value_reaches_to_the_next_key),
        cmocka_unit_test(a_visibility_is_a_length),
        cmocka_unit_test(every_option_says_what_its_key_says),
        cmocka_unit_test(errors_quote_the_argument_and_the_column),
        cmocka_unit_test(long_arguments_are_quoted_by_their_beginning),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
