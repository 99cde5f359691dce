/* main.c: the `airlight` command: finds the subcommand and runs it. */
#include <airlight/version.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "options.h"
#include "progress.h"

static const struct {
    const char *name;
    cli_exit (*run)(int argc, char **argv);
    const char *summary;
} commands[] = {
    {"render", cli_render, "render a scene into a picture"},
    {"bake", cli_bake, "bake light into lightmaps, vertices and probes"},
    {"info", cli_info, "tell what was understood of a scene, or what an image holds"},
    {"diff", cli_diff, "compare two images: metrics, Z-test, false-colour picture"},
    {"merge", cli_merge, "add films of the same picture with different samples"},
    {"convert", cli_convert, "convert image and grid formats"},
    {"denoise", cli_denoise, "smooth a picture by its guides"},
    {"table", cli_table, "fit and inspect the tables of method arealight"},
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static void print_help(FILE *file)
{
    fprintf(file, "airlight renders light in fog, smoke, haze and dust.\n\n"
                  "Usage: airlight COMMAND [OPTIONS] FILES\n\nCommands:\n");
    for (size_t i = 0; i < COMMAND_COUNT; i++) {
        fprintf(file, "  %-10s%s\n", commands[i].name, commands[i].summary);
    }
    fprintf(file, "\n  airlight COMMAND --help   explains one of them\n"
                  "  airlight --version        prints the version\n\n"
                  "Examples:\n"
                  "  airlight render room.glb -o room.exr -o room.png\n"
                  "  airlight render room.glb --medium visibility=50m --quality draft\n"
                  "  airlight info room.glb\n"
                  "  airlight diff fast.exr truth.exr --false-colour difference.png\n\n"
                  "Data goes to stdout, progress and messages to stderr. Exit codes: 0 done, 1 "
                  "failed, 2 wrong usage,\n"
                  "130 interrupted.\n");
}

static cli_exit unknown_command(const char *name)
{
    char list[128] = "";
    size_t used = 0;
    const char *names[COMMAND_COUNT + 1] = {NULL};
    for (size_t i = 0; i < COMMAND_COUNT && used < sizeof list; i++) {
        names[i] = commands[i].name;
        used +=
            (size_t)snprintf(list + used, sizeof list - used, "%s%s", i == 0 ? "" : ", ", names[i]);
    }
    const char *const nearest = cli_nearest(name, names);
    cli_say(NULL, AIR_MESSAGE_ERROR, "unknown command \"%s\"%s%s%s; expected one of %s", name,
            nearest != NULL ? " (did you mean " : "", nearest != NULL ? nearest : "",
            nearest != NULL ? "?)" : "", list);
    return CLI_USAGE;
}

static cli_exit run_command(int argc, char **argv)
{
    for (size_t i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(argv[0], commands[i].name) == 0) {
            return commands[i].run(argc - 1, argv + 1);
        }
    }
    return unknown_command(argv[0]);
}

/* Data that did not reach stdout (a full disk, a closed pipe) is a failure. */
static cli_exit finish_output(cli_exit result)
{
    if (fflush(stdout) != 0 || ferror(stdout)) {
        cli_say(NULL, AIR_MESSAGE_ERROR, "cannot write to standard output");
        return result == CLI_OK ? CLI_FAILED : result;
    }
    return result;
}

int main(int argc, char **argv)
{
    char help[] = "--help";
    if (argc < 2) {
        print_help(stderr);
        return CLI_USAGE;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("airlight %s\n", air_version());
        return (int)finish_output(CLI_OK);
    }
    const bool wants_help = strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 ||
                            strcmp(argv[1], "help") == 0;
    if (wants_help && argc > 2) {
        char *of_command[] = {argv[2], help, NULL};
        return (int)finish_output(run_command(2, of_command));
    }
    if (wants_help) {
        print_help(stdout);
        return (int)finish_output(CLI_OK);
    }
    return (int)finish_output(run_command(argc - 1, argv + 1));
}
