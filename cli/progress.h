/* progress.h: what the command says on stderr while it runs: messages and progress, as text or as
 * lines of JSON. */
#ifndef AIR_CLI_PROGRESS_H
#define AIR_CLI_PROGRESS_H

#include <airlight/context.h>

/* In the order of the choices of --progress. */
typedef enum cli_progress_mode {
    CLI_PROGRESS_AUTO, /* bar on a terminal, else plain */
    CLI_PROGRESS_BAR,
    CLI_PROGRESS_PLAIN, /* one line at every tenth */
    CLI_PROGRESS_JSON,  /* every line of stderr, messages too, is a JSON object */
    CLI_PROGRESS_NONE
} cli_progress_mode;

/* Progress and messages may come from any thread: the state is guarded by the lock of the stream
 * stderr. */
typedef struct cli_progress {
    cli_progress_mode mode; /* never AUTO */
    bool quiet, verbose;
    bool bar_shown;
    size_t error_count;
    char what[64]; /* the activity under way; "" before the first */
    bool in_sequence;
    long long frame; /* of a sequence */
    size_t frame_index, frame_count;
    double start_s; /* when it began */
    double shown_s; /* when something was last shown */
    int shown_tenth;
} cli_progress;

void cli_progress_init(cli_progress *progress, cli_progress_mode mode, bool quiet, bool verbose);

/* "airlight: error: TEXT" on stderr. Information appears with -v only. progress NULL: before there
 * is one. */
void cli_say(cli_progress *progress, air_message_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A line that reports a result rather than a trouble; not with -q. Every line is followed by a
 * newline. */
void cli_report(cli_progress *progress, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void cli_progress_update(cli_progress *progress, double fraction, const char *what);

/* From now on progress is that of this frame, the index-th (from 0) of `count`. */
void cli_progress_frame(cli_progress *progress, long long frame, size_t index, size_t count);

/* Takes the bar away; to be called before anything else is written to the terminal. */
void cli_progress_clear(cli_progress *progress);

/* Seconds of a monotonic clock. */
double cli_clock(void);

#endif
