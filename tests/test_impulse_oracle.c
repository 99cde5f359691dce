/* What the program oracle_impulse says of tables, good ones, wrong ones and what is none. */
#include "oracle_run.h"

#define SHORT                                                                                      \
    "id,emitter,quantity,d,theta_s_rad,g,sigma_s,sigma_a,bounce,value,mc_value,mc_stderr\n"
#define FLUENCE "a,point,fluence,1,,0,1,0,1,"

/* Fluences need no tables to be built; Phi_1(1) = 0.4340201594. */
static void tables_are_judged_and_what_is_none_is_named(void **state)
{
    static const struct {
        const char *table, *said;
        int code;
    } judged[] = {
        {"# comment\n" SHORT FLUENCE "0.4340201594,0.434,1e-3\n", "1 rows", 0},
        {SHORT FLUENCE "0.43403,,\n", "TOO LARGE", 1},
        {SHORT FLUENCE "0.4340201594,0.44,1e-3\n", "TOO LARGE", 1},
        {SHORT FLUENCE "x,,\n", ":2: expected a number in column value", 2},
        {SHORT FLUENCE "1\n", ":2: expected as many cells", 2},
        {SHORT "a,lamp,fluence,1,,0,1,0,1,1,,\n", "column emitter", 2},
        {SHORT "a,point,flux,1,,0,1,0,1,1,,\n", "column quantity", 2},
        {SHORT "a,point,fluence,-1,,0,1,0,1,1,,\n", "column d", 2},
        {SHORT "a,area,fluence,1,,0,1,0,1,1,,\n", "column theta_s_rad", 2},
        {SHORT "a,point,fluence,1,,0.5,1,0,1,1,,\n", "0 in column g", 2},
        {SHORT "a,point,fluence,1,,0,1,0,21,1,,\n", "column bounce", 2},
        {SHORT "a,point,single_zh,1,,0,1,0,1,,,\n", ":2: expected a column c0", 2},
        {SHORT, ":1: expected rows", 2},
        {"", ":1: expected a header", 2},
        {"a,b\n1,2\n", ":2: expected a column emitter", 2},
    };
    char said[ORACLE_SAID];
    (void)state;
    for (size_t i = 0; i < sizeof judged / sizeof judged[0]; i++) {
        const int code = oracle_run(AIR_ORACLE_IMPULSE, "", judged[i].table, said);
        if (code != judged[i].code || strstr(said, judged[i].said) == NULL) {
            print_message("table %zu: code %d: %s\n", i, code, said);
            fail();
        }
    }
}

static void absent_files_are_skipped_if_so_asked(void **state)
{
    char said[ORACLE_SAID];
    (void)state;
    assert_int_equal(oracle_run(AIR_ORACLE_IMPULSE, "--skip-absent no-such-file",
                                SHORT FLUENCE "0.4340201594,,\n", said),
                     77);
    assert_non_null(strstr(said, "skipped"));
    assert_int_equal(
        oracle_run(AIR_ORACLE_IMPULSE, "no-such-file", SHORT FLUENCE "0.4340201594,,\n", said), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_judged_and_what_is_none_is_named),
        cmocka_unit_test(absent_files_are_skipped_if_so_asked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
