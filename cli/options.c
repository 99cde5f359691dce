#include "options.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "progress.h"

enum { NAME_LENGTH_MAX = 40, CHOICE_TEXT_MAX = 160, OPTION_MAX = 128 };

/* ---- likeness ---- */

/* Number of insertions, removals, replacements and swaps of neighbours between two words, each cut
 * at NAME_LENGTH_MAX. */
static size_t edit_distance(const char *a, const char *b)
{
    size_t rows[3][NAME_LENGTH_MAX + 1];
    size_t *before_last = rows[0], *last = rows[1], *current = rows[2];
    const size_t na = strnlen(a, NAME_LENGTH_MAX), nb = strnlen(b, NAME_LENGTH_MAX);
    for (size_t j = 0; j <= nb; j++) {
        before_last[j] = last[j] = j;
    }
    for (size_t i = 1; i <= na; i++) {
        current[0] = i;
        for (size_t j = 1; j <= nb; j++) {
            size_t best = last[j - 1] + (a[i - 1] != b[j - 1]);
            best = last[j] + 1 < best ? last[j] + 1 : best;
            best = current[j - 1] + 1 < best ? current[j - 1] + 1 : best;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
                before_last[j - 2] + 1 < best) {
                best = before_last[j - 2] + 1;
            }
            current[j] = best;
        }
        size_t *const free_row = before_last;
        before_last = last;
        last = current;
        current = free_row;
    }
    return last[nb];
}

/* How unlike a candidate is; SIZE_MAX if it is no sensible suggestion. */
static size_t unlikeness(const char *text, const char *candidate)
{
    const size_t length = strlen(text);
    if (length >= 2 && strncmp(text, candidate, length) == 0) {
        return 0;
    }
    const size_t distance = edit_distance(text, candidate);
    return distance <= 1 + length / 4 && distance < length ? distance : SIZE_MAX;
}

const char *cli_nearest(const char *text, const char *const *candidates)
{
    const char *nearest = NULL;
    size_t least = SIZE_MAX;
    for (; *candidates != NULL; candidates++) {
        const size_t distance = unlikeness(text, *candidates);
        if (distance < least) {
            least = distance;
            nearest = *candidates;
        }
    }
    return nearest;
}

/* ---- values ---- */

bool cli_read_real(const char *text, double *out_value)
{
    char *end = NULL;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(value)) {
        return false;
    }
    *out_value = value;
    return true;
}

/* Reads a whole number that ends at `stop`; strtoull alone would take "-1" and " 1". */
static bool read_count(const char *text, char stop, uint64_t *out_value, const char **out_end)
{
    char *end = NULL;
    if (!isdigit((unsigned char)text[0])) {
        return false;
    }
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (errno != 0 || *end != stop) {
        return false;
    }
    *out_value = value;
    *out_end = end;
    return true;
}

static bool in_range(const cli_option *option, double value)
{
    return value >= option->min && value <= option->max;
}

static const char *expected_of(const cli_option *option)
{
    return option->expected != NULL ? option->expected : option->value;
}

static bool value_failed(const cli_option *option, const char *text, const char *expected)
{
    cli_say(NULL, AIR_MESSAGE_ERROR, "--%s: expected %s, got \"%s\"", option->name, expected, text);
    return false;
}

/* "a whole number from 1 to 4096, or unlimited" */
static bool number_failed(const cli_option *option, const char *text, const char *what)
{
    char expected[CHOICE_TEXT_MAX];
    snprintf(expected, sizeof expected, "%s from %.10g to %.10g%s%s", what, option->min,
             option->max, option->word != NULL ? ", or " : "",
             option->word != NULL ? option->word : "");
    return value_failed(option, text, expected);
}

static bool set_count(const cli_option *option, const char *text, cli_count *out)
{
    const char *end;
    uint64_t value = 0;
    const bool word = option->word != NULL && strcmp(text, option->word) == 0;
    if (!word && (!read_count(text, '\0', &value, &end) || !in_range(option, (double)value))) {
        return number_failed(option, text, "a whole number");
    }
    *out = (cli_count){.set = true, .word = word, .value = value};
    return true;
}

static bool set_real(const cli_option *option, const char *text, cli_real *out)
{
    double value = 0.0;
    const bool word = option->word != NULL && strcmp(text, option->word) == 0;
    if (!word && (!cli_read_real(text, &value) || !in_range(option, value))) {
        return number_failed(option, text, "a number");
    }
    *out = (cli_real){.set = true, .word = word, .value = value};
    return true;
}

static bool set_counts(const cli_option *option, const char *text, cli_counts *out)
{
    cli_counts values = {.set = true, .value = {0}};
    const char *place = text;
    for (size_t i = 0; i < option->length; i++) {
        const char stop = i + 1 < option->length ? option->separator : '\0';
        if (!read_count(place, stop, &values.value[i], &place) ||
            !in_range(option, (double)values.value[i])) {
            return value_failed(option, text, expected_of(option));
        }
        place++;
    }
    *out = values;
    return true;
}

static bool choice_failed(const cli_option *option, const char *text)
{
    char expected[CHOICE_TEXT_MAX] = "";
    size_t used = 0;
    for (size_t i = 0; option->choices[i] != NULL && used < sizeof expected; i++) {
        const char *const before = i == 0 ? "" : option->choices[i + 1] == NULL ? " or " : ", ";
        used += (size_t)snprintf(expected + used, sizeof expected - used, "%s%s", before,
                                 option->choices[i]);
    }
    const char *const nearest = cli_nearest(text, option->choices);
    if (nearest == NULL) {
        return value_failed(option, text, expected);
    }
    cli_say(NULL, AIR_MESSAGE_ERROR, "--%s: expected %s, got \"%s\" (did you mean %s?)",
            option->name, expected, text, nearest);
    return false;
}

static bool set_choice(const cli_option *option, const char *text, cli_count *out)
{
    for (size_t i = 0; option->choices[i] != NULL; i++) {
        if (strcmp(text, option->choices[i]) == 0) {
            *out = (cli_count){.set = true, .value = i};
            return true;
        }
    }
    return choice_failed(option, text);
}

static bool set_mask(const cli_option *option, const char *text, cli_count *out)
{
    uint64_t mask = 0;
    const char *place = text;
    for (;;) {
        char name[NAME_LENGTH_MAX + 1];
        cli_count one = {.set = false};
        const size_t length = strcspn(place, ",");
        snprintf(name, sizeof name, "%.*s",
                 (int)(length < NAME_LENGTH_MAX ? length : NAME_LENGTH_MAX), place);
        if (!set_choice(option, name, &one)) {
            return false;
        }
        mask |= (uint64_t)1 << one.value;
        if (place[length] == '\0') {
            break;
        }
        place += length + 1;
    }
    *out = (cli_count){.set = true, .value = mask};
    return true;
}

static bool add_to_list(const cli_option *option, const char *text, cli_list *list)
{
    if (list->count == CLI_LIST_MAX) {
        cli_say(NULL, AIR_MESSAGE_ERROR, "--%s: given more than %d times", option->name,
                (int)CLI_LIST_MAX);
        return false;
    }
    list->items[list->count++] = text;
    return true;
}

/* text is NULL for flags and where an optional value is left out. */
static bool set_value(const cli_option_group *group, const cli_option *option, const char *text)
{
    void *const field = (char *)group->target + option->offset;
    if (text != NULL && text[0] == '\0') {
        return value_failed(option, text, expected_of(option));
    }
    switch (option->kind) {
    case CLI_FLAG:
        *(bool *)field = true;
        return true;
    case CLI_TEXT:
        *(const char **)field = text;
        return true;
    case CLI_LIST:
        return add_to_list(option, text, field);
    case CLI_COUNT:
        if (text == NULL) {
            *(cli_count *)field = (cli_count){.set = true, .word = true};
            return true;
        }
        return set_count(option, text, field);
    case CLI_REAL:
        return set_real(option, text, field);
    case CLI_CHOICE:
        return set_choice(option, text, field);
    case CLI_SET:
        return set_mask(option, text, field);
    case CLI_COUNTS:
        return set_counts(option, text, field);
    }
    return false;
}

/* ---- arguments ---- */

typedef struct cli_parser {
    const cli_usage *usage;
    const cli_option_group *groups;
    size_t group_count;
    int argc;
    char **argv;
    int next; /* index of the argument to read next */
} cli_parser;

/* The option with this long name (its first `length` characters) or this letter; NULL if there is
 * none. */
static const cli_option *find_option(const cli_parser *parser, const char *name, size_t length,
                                     char letter, const cli_option_group **out_group)
{
    for (size_t g = 0; g < parser->group_count; g++) {
        const cli_option_group *const group = &parser->groups[g];
        for (size_t i = 0; i < group->count; i++) {
            const cli_option *const option = &group->options[i];
            const bool found = name == NULL ? option->letter == letter
                                            : strncmp(option->name, name, length) == 0 &&
                                                  option->name[length] == '\0';
            if (found) {
                *out_group = group;
                return option;
            }
        }
    }
    return NULL;
}

static void unknown_option(const cli_parser *parser, const char *name, size_t length)
{
    char wanted[NAME_LENGTH_MAX + 1];
    const char *names[OPTION_MAX + 2] = {"help"};
    size_t count = 1;
    snprintf(wanted, sizeof wanted, "%.*s",
             (int)(length < NAME_LENGTH_MAX ? length : NAME_LENGTH_MAX), name);
    for (size_t g = 0; g < parser->group_count; g++) {
        for (size_t i = 0; i < parser->groups[g].count && count <= OPTION_MAX; i++) {
            names[count++] = parser->groups[g].options[i].name;
        }
    }
    const char *const nearest = cli_nearest(wanted, names);
    if (nearest != NULL) {
        cli_say(NULL, AIR_MESSAGE_ERROR, "unknown option --%s of %s (did you mean --%s?)", wanted,
                parser->usage->command, nearest);
    } else {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "unknown option --%s of %s (airlight %s --help lists them)", wanted,
                parser->usage->command, parser->usage->command);
    }
}

/* Takes the value of an option from the following argument. */
static bool take_value(cli_parser *parser, const cli_option *option, const char **out_text)
{
    const char *const text = parser->next < parser->argc ? parser->argv[parser->next] : NULL;
    double number;
    if (option->optional && (text == NULL || !cli_read_real(text, &number))) {
        *out_text = NULL;
        return true;
    }
    /* A following "--..." is taken for a forgotten value rather than for a file of that name. */
    if (text == NULL || strncmp(text, "--", 2) == 0) {
        cli_say(NULL, AIR_MESSAGE_ERROR, "--%s: a value is missing, expected %s", option->name,
                expected_of(option));
        return false;
    }
    parser->next++;
    *out_text = text;
    return true;
}

static bool parse_long(cli_parser *parser, const char *name)
{
    const size_t length = strcspn(name, "=");
    const char *text = NULL;
    const cli_option_group *group;
    const cli_option *const option = find_option(parser, name, length, 0, &group);
    if (option == NULL) {
        unknown_option(parser, name, length);
        return false;
    }
    if (name[length] == '=') {
        if (option->kind == CLI_FLAG) {
            cli_say(NULL, AIR_MESSAGE_ERROR, "--%s: takes no value, got \"%s\"", option->name,
                    name + length + 1);
            return false;
        }
        text = name + length + 1;
    } else if (option->kind != CLI_FLAG && !take_value(parser, option, &text)) {
        return false;
    }
    return set_value(group, option, text);
}

static bool parse_short(cli_parser *parser, const char *letters)
{
    for (; *letters != '\0'; letters++) {
        const cli_option_group *group;
        const cli_option *const option = find_option(parser, NULL, 0, *letters, &group);
        if (option == NULL) {
            cli_say(NULL, AIR_MESSAGE_ERROR,
                    "unknown option -%c of %s (airlight %s --help lists them)", *letters,
                    parser->usage->command, parser->usage->command);
            return false;
        }
        if (option->kind == CLI_FLAG) {
            if (!set_value(group, option, NULL)) {
                return false;
            }
            continue;
        }
        const char *text = letters[1] != '\0' ? letters + 1 : NULL;
        return (text != NULL || take_value(parser, option, &text)) &&
               set_value(group, option, text);
    }
    return true;
}

/* ---- help ---- */

/* Prints `text` from column `column` on, broken at spaces before column 100. */
static void print_wrapped(const char *text, int column)
{
    int at = column;
    while (*text != '\0') {
        const size_t length = strcspn(text, " ");
        if (at > column && at + 1 + (int)length > 100) {
            printf("\n%*s", column, "");
            at = column;
        } else if (at > column) {
            putchar(' ');
            at++;
        }
        printf("%.*s", (int)length, text);
        at += (int)length;
        text += length;
        text += strspn(text, " ");
    }
    putchar('\n');
}

static void print_option(const cli_option *option)
{
    enum { HELP_COLUMN = 34 };
    char head[96];
    char letter[8] = "    ";
    if (option->letter != 0) {
        snprintf(letter, sizeof letter, "-%c, ", option->letter);
    }
    if (option->kind == CLI_FLAG) {
        snprintf(head, sizeof head, "%s--%s", letter, option->name);
    } else if (option->optional) {
        snprintf(head, sizeof head, "%s--%s[=%s]", letter, option->name, option->value);
    } else {
        snprintf(head, sizeof head, "%s--%s %s", letter, option->name, option->value);
    }
    printf("  %-*s", HELP_COLUMN - 2, head);
    if (strlen(head) + 2 >= HELP_COLUMN) {
        printf("\n%*s", HELP_COLUMN, "");
    }
    print_wrapped(option->help, HELP_COLUMN);
}

static void print_help(const cli_usage *usage, const cli_option_group *groups, size_t group_count)
{
    printf("Usage: airlight %s [OPTIONS] %s\n\n", usage->command, usage->arguments);
    print_wrapped(usage->summary, 0);
    for (size_t g = 0; g < group_count; g++) {
        printf("\n%s:\n", groups[g].title);
        for (size_t i = 0; i < groups[g].count; i++) {
            print_option(&groups[g].options[i]);
        }
    }
    printf("\nExamples:\n%s", usage->examples);
}

static bool argument_count_fits(const cli_usage *usage, size_t count)
{
    if (count < usage->argument_min) {
        cli_say(NULL, AIR_MESSAGE_ERROR,
                "%s: expected %s, got %zu argument%s (airlight %s --help explains)", usage->command,
                usage->arguments, count, count == 1 ? "" : "s", usage->command);
        return false;
    }
    return true;
}

cli_parsed cli_parse(const cli_usage *usage, const cli_option_group *groups, size_t group_count,
                     int *argc, char **argv)
{
    cli_parser parser = {usage, groups, group_count, *argc, argv, 0};
    size_t kept = 0;
    bool options = true;
    while (parser.next < parser.argc) {
        char *const argument = argv[parser.next++];
        if (options && strcmp(argument, "--") == 0) {
            options = false;
        } else if (options && (strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0)) {
            print_help(usage, groups, group_count);
            return CLI_PARSED_HELP;
        } else if (options && strncmp(argument, "--", 2) == 0) {
            if (!parse_long(&parser, argument + 2)) {
                return CLI_PARSE_FAILED;
            }
        } else if (options && argument[0] == '-' && argument[1] != '\0') {
            if (!parse_short(&parser, argument + 1)) {
                return CLI_PARSE_FAILED;
            }
        } else if (kept == usage->argument_max) {
            cli_say(NULL, AIR_MESSAGE_ERROR, "%s: unexpected argument \"%s\" (expected only %s)",
                    usage->command, argument, usage->arguments);
            return CLI_PARSE_FAILED;
        } else {
            argv[kept++] = argument;
        }
    }
    *argc = (int)kept;
    return argument_count_fits(usage, kept) ? CLI_PARSED : CLI_PARSE_FAILED;
}
