/* What the program oracle_arealight says of tables, good ones, wrong ones and what is none. */
#include "oracle_run.h"

#ifdef AIR_ORACLE_AREALIGHT

/* Writes polygons to oracle_public.csv and a table beside it, and runs the program on one of them.
 * Its exit code, and the beginning of what it said. */
static int run_oracle(const char *polygons, const char *table, char said[ORACLE_SAID])
{
    char folder[] = "/tmp/airlight-oracle-XXXXXX", paths[2][64], command[512];
    assert_non_null(mkdtemp(folder));
    snprintf(paths[0], sizeof paths[0], "%s/oracle_public.csv", folder);
    snprintf(paths[1], sizeof paths[1], "%s/table.csv", folder);
    for (int i = 0; i < 2; i++) {
        const char *text = i == 0 ? polygons : table;
        FILE *const file = text == NULL ? NULL : fopen(paths[i], "w");
        if (file != NULL) {
            assert_true(fputs(text, file) >= 0);
            assert_int_equal(fclose(file), 0);
        }
    }
    snprintf(command, sizeof command, "%s %s 2>&1", AIR_ORACLE_AREALIGHT,
             paths[table == NULL ? 0 : 1]);
    const int code = oracle_command(command, said);
    (void)unlink(paths[0]);
    (void)unlink(paths[1]);
    assert_int_equal(rmdir(folder), 0);
    return code;
}

#define POLYGONS                                                                                   \
    "id,class,nv,wox,woy,woz,x0,y0,z0,x1,y1,z1,x2,y2,z2,solid_angle,min_dist,"                     \
    "S_g-0.95,S_g-0.6,S_g-0.1,S_g0,S_g0.4,S_g0.9,S_g0.99\n"
/* An octant of the directions, wo along an edge of it. */
#define OCTANT "a,octant,3,0,0,1,1,0,0,0,1,0,0,0,1,"
/* Four such octants are the half about wo: S is a quarter of that half's amount. */
#define SCATTERED                                                                                  \
    "0.247277967792703245,0.219000943238327442,0.143641477115138445,"                              \
    "0.125,0.0562251313573805704,0.00572581774818911111,0.000522974377437263228\n"
#define GOOD  OCTANT "1.5707963267948966,0.57735026918962576," SCATTERED
#define HAZE  "id,mu_t,Tbar\n"
#define LOBES "id,g,S_ltsd_KL,S_mix,S_exact\n"

static void tables_are_judged_and_what_is_none_is_named(void **state)
{
    (void)state;
    static const struct judged {
        const char *polygons, *table, *said;
        int code;
    } judged[] = {
        {POLYGONS GOOD, NULL, "1 rows", 0},
        {POLYGONS OCTANT "1.5707963267948966,0.57735026918962576,1,1,1,0.125,1,1,1\n", NULL,
         "TOO LARGE", 1},
        {POLYGONS OCTANT "1.57,0.577,1,1,1,1,1,1,1\n", NULL, "TOO LARGE", 1},
        {POLYGONS OCTANT "1.57,0.577,1,1,1,1,1,1,x\n", NULL,
         ":2: expected a number in column S_g0.99", 2},
        {POLYGONS OCTANT "1.57\n", NULL, ":2: expected as many cells", 2},
        {POLYGONS "a,b,2,0,0,1,1,0,0,0,1,0,0,0,1,1,1,1,1,1,1,1,1,1\n", NULL, "3 to 16 in column nv",
         2},
        {POLYGONS, NULL, ":1: expected rows", 2},
        {POLYGONS GOOD, "", ":1: expected a header", 2},
        {POLYGONS GOOD, "a,b\n1,2\n", ":1: expected a column wox", 2},
        {POLYGONS GOOD, HAZE "a,0,1.5707963267948966\n", "1 rows", 0},
        {POLYGONS GOOD, HAZE "a,1,1.5707963267948966\n", "TOO LARGE", 1},
        {POLYGONS GOOD, HAZE "b,1,1\n", ":2: expected an id of the table of polygons, not b", 2},
        {POLYGONS GOOD, HAZE, ":1: expected rows", 2},
        {NULL, HAZE "a,0,1.5\n", "expected a table of polygons beside it", 2},
        {POLYGONS GOOD, LOBES "a,0,0.125,0.125,0.125\n", "1 rows", 0},
        {POLYGONS GOOD, LOBES "a,0,0.126,0.125,0.125\n", "TOO LARGE", 1},
        {POLYGONS GOOD, LOBES "a,0.3,0.125,0.125,0.125\n", ":2: expected an asymmetry", 2},
    };
    char said[ORACLE_SAID];
    for (size_t i = 0; i < sizeof judged / sizeof *judged; i++) {
        const int code = run_oracle(judged[i].polygons, judged[i].table, said);
        if (code != judged[i].code || strstr(said, judged[i].said) == NULL) {
            fail_msg("%zu: exit code %d instead of %d, \"%s\" not in \"%s\"", i, code,
                     judged[i].code, judged[i].said, said);
        }
    }
}

#else

static void tables_are_judged_and_what_is_none_is_named(void **state)
{
    (void)state;
    printf("skipped: built without oracle_arealight\n");
    skip();
}

#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_judged_and_what_is_none_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
