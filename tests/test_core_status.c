/* Names of statuses, and the version. */
#include <stdio.h>
#include <string.h>

#include "airlight/status.h"
#include "airlight/version.h"
#include "cmocka_test.h"

static void every_status_has_a_name_of_its_own(void **state)
{
    (void)state;
    for (int a = AIR_OK; a <= AIR_ERROR_INTERNAL; ++a) {
        for (int b = a + 1; b <= AIR_ERROR_INTERNAL + 1; ++b) {
            assert_string_not_equal(air_status_name((air_status)a), air_status_name((air_status)b));
        }
    }
    assert_string_equal(air_status_name(AIR_OK), "ok");
}

static void version_text_matches_the_header(void **state)
{
    (void)state;
    char text[32];
    (void)snprintf(text, sizeof text, "%d.%d.%d", AIR_VERSION_MAJOR, AIR_VERSION_MINOR,
                   AIR_VERSION_PATCH);
    assert_string_equal(air_version(), text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_status_has_a_name_of_its_own),
        cmocka_unit_test(version_text_matches_the_header),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
