#include "host.h"

#include <stddef.h>

#include "interrupt.h"

static const char *const cpu_names[] = {"auto", "c", "sse4.2", "avx2", "avx512", NULL};
static const char *const progress_names[] = {"auto", "bar", "plain", "json", "none", NULL};

static const cli_option host_options[] = {
    {.name = "threads",
     .letter = 't',
     .kind = CLI_COUNT,
     .value = "N",
     .min = 1,
     .max = 4096,
     .offset = offsetof(cli_host_options, threads),
     .help = "Threads to use; default: as many as there are processors. The result does not depend "
             "on it."},
    {.name = "cpu",
     .kind = CLI_CHOICE,
     .value = "ISA",
     .choices = cpu_names,
     .offset = offsetof(cli_host_options, cpu),
     .help = "Instruction set: auto, c, sse4.2, avx2 or avx512; default auto, the best the machine "
             "has."},
    {.name = "progress",
     .kind = CLI_CHOICE,
     .value = "MODE",
     .choices = progress_names,
     .offset = offsetof(cli_host_options, progress),
     .help = "Progress on stderr: auto, bar, plain, json (one object a line, messages too) or "
             "none; default auto, a bar on a terminal and plain lines elsewhere."},
    {.name = "quiet",
     .letter = 'q',
     .kind = CLI_FLAG,
     .offset = offsetof(cli_host_options, quiet),
     .help = "Print only errors and warnings."},
    {.name = "verbose",
     .letter = 'v',
     .kind = CLI_FLAG,
     .offset = offsetof(cli_host_options, verbose),
     .help = "Print also what the library found worth knowing."},
};

cli_option_group cli_host_group(cli_host_options *options)
{
    return (cli_option_group){"Common options", host_options,
                              sizeof host_options / sizeof host_options[0], options};
}

static bool stopping(const cli_host *host) { return cli_interrupt_pending() && !host->finishing; }

static void on_message(void *user, air_message_level level, const char *text)
{
    cli_host *const host = user;
    /* Once the user asked to stop, that some call did not finish is no news. */
    if (level == AIR_MESSAGE_ERROR && stopping(host)) {
        return;
    }
    cli_say(&host->progress, level, "%s%s%s", host->about != NULL ? host->about : "",
            host->about != NULL ? ": " : "", text);
}

static bool on_progress(void *user, double fraction, const char *what)
{
    cli_host *const host = user;
    cli_progress_update(&host->progress, fraction, what);
    return !stopping(host);
}

cli_exit cli_host_open(cli_host *host, const cli_host_options *options)
{
    air_context_params params;
    *host = (cli_host){0};
    cli_progress_init(&host->progress, (cli_progress_mode)options->progress.value, options->quiet,
                      options->verbose);
    air_context_params_default(&params);
    if (options->threads.set) {
        params.thread_count = (size_t)options->threads.value;
    }
    params.cpu = (air_cpu)options->cpu.value;
    params.message = on_message;
    params.message_user = host;
    params.progress = on_progress;
    params.progress_user = host;
    cli_interrupt_install();
    return cli_host_exit(host, air_context_create(&params, &host->context), "starting");
}

void cli_host_close(cli_host *host)
{
    cli_progress_clear(&host->progress);
    air_context_destroy(host->context);
    host->context = NULL;
}

cli_exit cli_host_exit(cli_host *host, air_status status, const char *what)
{
    if (status == AIR_OK) {
        return CLI_OK;
    }
    if (status == AIR_ERROR_INTERRUPTED) {
        return CLI_INTERRUPTED;
    }
    if (host->progress.error_count == 0) {
        cli_say(&host->progress, AIR_MESSAGE_ERROR, "%s: %s", what, air_status_name(status));
    }
    return CLI_FAILED;
}
