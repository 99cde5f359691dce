/* oracle_run.h: what a program that judges tables of reference values says, and its exit code. */
#ifndef AIR_TESTS_ORACLE_RUN_H
#define AIR_TESTS_ORACLE_RUN_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cmocka_test.h"

enum { ORACLE_SAID = 1 << 14 };

/* Runs a command of the shell; its exit code, -1 if it had none, and the beginning of what it said.
 */
static inline int oracle_command(const char *command, char said[ORACLE_SAID])
{
    FILE *const output = popen(command, "r");
    assert_non_null(output);
    said[fread(said, 1, ORACLE_SAID - 1, output)] = '\0';
    while (fgetc(output) != EOF) { /* a program whose reader goes is killed */
    }
    const int status = pclose(output);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* Runs the program on a file with this table. */
static inline int oracle_run(const char *program, const char *options, const char *table,
                             char said[ORACLE_SAID])
{
    char path[] = "/tmp/airlight-oracle-XXXXXX", command[512];
    const int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, table, strlen(table)), (ssize_t)strlen(table));
    assert_int_equal(close(file), 0);
    snprintf(command, sizeof command, "%s %s %s 2>&1", program, options, path);
    const int code = oracle_command(command, said);
    assert_int_equal(unlink(path), 0);
    return code;
}

#endif
