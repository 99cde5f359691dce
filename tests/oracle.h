/* oracle.h: what the programs share that hold a kernel against tables of reference values: exit
 * codes, files that are absent, one file after the other. */
#ifndef AIR_TESTS_ORACLE_H
#define AIR_TESTS_ORACLE_H

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { EXIT_WRONG = 1, EXIT_MALFORMED = 2, EXIT_SKIPPED = 77 };

/* Says, by errno, why the file could not be opened; the exit code for that. */
static inline int oracle_not_open(const char *path, bool skip_absent)
{
    const bool skip = skip_absent && errno == ENOENT;
    fprintf(stderr, "%s: %s%s\n", path, strerror(errno), skip ? ", skipped" : "");
    return skip ? EXIT_SKIPPED : EXIT_MALFORMED;
}

/* NAME [--skip-absent] PATH...: the exit code of the first file that is not as it should be,
 * EXIT_SKIPPED only where no other is wrong. */
static inline int oracle_main(const char *name, int argc, char **argv,
                              int (*check_file)(const char *path, bool skip_absent))
{
    const bool skip_absent = argc > 1 && strcmp(argv[1], "--skip-absent") == 0;
    const int first = skip_absent ? 2 : 1;
    if (first >= argc) {
        fprintf(stderr, "usage: %s [--skip-absent] PATH...\n", name);
        return EXIT_MALFORMED;
    }
    int code = 0;
    for (int i = first; i < argc; i++) {
        const int one = check_file(argv[i], skip_absent);
        code = code == 0 || (code == EXIT_SKIPPED && one != 0) ? one : code;
    }
    return code;
}

#endif
