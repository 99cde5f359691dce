/* commands.h: the subcommands of `airlight` and the exit codes they share. */
#ifndef AIR_CLI_COMMANDS_H
#define AIR_CLI_COMMANDS_H

typedef enum cli_exit { CLI_OK = 0, CLI_FAILED = 1, CLI_USAGE = 2, CLI_INTERRUPTED = 130 } cli_exit;

/* Each takes the arguments behind its own name, reorders them at will, and returns the process's
 * exit code. */
cli_exit cli_render(int argc, char **argv);
cli_exit cli_bake(int argc, char **argv);
cli_exit cli_info(int argc, char **argv);
cli_exit cli_diff(int argc, char **argv);
cli_exit cli_merge(int argc, char **argv);
cli_exit cli_convert(int argc, char **argv);
cli_exit cli_denoise(int argc, char **argv);
cli_exit cli_table(int argc, char **argv);

#endif
