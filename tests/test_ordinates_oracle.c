/* What the program oracle_ordinates says of folders: good data, numbers that are changed, and what
 * is no data. */
#include <math.h>
#include <stdbool.h>

#include "oracle_run.h"

enum { TEXT_MOST = 1 << 14 };

static char folder[32], good_exits[TEXT_MOST], good_shells[TEXT_MOST], good_fluence[6 * 4096 * 4];
static bool have_data;

static bool read_data(const char *name, char *out, size_t most)
{
    char path[512];
    snprintf(path, sizeof path, "%s/spec/data/ordinates/%s", AIR_SHARED_DIR, name);
    FILE *const file = fopen(path, "rb");
    if (file == NULL) {
        print_message("no %s\n", path);
        return false;
    }
    (void)fread(out, 1, most, file);
    (void)fclose(file);
    return true;
}

static int set_up(void **state)
{
    (void)state;
    have_data = read_data("cube_g07_exit.csv", good_exits, sizeof good_exits - 1) &&
                read_data("radial_g0.7_s0.8.csv", good_shells, sizeof good_shells - 1) &&
                read_data("cube_g07_fluence.f32", good_fluence, sizeof good_fluence);
    return 0;
}

/* ---- folders ---- */

static void make_folder(void)
{
    strcpy(folder, "/tmp/airlight-oracle-XXXXXX");
    assert_non_null(mkdtemp(folder));
}

static void put(const char *name, const void *bytes, size_t count)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *const file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, count, file), count);
    assert_int_equal(fclose(file), 0);
}

static void put_text(const char *name, const char *text) { put(name, text, strlen(text)); }

/* Judges the folder, and removes these files and it. */
static int judge(const char *const names[], size_t count, char said[ORACLE_SAID])
{
    char text[256];
    snprintf(text, sizeof text, "%s %s 2>&1", AIR_ORACLE_ORDINATES, folder);
    const int code = oracle_command(text, said);
    for (size_t i = 0; i < count; i++) {
        snprintf(text, sizeof text, "%s/%s", folder, names[i]);
        assert_int_equal(unlink(text), 0);
    }
    assert_int_equal(rmdir(folder), 0);
    return code;
}

/* Whether some line says all three. */
static bool says(char *said, const char *mode, const char *verdict, const char *file)
{
    for (char *line = strtok(said, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        if (strstr(line, mode) != NULL && strstr(line, verdict) != NULL &&
            strstr(line, file) != NULL) {
            return true;
        }
    }
    return false;
}

/* ---- good and changed data ---- */

static void good_data_pass(void **state)
{
    static const char *const names[2] = {"cube_g07_exit.csv", "radial_g0.7_s0.8.csv"};
    char said[ORACLE_SAID];
    (void)state;
    if (!have_data) {
        skip();
    }
    make_folder();
    put_text(names[0], good_exits);
    put_text(names[1], good_shells);
    const int code = judge(names, 2, said);
    if (code != 0 || strstr(said, "TOO ") != NULL) {
        fail_msg("code %d: %s", code, said);
    }
}

/* Exchanges a piece of a text for one of the same length. */
static void change(const char *text, const char *was, const char *is, char *out)
{
    strcpy(out, text);
    char *const at = strstr(out, was);
    assert_non_null(at);
    memcpy(at, is, strlen(is));
}

static void a_changed_number_is_found_with_file_and_mode(void **state)
{
    static const struct {
        const char *name, *was, *is, *mode, *verdict;
    } changes[3] = {
        {"cube_g07_exit.csv", "0.243857,", "0.253857,", "dom, 10 bands", "TOO LARGE"},
        {"radial_g0.7_s0.8.csv", ",0.850561,", ",7.850561,", "cm, curvature", "TOO LARGE"},
        {"cube_g07_fluence.f32", NULL, NULL, "dom, 5 bands", "TOO LARGE"},
    };
    static char text[TEXT_MOST];
    char said[ORACLE_SAID];
    (void)state;
    for (int i = 0; i < 3 && have_data; i++) {
        make_folder();
        if (changes[i].was != NULL) {
            change(i == 0 ? good_exits : good_shells, changes[i].was, changes[i].is, text);
            put_text(changes[i].name, text);
        } else { /* a cell nine times as bright as the mean: 8 / sqrt(4096), 12 % of the mean */
            const float bright = 8.0f;
            static char bytes[sizeof good_fluence];
            memcpy(bytes, good_fluence, sizeof bytes);
            memcpy(bytes + 4 * 1234, &bright, sizeof bright);
            put(changes[i].name, bytes, sizeof bytes);
        }
        const int code = judge(&changes[i].name, 1, said);
        if (code != 1 || !says(said, changes[i].mode, changes[i].verdict, changes[i].name)) {
            fail_msg("%s: code %d: %s", changes[i].name, code, said);
        }
    }
    if (!have_data) {
        skip();
    }
}

/* ---- broken and unknown files ---- */

#define PARAMETERS "stem,cells,shells,size_m,sigma_s,sigma_a,g,light\n"
#define SMALL      PARAMETERS "cube_a,4,,1,1,0,0,1\nradial_a,4,2,1,1,0,0,1\n"

static void expect_one_message(const char *parameters, const char *name, const void *bytes,
                               size_t count, const char *expected)
{
    const char *const names[2] = {name, "parameters.csv"};
    char said[ORACLE_SAID];
    make_folder();
    put(name, bytes, count);
    if (parameters != NULL) {
        put_text("parameters.csv", parameters);
    }
    const int code = judge(names, parameters != NULL ? 2 : 1, said);
    const char *const end = strchr(said, '\n');
    if (code != 2 || strstr(said, expected) == NULL || end == NULL || end[1] != '\0') {
        fail_msg("code %d, \"%s\" not in \"%s\"", code, expected, said);
    }
}

static void broken_texts_end_in_one_message(void **state)
{
    static const struct {
        const char *parameters, *name, *text, *expected;
    } broken[] = {
        {NULL, "cube_unheard_exit.csv", "", "expected a row cube_unheard in "},
        {NULL, "radial_unheard.csv", "", "expected a row radial_unheard in "},
        {SMALL, "cube_a_exit.csv", "", "cube_a_exit.csv:1: expected a header"},
        {SMALL, "cube_a_exit.csv", "a,b\n1,2\n", "expected a column quantity"},
        {SMALL, "cube_a_exit.csv", "quantity,b\nx,2\n", "expected a column mean"},
        {SMALL, "cube_a_exit.csv", "quantity,mean\nexit_x0,0.1\n", "expected a row exit_x1"},
        {SMALL, "cube_a_exit.csv", "quantity,mean\nexit_x0,z\n",
         "expected a number in column mean"},
        {SMALL, "cube_a_exit.csv", "quantity,mean\nexit_x0,nan\n", "expected a number in column"},
        {SMALL, "cube_a_exit.csv", "quantity,mean\nexit_x0\n", "expected as many cells"},
        {SMALL, "radial_a.csv", "", "radial_a.csv:1: expected a header"},
        {SMALL, "radial_a.csv", "shell\n0\n", ":2: expected a column r_inner"},
        {SMALL, "radial_a.csv", "r_inner\n-1\n",
         "expected a number of 0 to 1e+12 in column r_inner"},
        {SMALL, "radial_a.csv", "r_inner\n", "expected 2 shells, not 0"},
        {SMALL, "cube_a_flux.f32", "", "expected cube_NAME_fluence.f32"},
        {SMALL, "other.csv", "", "expected files cube_*"},
        {"a,b\n1,2\n", "radial_a.csv", "", "parameters.csv:2: expected a column stem"},
        {"", "radial_a.csv", "", "parameters.csv:1: expected a header"},
        {PARAMETERS "radial_a,4,2,1,1,0,1,1\n", "radial_a.csv", "",
         "parameters.csv:2: expected a number of -0.99 to 0.99 in column g"},
        {PARAMETERS "radial_a,5,2,1,1,0,0,1\n", "radial_a.csv", "",
         "parameters.csv:2: expected an even number in column cells"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        expect_one_message(broken[i].parameters, broken[i].name, broken[i].text,
                           strlen(broken[i].text), broken[i].expected);
    }
}

static void broken_floats_end_in_one_message(void **state)
{
    static float numbers[6 * 64 + 1];
    (void)state;
    expect_one_message(SMALL, "cube_a_fluence.f32", numbers, sizeof numbers - 8,
                       "expected 384 floats, 1536 bytes, not 1532");
    expect_one_message(SMALL, "cube_a_fluence.f32", numbers, sizeof numbers,
                       "expected 384 floats, 1536 bytes, not at least 1540");
    expect_one_message(SMALL, "cube_a_angular.f32", numbers, 5, "expected 640 floats");
    numbers[77] = NAN;
    expect_one_message(SMALL, "cube_a_fluence.f32", numbers, sizeof numbers - 4,
                       "expected numbers, not nan at float 77");
}

static void absent_folders_are_skipped_if_so_asked(void **state)
{
    char said[ORACLE_SAID];
    (void)state;
    assert_int_equal(oracle_command(AIR_ORACLE_ORDINATES " --skip-absent /nowhere/data 2>&1", said),
                     77);
    assert_non_null(strstr(said, "/nowhere/data: No such file or directory, skipped"));
    assert_int_equal(oracle_command(AIR_ORACLE_ORDINATES " /nowhere/data 2>&1", said), 2);
    assert_int_equal(oracle_command(AIR_ORACLE_ORDINATES " 2>&1", said), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_data_pass),
        cmocka_unit_test(a_changed_number_is_found_with_file_and_mode),
        cmocka_unit_test(broken_texts_end_in_one_message),
        cmocka_unit_test(broken_floats_end_in_one_message),
        cmocka_unit_test(absent_folders_are_skipped_if_so_asked),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
