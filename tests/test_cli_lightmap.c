/* From a bake to a picture of it, by the command. */
#include <jansson.h>
#include <math.h>

#include "cli_result.h"

#define BAKE "bake", "lit.gltf", "-o", "lit.lightmap", "--spp", "16", "--texels-per-metre", "4"
#define RENDER                                                                                     \
    "render", "lit.gltf", "--lightmap", "lit.lightmap", "--width", "32", "--spp", "4", "-q"

static void expect(const cli_directory *directory, int exit_code, const char *said,
                   const char *const *arguments)
{
    cli_result result = cli_run(directory, arguments);
    if (result.exit_code != exit_code || strstr(result.err, said) == NULL) {
        fail_msg("airlight %s: exit code %d: %s", arguments[0], result.exit_code, result.err);
    }
    cli_free(&result);
}

/* The mean of green as `render --json` prints it. */
static double mean_green(const cli_directory *directory, const char *const *arguments)
{
    json_t *const report = cli_run_json(directory, arguments);
    const double mean = json_number_value(json_array_get(json_object_get(report, "mean"), 1));
    json_decref(report);
    return mean;
}

/* A floor that nothing lights but the lamp above it: what is seen of the bake has the mean of what
 * path makes of it. Texels of 0.25 m, 1.5 m from the lamp, smear its light by (0.25 / 1.5)^2 of its
 * curvature at most, 2.8 % (test_render_baked.c); what the picture sees of the floor's borders,
 * where half of what a texel's neighbours have may be missing, is half a texel of 16 at each side
 * of which a quarter is lost: another 3.2 %. */
static void a_bake_is_seen_as_path_sees_the_scene(void **state)
{
    (void)state;
    static const char *const bake[] = {BAKE, "-q", NULL};
    static const char *const shown[] = {RENDER, "--json", "-o", "shown.exr", NULL};
    static const char *const traced[] = {"render", "lit.gltf",   "--width", "32",
                                         "--spp",  "64",         "-q",      "--json",
                                         "-o",     "traced.exr", NULL};
    static const char *const info[] = {"info", "shown.exr", "--json", NULL};
    cli_directory directory;
    cli_enter(&directory);
    expect(&directory, 0, "", bake);
    const double with = mean_green(&directory, shown), without = mean_green(&directory, traced);
    printf("mean %g and %g, off by %+.2f %%\n", with, without, 100.0 * (with / without - 1.0));
    assert_true(without > 0.0 && fabs(with / without - 1.0) <= 0.06);
    json_t *const description = cli_run_json(&directory, info);
    const json_t *const attributes = json_object_get(description, "attributes");
    assert_string_equal(json_string_value(json_object_get(attributes, "airlight:lightmap")),
                        "lit.lightmap");
    json_decref(description);
    cli_leave(&directory);
}

static void what_does_not_fit_is_told(void **state)
{
    (void)state;
    static const char *const bake[] = {BAKE, "-q", NULL};
    static const char *const shown[] = {RENDER, NULL};
    static const char *const absent[] = {"render", "lit.gltf", "--lightmap", "nowhere", "-q", NULL};
    static const char *const vertices[] = {BAKE, "-q", "--targets", "vertices", NULL};
    static const char *const other[] = {"render",       "other.gltf", "--lightmap",
                                        "lit.lightmap", "-q",         NULL};
    cli_directory directory;
    cli_enter(&directory);
    expect(&directory, 1, "nowhere/lightmap.json", absent);
    expect(&directory, 0, "", vertices);
    expect(&directory, 1, "lightmap of lit.gltf: it has no pages", shown);
    expect(&directory, 0, "", bake);
    cli_write_scene("other.gltf", "other.bin", CLI_LAMP);
    /* another floor: the square cut along its other diagonal */
    FILE *const file = fopen("quad.bin", "r+b");
    char bytes[60];
    static const uint16_t indices[6] = {0, 1, 3, 1, 2, 3};
    assert_non_null(file);
    assert_int_equal(fread(bytes, 1, sizeof bytes, file), sizeof bytes);
    fclose(file);
    memcpy(bytes + 48, indices, sizeof indices);
    cli_write_bytes("other.bin", bytes, sizeof bytes);
    expect(&directory, 1, "has other triangles in other.gltf: bake that scene anew", other);
    assert_false(cli_exists("other.exr"));
    cli_leave(&directory);
}

/* A scene whose lights are gone is still lit by its lightmap. */
static void a_lightmap_is_light_enough(void **state)
{
    (void)state;
    static const char *const bake[] = {BAKE, "-q", NULL};
    static const char *const shown[] = {RENDER, "--json", NULL};
    static const char *const black[] = {"render", "lit.gltf", "-q", NULL};
    cli_directory directory;
    cli_enter(&directory);
    expect(&directory, 0, "", bake);
    cli_write_scene("lit.gltf", "quad.bin", "");
    expect(&directory, 1, "no light in the scene", black);
    assert_true(mean_green(&directory, shown) > 0.0);
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bake_is_seen_as_path_sees_the_scene),
        cmocka_unit_test(what_does_not_fit_is_told),
        cmocka_unit_test(a_lightmap_is_light_enough),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
