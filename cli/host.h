/* host.h: the options every subcommand has, and the library context that lives under them. */
#ifndef AIR_CLI_HOST_H
#define AIR_CLI_HOST_H

#include <airlight/context.h>

#include "commands.h"
#include "options.h"
#include "progress.h"

typedef struct cli_host_options {
    cli_count threads, cpu, progress;
    bool quiet, verbose;
} cli_host_options;

typedef struct cli_host {
    air_context *context;
    cli_progress progress;
    const char
        *about; /* put before the library's messages, where those cannot name the file; or NULL */
    bool finishing; /* after an interrupt, what was done so far is being written: nothing stops any
                       more */
} cli_host;

cli_option_group cli_host_group(cli_host_options *options);

/* Starts the library; its messages and progress go to stderr, and a pending interrupt stops it.
 * What was said when this fails has been printed. The host must stay where it is until it is
 * closed. */
cli_exit cli_host_open(cli_host *host, const cli_host_options *options);
void cli_host_close(cli_host *host); /* a host that was zeroed or failed to open is legal */

/* The exit code for what a library call returned. `what` ("reading a.exr") is printed with the
 * status where the library failed without a message of its own. */
cli_exit cli_host_exit(cli_host *host, air_status status, const char *what);

#endif
