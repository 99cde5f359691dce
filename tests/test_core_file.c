/* Whole files in, whole files out. */
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cmocka_test.h"
#include "core/host.h"
#include "failing_allocator.h"

typedef struct fixture {
    air_context *context;
    char folder[64];
    char path[128];
} fixture;

static int set_up(void **state)
{
    fixture *self = calloc(1, sizeof *self);
    (void)snprintf(self->folder, sizeof self->folder, "/tmp/airlight-file-XXXXXX");
    if (mkdtemp(self->folder) == NULL || air_context_create(NULL, &self->context) != AIR_OK) {
        return -1;
    }
    (void)snprintf(self->path, sizeof self->path, "%s/data", self->folder);
    *state = self;
    return 0;
}

static int tear_down(void **state)
{
    fixture *self = *state;
    (void)unlink(self->path);
    const int left = rmdir(self->folder); /* fails if anything else was left */
    air_context_destroy(self->context);
    free(self);
    return left;
}

static size_t count_entries(const char *folder)
{
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    size_t count = 0;
    for (struct dirent *entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        count += entry->d_name[0] != '.';
    }
    (void)closedir(directory);
    return count;
}

static void check_content(fixture *self, const char *expected, size_t size)
{
    void *data = NULL;
    size_t read_size = 0;
    assert_int_equal(air_file_read(self->context, self->path, &data, &read_size), AIR_OK);
    assert_int_equal(read_size, size);
    assert_memory_equal(data, expected, size);
    assert_int_equal(((char *)data)[size], '\0');
    air_free(self->context, data);
}

static void what_is_written_is_read_back_with_a_nul_behind(void **state)
{
    fixture *self = *state;
    static const size_t sizes[] = {0, 1, 4095, 4096, 65536, 1000003};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        char *bytes = malloc(sizes[i] + 1);
        assert_non_null(bytes);
        for (size_t k = 0; k < sizes[i]; ++k) {
            bytes[k] = (char)(k * 31 + i);
        }
        assert_int_equal(air_file_write(self->context, self->path, bytes, sizes[i]), AIR_OK);
        check_content(self, bytes, sizes[i]);
        free(bytes);
    }
    assert_int_equal(count_entries(self->folder), 1);
}

static void files_without_a_size_are_read_to_their_end(void **state)
{
    fixture *self = *state;
    void *data = NULL;
    size_t size = 0;
    /* The kernel says 0 bytes for this file. */
    assert_int_equal(air_file_read(self->context, "/proc/self/status", &data, &size), AIR_OK);
    assert_true(size > 100);
    assert_int_equal(strlen(data), size);
    air_free(self->context, data);
}

static void reading_what_is_not_there_names_the_file_and_the_reason(void **state)
{
    fixture *self = *state;
    void *data = NULL;
    size_t size = 77;
    assert_int_equal(air_file_read(self->context, self->path, &data, &size), AIR_ERROR_IO);
    assert_non_null(strstr(air_context_last_error(self->context), self->path));
    assert_non_null(strstr(air_context_last_error(self->context), strerror(ENOENT)));
    assert_int_equal(air_file_read(self->context, self->folder, &data, &size), AIR_ERROR_IO);
    assert_non_null(strstr(air_context_last_error(self->context), strerror(EISDIR)));
    assert_null(data);
    assert_int_equal(size, 77);
}

static void a_failed_write_keeps_the_old_file_and_leaves_nothing_beside(void **state)
{
    fixture *self = *state;
    assert_int_equal(air_file_write(self->context, self->path, "old", 3), AIR_OK);
    /* A limit on file size makes write() itself fail part of the way. */
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const struct rlimit small = {1000, before.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    char *bytes = calloc(1, 100000);
    const air_status status = air_file_write(self->context, self->path, bytes, 100000);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    (void)signal(SIGXFSZ, handler);
    free(bytes);
    assert_int_equal(status, AIR_ERROR_IO);
    assert_non_null(strstr(air_context_last_error(self->context), strerror(EFBIG)));
    check_content(self, "old", 3);
    assert_int_equal(count_entries(self->folder), 1);
}

static void writing_into_a_missing_folder_or_onto_a_folder_fails(void **state)
{
    fixture *self = *state;
    char path[160];
    (void)snprintf(path, sizeof path, "%s/none/data", self->folder);
    assert_int_equal(air_file_write(self->context, path, "x", 1), AIR_ERROR_IO);
    assert_non_null(strstr(air_context_last_error(self->context), path));
    assert_int_equal(air_file_write(self->context, self->folder, "x", 1), AIR_ERROR_IO);
    assert_int_equal(count_entries(self->folder), 0);
}

static void devices_are_written_to_and_not_replaced(void **state)
{
    fixture *self = *state;
    struct stat info;
    assert_int_equal(air_file_write(self->context, "/dev/null", "x", 1), AIR_OK);
    assert_int_equal(stat("/dev/null", &info), 0);
    assert_true(S_ISCHR(info.st_mode));
}

static air_status read_from_memory(void *user, air_context *context, const char *path,
                                   void **out_data, size_t *out_size)
{
    (void)context;
    if (strcmp(path, "known") != 0) {
        return AIR_ERROR_IO;
    }
    *out_data = failing_reallocate(user, NULL, 5);
    memcpy(*out_data, "bytes", 5);
    *out_size = 5;
    return AIR_OK;
}

static void a_hosts_reader_gets_its_nul_and_its_message(void **state)
{
    (void)state;
    failing_allocator allocator;
    air_context_params params = failing_params(&allocator, 100);
    params.read_file = read_from_memory;
    params.read_user = &allocator;
    air_context *context = NULL;
    void *data = NULL;
    size_t size = 0;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_int_equal(air_file_read(context, "known", &data, &size), AIR_OK);
    assert_int_equal(size, 5);
    assert_string_equal(data, "bytes");
    air_free(context, data);
    data = NULL;
    assert_int_equal(air_file_read(context, "unknown", &data, &size), AIR_ERROR_IO);
    assert_non_null(strstr(air_context_last_error(context), "unknown"));
    assert_null(data);
    atomic_store(&allocator.remaining, 1); /* enough for the reader, not for the NUL */
    assert_int_equal(air_file_read(context, "known", &data, &size), AIR_ERROR_MEMORY);
    assert_null(data);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
}

static void reading_without_memory_fails_cleanly(void **state)
{
    fixture *self = *state;
    assert_int_equal(air_file_write(self->context, self->path, "old", 3), AIR_OK);
    failing_allocator allocator;
    const air_context_params params = failing_params(&allocator, 1);
    air_context *context = NULL;
    void *data = NULL;
    size_t size = 0;
    assert_int_equal(air_context_create(&params, &context), AIR_OK);
    assert_int_equal(air_file_read(context, self->path, &data, &size), AIR_ERROR_MEMORY);
    assert_int_equal(air_file_write(context, self->path, "new", 3), AIR_ERROR_MEMORY);
    air_context_destroy(context);
    assert_int_equal(atomic_load(&allocator.live), 0);
    check_content(self, "old", 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_is_written_is_read_back_with_a_nul_behind, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(files_without_a_size_are_read_to_their_end, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(reading_what_is_not_there_names_the_file_and_the_reason,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_failed_write_keeps_the_old_file_and_leaves_nothing_beside,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(writing_into_a_missing_folder_or_onto_a_folder_fails,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(devices_are_written_to_and_not_replaced, set_up, tear_down),
        cmocka_unit_test(a_hosts_reader_gets_its_nul_and_its_message),
        cmocka_unit_test_setup_teardown(reading_without_memory_fails_cleanly, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
