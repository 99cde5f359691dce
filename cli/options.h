/* options.h: one table-driven option parser for all subcommands.
 *
 * A subcommand describes its options as tables of cli_option, each of which names a field of a
 * struct by its offset. Forms understood: --name VALUE, --name=VALUE, -x VALUE, -xVALUE, several
 * short flags in one (-qv), and -- which ends the options. An option given twice counts the last
 * time, lists collect. */
#ifndef AIR_CLI_OPTIONS_H
#define AIR_CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum cli_option_kind {
    CLI_FLAG,   /* bool */
    CLI_TEXT,   /* const char *: borrowed from argv */
    CLI_LIST,   /* cli_list: repeatable */
    CLI_COUNT,  /* cli_count: a whole number in [min, max] */
    CLI_REAL,   /* cli_real: a finite number in [min, max] */
    CLI_CHOICE, /* cli_count: the index in choices */
    CLI_SET,    /* cli_count: the mask of a comma-separated selection of choices */
    CLI_COUNTS  /* cli_counts: `length` whole numbers in [min, max] with `separator` between */
} cli_option_kind;

enum { CLI_LIST_MAX = 64, CLI_COUNTS_MAX = 4 };

/* `set` is false until the option is met; `word` is true if it was the option's word instead of a
 * number. */
typedef struct cli_count {
    bool set, word;
    uint64_t value;
} cli_count;

typedef struct cli_real {
    bool set, word;
    double value;
} cli_real;

typedef struct cli_counts {
    bool set;
    uint64_t value[CLI_COUNTS_MAX];
} cli_counts;

typedef struct cli_list {
    size_t count;
    const char *items[CLI_LIST_MAX];
} cli_list;

typedef struct cli_option {
    const char *name; /* without the dashes */
    char letter;      /* short form, or 0 */
    cli_option_kind kind;
    const char *value;    /* what the help calls the value */
    const char *expected; /* the same said at greater length in errors; NULL: value */
    const char *help;
    size_t offset; /* of the field in the group's target */
    double min, max;
    const char *const *choices; /* ends with NULL */
    const char *word;           /* also accepted in place of a number, or NULL */
    size_t length;
    char separator;
    bool optional; /* the value may be left out; a separate argument is taken only if it is a number
                    */
} cli_option;

typedef struct cli_option_group {
    const char *title;
    const cli_option *options;
    size_t count;
    void *target;
} cli_option_group;

typedef struct cli_usage {
    const char *command;   /* "render" */
    const char *arguments; /* "SCENE" */
    const char *summary;
    const char *examples; /* lines, each ending in a newline */
    size_t argument_min, argument_max;
} cli_usage;

typedef enum cli_parsed { CLI_PARSED, CLI_PARSED_HELP, CLI_PARSE_FAILED } cli_parsed;

/* Parses argv[0..*argc) into the groups' targets and moves what is not an option to the front of
 * argv, *argc of them. On failure one message was printed; for -h and --help the help was printed
 * to stdout. */
cli_parsed cli_parse(const cli_usage *usage, const cli_option_group *groups, size_t group_count,
                     int *argc, char **argv);

/* The candidate (of a NULL-terminated list) that is most like `text`, NULL if none is near. */
const char *cli_nearest(const char *text, const char *const *candidates);

/* True if `text` is wholly a finite number. */
bool cli_read_real(const char *text, double *out_value);

#endif
