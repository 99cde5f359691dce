/* cli_run.h: runs the built command in a directory of its own and keeps what it said; scenes for it
 * to render. */
#ifndef AIR_TESTS_CLI_RUN_H
#define AIR_TESTS_CLI_RUN_H

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "cmocka_test.h"

extern char **environ;

enum { CLI_ARGUMENT_MAX = 32, CLI_ENTRY_MAX = 64 };

/* The captured output lies outside of the directory the command runs in. */
typedef struct cli_directory {
    char work[64], captured[64];
} cli_directory;

typedef struct cli_result {
    int exit_code; /* -1: ended by a signal */
    char *out, *err;
} cli_result;

static inline char *cli_read_text(const char *path)
{
    FILE *const file = fopen(path, "rb");
    assert_non_null(file);
    size_t size = 0, capacity = 1 << 16;
    char *text = malloc(capacity);
    assert_non_null(text);
    for (size_t got; (got = fread(text + size, 1, capacity - size - 1, file)) > 0;) {
        size += got;
        capacity *= 2;
        text = realloc(text, capacity);
        assert_non_null(text);
    }
    fclose(file);
    text[size] = '\0';
    return text;
}

static inline void cli_write_bytes(const char *path, const void *data, size_t size)
{
    FILE *const file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void cli_write_text(const char *path, const char *text)
{
    cli_write_bytes(path, text, strlen(text));
}

static inline bool cli_exists(const char *path) { return access(path, F_OK) == 0; }

static inline size_t cli_count_entries(void)
{
    DIR *const directory = opendir(".");
    size_t count = 0;
    assert_non_null(directory);
    while (readdir(directory) != NULL) {
        count++;
    }
    closedir(directory);
    return count;
}

static inline void cli_remove_directory(const char *path)
{
    char *const arguments[] = {"rm", "-rf", (char *)path, NULL};
    pid_t child;
    assert_int_equal(posix_spawnp(&child, "rm", NULL, NULL, arguments, environ), 0);
    waitpid(child, NULL, 0);
}

/* Starts the command with `arguments` (NULL-terminated, without the program). */
static inline pid_t cli_start(const cli_directory *directory, const char *const *arguments)
{
    char *argv[CLI_ARGUMENT_MAX + 2] = {AIR_COMMAND};
    char out[80], err[80];
    pid_t child;
    posix_spawn_file_actions_t actions;
    for (size_t i = 0; arguments[i] != NULL; i++) {
        assert_true(i < CLI_ARGUMENT_MAX);
        argv[i + 1] = (char *)arguments[i];
    }
    snprintf(out, sizeof out, "%s/out", directory->captured);
    snprintf(err, sizeof err, "%s/err", directory->captured);
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out, O_WRONLY | O_CREAT | O_TRUNC,
                                     0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err, O_WRONLY | O_CREAT | O_TRUNC,
                                     0600);
    assert_int_equal(posix_spawn(&child, AIR_COMMAND, &actions, NULL, argv, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    return child;
}

static inline cli_result cli_finish(const cli_directory *directory, pid_t child)
{
    char path[80];
    int status = 0;
    cli_result result;
    assert_int_equal(waitpid(child, &status, 0), child);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    snprintf(path, sizeof path, "%s/out", directory->captured);
    result.out = cli_read_text(path);
    snprintf(path, sizeof path, "%s/err", directory->captured);
    result.err = cli_read_text(path);
    return result;
}

static inline cli_result cli_run(const cli_directory *directory, const char *const *arguments)
{
    return cli_finish(directory, cli_start(directory, arguments));
}

static inline void cli_free(cli_result *result)
{
    free(result->out);
    free(result->err);
}

/* How many lines of `text` begin with `start`. */
static inline size_t cli_count_lines(const char *text, const char *start)
{
    size_t count = 0;
    while (text != NULL && *text != '\0') {
        count += strncmp(text, start, strlen(start)) == 0;
        text = strchr(text, '\n');
        text = text != NULL ? text + 1 : NULL;
    }
    return count;
}

/* ---- scenes ---- */

/* Writes NAME, which refers to quad.bin, also written: a floor of 4 m x 4 m, seen from above at a
 * slant, and a lamp 1.5 m above it unless `lights` is "". */
static inline void cli_write_scene(const char *name, const char *buffer, const char *lights)
{
    static const float positions[12] = {-2, 0, 2, 2, 0, 2, 2, 0, -2, -2, 0, -2};
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    static const char *const format =
        "{\"asset\":{\"version\":\"2.0\"},%s"
        "\"scene\":0,\"scenes\":[{\"nodes\":[0,1%s]}],"
        "\"nodes\":[{\"mesh\":0},{\"name\":\"Slant\",\"camera\":0,\"translation\":[0,3,3],"
        "\"rotation\":[-0.3826834,0,0,0.9238795]}%s],"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"aspectRatio\":2,"
        "\"znear\":0.1}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
        "\"buffers\":[{\"uri\":\"%s\",\"byteLength\":60}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
        "\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
        "\"min\":[-2,0,-2],\"max\":[2,0,2]},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}]}";
    char text[2048], bytes[60];
    const bool lamp = lights[0] != '\0';
    memcpy(bytes, positions, 48);
    memcpy(bytes + 48, indices, 12);
    cli_write_bytes("quad.bin", bytes, sizeof bytes);
    snprintf(
        text, sizeof text, format, lights, lamp ? ",2" : "",
        lamp ? ",{\"translation\":[0,1.5,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}"
             : "",
        buffer);
    cli_write_text(name, text);
}

#define CLI_LAMP                                                                                   \
    "\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":"        \
    "{\"lights\":[{\"type\":\"point\",\"intensity\":683}]}},"

/* A fresh directory, which becomes the current one, with the good scene "lit.gltf" in it. */
static inline void cli_enter(cli_directory *directory)
{
    strcpy(directory->work, "/tmp/airlight-cli-XXXXXX");
    strcpy(directory->captured, "/tmp/airlight-cli-XXXXXX");
    assert_non_null(mkdtemp(directory->work));
    assert_non_null(mkdtemp(directory->captured));
    assert_int_equal(chdir(directory->work), 0);
    cli_write_scene("lit.gltf", "quad.bin", CLI_LAMP);
}

static inline void cli_leave(const cli_directory *directory)
{
    assert_int_equal(chdir("/"), 0);
    cli_remove_directory(directory->work);
    cli_remove_directory(directory->captured);
}

#endif
