/* airlight convert of scenes: the picture stays the same, and what is said to wrong input. */
#include "cli_run.h"

static void run(const cli_directory *directory, const char *const *arguments, int exit_code,
                const char *err)
{
    cli_result result = cli_run(directory, arguments);
    if (result.exit_code != exit_code || strstr(result.err, err) == NULL)
        fail_msg("%s %s: exit code %d, \"%.500s\"", arguments[0], arguments[1], result.exit_code,
                 result.err);
    cli_free(&result);
}

static void same_bytes(const char *a, const char *b)
{
    FILE *files[2] = {fopen(a, "rb"), fopen(b, "rb")};
    int bytes[2] = {0, 0};
    assert_true(files[0] != NULL && files[1] != NULL);
    while (bytes[0] == bytes[1] && bytes[0] != EOF)
        for (int i = 0; i < 2; i++)
            bytes[i] = fgetc(files[i]);
    fclose(files[0]);
    fclose(files[1]);
    if (bytes[0] != bytes[1])
        fail_msg("%s and %s differ", a, b);
}

static void render(const cli_directory *directory, const char *scene, const char *picture)
{
    const char *const arguments[] = {"render",   scene,       "-q",    "--width", "32",
                                     "--height", "24",        "--spp", "4",       "-o",
                                     picture,    "--threads", "1",     NULL};
    run(directory, arguments, 0, "");
}

static void shipped_scenes_give_the_same_pictures(void **state)
{
    (void)state;
    static const char *const scenes[] = {AIR_SOURCE_DIR "/scenes/roombeam/roombeam.gltf",
                                         AIR_SOURCE_DIR "/scenes/sunroom/sunroom.gltf"};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        cli_directory directory;
        cli_enter(&directory);
        const char *const convert[] = {"convert", scenes[i], "scene.glb", NULL};
        run(&directory, convert, 0, "wrote scene.glb");
        assert_int_equal(cli_count_entries(), 5); /* ., .., the fixture's two, and this one */
        render(&directory, scenes[i], "before.pfm");
        render(&directory, "scene.glb", "after.pfm");
        same_bytes("before.pfm", "after.pfm");
        cli_leave(&directory);
    }
}

/* The lights change their order once, and the picture its noise with it; after that nothing moves.
 */
static void a_converted_scene_converts_to_itself(void **state)
{
    (void)state;
    cli_directory directory;
    cli_enter(&directory);
    const char *const first[] = {"convert", "-v", AIR_SOURCE_DIR "/scenes/smoke/smoke.gltf",
                                 "a/smoke.glb", NULL};
    const char *const second[] = {"convert", "a/smoke.glb", "b/smoke.glb", NULL};
    assert_int_equal(mkdir("a", 0777), 0);
    assert_int_equal(mkdir("b", 0777), 0);
    run(&directory, first, 0, "refers to smoke.sky.exr beside it");
    run(&directory, second, 0, "wrote b/smoke.glb");
    same_bytes("a/smoke.glb", "b/smoke.glb");
    same_bytes("a/smoke.sky.exr", "b/smoke.sky.exr");
    same_bytes("a/smoke.smoke.vol", "b/smoke.smoke.vol");
    render(&directory, "a/smoke.glb", "a.pfm");
    render(&directory, "b/smoke.glb", "b.pfm");
    same_bytes("a.pfm", "b.pfm");
    cli_leave(&directory);
}

static void scene_options_become_part_of_the_scene(void **state)
{
    (void)state;
    cli_directory directory;
    cli_enter(&directory);
    cli_write_scene("room.gltf", "quad.bin", CLI_LAMP);
    const char *const convert[] = {"convert",       "room.gltf",     "whole.glb",  "-q", "--medium",
                                   "visibility=50", "--environment", "constant=1", NULL};
    const char *const info[] = {"info", "whole.glb", NULL};
    cli_result result = cli_run(&directory, convert);
    assert_int_equal(result.exit_code, 0);
    assert_string_equal(result.err, "");
    cli_free(&result);
    result = cli_run(&directory, info);
    assert_int_equal(result.exit_code, 0);
    assert_non_null(strstr(result.out, "medium 1"));
    assert_non_null(strstr(result.out, "environment"));
    cli_free(&result);
    cli_leave(&directory);
}

static void wrong_input_is_told(void **state)
{
    (void)state;
    cli_directory directory;
    cli_enter(&directory);
    cli_write_scene("room.gltf", "quad.bin", CLI_LAMP);
    const char *const ending[] = {"convert", "room.gltf", "room.obj", NULL};
    const char *const source[] = {"convert", "room.obj", "room.glb", NULL};
    const char *const absent[] = {"convert", "absent.gltf", "room.glb", NULL};
    const char *const itself[] = {"convert", "same.glb", "./same.glb", NULL};
    const char *const sidecar[] = {"convert", "room.gltf", "room.glb", NULL};
    const char *const write[] = {"convert", "-q", "room.gltf", "same.glb", NULL};
    run(&directory, ending, 2, "room.obj: expected an output that ends in .glb");
    run(&directory, source, 2, "room.obj: expected a scene that ends in .gltf, .glb or .xml");
    run(&directory, absent, 1, "absent.gltf");
    run(&directory, write, 0, "");
    run(&directory, itself, 2, "./same.glb: is the scene itself");
    cli_write_text("room.airlight.json", "{}");
    run(&directory, sidecar, 1, "room.airlight.json is there and would be read with it");
    assert_false(cli_exists("room.glb"));
    cli_leave(&directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shipped_scenes_give_the_same_pictures),
        cmocka_unit_test(a_converted_scene_converts_to_itself),
        cmocka_unit_test(scene_options_become_part_of_the_scene),
        cmocka_unit_test(wrong_input_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
