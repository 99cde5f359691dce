/* cli_result.h: what runs of the command give: nothing, JSON, files, and attributes of these. */
#ifndef AIR_TESTS_CLI_RESULT_H
#define AIR_TESTS_CLI_RESULT_H

#include <jansson.h>

#include "cli_run.h"

static inline void cli_run_well(const cli_directory *directory, const char *const *arguments)
{
    cli_result result = cli_run(directory, arguments);
    if (result.exit_code != 0) {
        print_error("airlight %s: exit code %d: %s", arguments[0], result.exit_code, result.err);
    }
    assert_int_equal(result.exit_code, 0);
    cli_free(&result);
}

/* The command's stdout as JSON. */
static inline json_t *cli_run_json(const cli_directory *directory, const char *const *arguments)
{
    json_error_t error;
    cli_result result = cli_run(directory, arguments);
    json_t *const value = json_loads(result.out, 0, &error);
    if (result.exit_code != 0 || value == NULL) {
        print_error("airlight %s: exit code %d: %s", arguments[0], result.exit_code, result.err);
    }
    assert_int_equal(result.exit_code, 0);
    assert_non_null(value);
    cli_free(&result);
    return value;
}

/* An attribute of a picture, to be freed; NULL if it has none of that name. */
static inline char *cli_attribute(const cli_directory *directory, const char *path,
                                  const char *name)
{
    const char *const arguments[] = {"info", path, "--json", NULL};
    json_t *const description = cli_run_json(directory, arguments);
    const char *const value =
        json_string_value(json_object_get(json_object_get(description, "attributes"), name));
    char *const copy = value != NULL ? strdup(value) : NULL;
    json_decref(description);
    return copy;
}

static inline bool cli_same_bytes(const char *a, const char *b)
{
    struct stat status_a, status_b;
    assert_int_equal(stat(a, &status_a), 0);
    assert_int_equal(stat(b, &status_b), 0);
    if (status_a.st_size != status_b.st_size) {
        return false;
    }
    char *const text_a = cli_read_text(a), *const text_b = cli_read_text(b);
    const bool same = memcmp(text_a, text_b, (size_t)status_a.st_size) == 0;
    free(text_a);
    free(text_b);
    return same;
}

/* Interrupts a run as soon as a file is there, half a minute at most, and another (NULL: none) is
 * not yet; it ends with 130 and no error. */
static inline void cli_interrupt_at(const cli_directory *directory, pid_t child, const char *file,
                                    const char *later)
{
    const struct timespec pause = {.tv_nsec = 20000000};
    for (int i = 0; i < 1500 && !cli_exists(file); i++) {
        nanosleep(&pause, NULL);
    }
    assert_true(cli_exists(file));
    assert_false(later != NULL && cli_exists(later));
    kill(child, SIGINT);
    cli_result result = cli_finish(directory, child);
    assert_int_equal(result.exit_code, 130);
    assert_int_equal(cli_count_lines(result.err, "airlight: error: "), 0);
    cli_free(&result);
}

#endif
