/* Files of tables: they come back, and what is none is refused with the place. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "impulse/tables.h"
#include "impulse_tables_shared.h"
#include "memory_shortage.h"

static const char path[] = "impulse_test.impulse";

static impulse_shared shared;

static int set_up(void **state)
{
    (void)state;
    const air_impulse_params params = {.bins = 8,
                                       .angles = 2,
                                       .g_count = 2,
                                       .g = {-0.1, 0.7},
                                       .bounces = 2,
                                       .form = AIR_IMPULSE_ZH11_IRRADIANCE};
    shared_make(&shared, &params);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    (void)remove(path);
    shared_destroy(&shared);
    return 0;
}

static void files_keep_tables(void **state)
{
    air_impulse_tables *read;
    bool is;
    (void)state;
    assert_int_equal(air_impulse_tables_save(shared.context, shared.tables, path), AIR_OK);
    assert_int_equal(air_impulse_is_tables(shared.context, path, &is), AIR_OK);
    assert_true(is);
    assert_int_equal(air_impulse_tables_load(shared.context, path, &read), AIR_OK);
    assert_memory_equal(air_impulse_tables_params(read), air_impulse_tables_params(shared.tables),
                        sizeof(air_impulse_params));
    for (size_t i = 0; i < TABLES_PARTS; i++) {
        size_t count, other;
        const float *const a = impulse_tables_part(read, i, &count);
        const float *const b = impulse_tables_part(shared.tables, i, &other);
        assert_int_equal(count, other);
        assert_memory_equal(a, b, count * sizeof *a);
    }
    air_impulse_tables_destroy(read);
}

static char *read_all(size_t *out_size)
{
    static char data[1 << 20];
    FILE *const file = fopen(path, "rb");
    assert_non_null(file);
    *out_size = fread(data, 1, sizeof data, file);
    (void)fclose(file);
    return data;
}

static void write_all(const char *header, const char *data, size_t size)
{
    FILE *const file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fputs(header, file) >= 0);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static void assert_refused(const char *said)
{
    air_impulse_tables *read = (air_impulse_tables *)&shared;
    assert_int_equal(air_impulse_tables_load(shared.context, path, &read), AIR_ERROR_FORMAT);
    assert_null(read);
    if (strstr(air_context_last_error(shared.context), said) == NULL) {
        print_message("said: %s\n", air_context_last_error(shared.context));
        fail();
    }
}

#define HEAD "{\"airlight_table\":1,\"kind\":\"impulse\",\"form\":\"zh11-irradiance\","

static void wrong_headers_are_refused(void **state)
{
    static const struct {
        const char *header, *said;
    } wrong[] = {
        {"", "byte 0: expected one line of JSON"},
        {"{\"airlight_table\":1", "expected one line of JSON"},
        {"{]\n", "not JSON"},
        {"[]\n", "version number 1"},
        {"{\"airlight_table\":2}\n", "version number 1"},
        {"{\"airlight_table\":1,\"kind\":\"ltsd\"}\n", "\"kind\""},
        {"{\"airlight_table\":1,\"kind\":\"impulse\",\"form\":\"sh9\"}\n", "\"form\""},
        {HEAD "\"bins\":8,\"angles\":2}\n", "whole numbers"},
        {HEAD "\"bins\":8.5,\"angles\":2,\"bounces\":2,\"g\":[0]}\n", "whole numbers"},
        {HEAD "\"bins\":-8,\"angles\":2,\"bounces\":2,\"g\":[0]}\n", "whole numbers"},
        {HEAD "\"bins\":8,\"angles\":2,\"bounces\":2,\"g\":[]}\n", "\"g\""},
        {HEAD "\"bins\":8,\"angles\":2,\"bounces\":2,\"g\":[\"a\"]}\n", "\"g\""},
        {HEAD "\"bins\":8,\"angles\":2,\"bounces\":2,\"g\":[0.5,0.2]}\n", "rising"},
        {HEAD "\"bins\":100000,\"angles\":2,\"bounces\":2,\"g\":[0]}\n", "bins: expected"},
        {HEAD "\"bins\":8,\"angles\":2,\"bounces\":99,\"g\":[0]}\n", "bounces: expected"},
        {HEAD "\"bins\":8,\"angles\":2,\"bounces\":2,\"g\":[0]}\n", "bytes of numbers"},
    };
    bool is;
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        write_all(wrong[i].header, "abcd", 4);
        assert_refused(wrong[i].said);
    }
    write_all("{\"kind\":\"ltsd\"}\n", "", 0);
    assert_int_equal(air_impulse_is_tables(shared.context, path, &is), AIR_OK);
    assert_false(is);
    write_all("", "", 0);
    assert_int_equal(air_impulse_is_tables(shared.context, path, &is), AIR_OK);
    assert_false(is);
}

static void wrong_numbers_are_refused(void **state)
{
    static const unsigned char nan[4] = {0, 0, 0xc0, 0x7f}, huge[4] = {0, 0, 0, 0x4f};
    size_t size;
    (void)state;
    assert_int_equal(air_impulse_tables_save(shared.context, shared.tables, path), AIR_OK);
    char *const data = read_all(&size);
    write_all("", data, size - 1);
    assert_refused("bytes of numbers");
    data[size] = 0;
    write_all("", data, size + 1);
    assert_refused("bytes of numbers");
    for (int i = 0; i < 2; i++) {
        char said[64];
        memcpy(data + size - 4, i == 0 ? nan : huge, 4);
        write_all("", data, size);
        snprintf(said, sizeof said, "byte %zu: expected a number", size - 4);
        assert_refused(said);
    }
}

static void files_that_are_not_there_are_named(void **state)
{
    air_impulse_tables *read;
    (void)state;
    assert_int_equal(air_impulse_tables_load(shared.context, "no-such-file", &read), AIR_ERROR_IO);
    assert_null(read);
    assert_non_null(strstr(air_context_last_error(shared.context), "no-such-file"));
    assert_int_equal(air_impulse_tables_save(shared.context, shared.tables, "no/such/folder"),
                     AIR_ERROR_IO);
}

static air_status try_load(air_context *context, void *user)
{
    air_impulse_tables *read;
    (void)user;
    const air_status status = air_impulse_tables_load(context, path, &read);
    assert_int_equal(read != NULL, status == AIR_OK);
    air_impulse_tables_destroy(read);
    return status;
}

static void lack_of_memory_leaves_nothing(void **state)
{
    (void)state;
    assert_int_equal(air_impulse_tables_save(shared.context, shared.tables, path), AIR_OK);
    assert_shortage_survived(try_load, NULL, 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_keep_tables),
        cmocka_unit_test(wrong_headers_are_refused),
        cmocka_unit_test(wrong_numbers_are_refused),
        cmocka_unit_test(files_that_are_not_there_are_named),
        cmocka_unit_test(lack_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
