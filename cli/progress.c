#include "progress.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { MESSAGE_MAX = 4096, WHAT_MAX = 192, BAR_WIDTH = 30 };

static const double bar_interval_s = 0.1, json_interval_s = 0.5;

double cli_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void cli_progress_init(cli_progress *progress, cli_progress_mode mode, bool quiet, bool verbose)
{
    if (mode == CLI_PROGRESS_AUTO) {
        mode = isatty(STDERR_FILENO) ? CLI_PROGRESS_BAR : CLI_PROGRESS_PLAIN;
    }
    *progress = (cli_progress){.mode = mode, .quiet = quiet, .verbose = verbose};
}

/* One JSON object on one line of stderr; takes `object`. */
static void write_json_line(json_t *object)
{
    if (object != NULL) {
        json_dumpf(object, stderr, JSON_COMPACT | JSON_REAL_PRECISION(6));
        fputc('\n', stderr);
        json_decref(object);
    }
}

static void clear_bar(cli_progress *progress)
{
    if (progress->bar_shown) {
        fputs("\r\033[K", stderr);
        progress->bar_shown = false;
    }
}

void cli_progress_clear(cli_progress *progress)
{
    flockfile(stderr);
    clear_bar(progress);
    fflush(stderr);
    funlockfile(stderr);
}

static void write_line(cli_progress *progress, const char *level, const char *text)
{
    const bool json = progress != NULL && progress->mode == CLI_PROGRESS_JSON;
    if (json) {
        /* Text from files may not be UTF-8: json_pack then gives NULL, and nothing would be said.
         */
        json_t *const line =
            json_pack("{s:s, s:s, s:s}", "event", "message", "level", level, "text", text);
        write_json_line(line != NULL ? line
                                     : json_pack("{s:s, s:s, s:s}", "event", "message", "level",
                                                 level, "text", "(a message that is not UTF-8)"));
        return;
    }
    if (progress != NULL) {
        clear_bar(progress);
    }
    if (strcmp(level, "info") == 0) {
        fprintf(stderr, "airlight: %s\n", text);
    } else {
        fprintf(stderr, "airlight: %s: %s\n", level, text);
    }
}

void cli_say(cli_progress *progress, air_message_level level, const char *format, ...)
{
    static const char *const names[] = {"error", "warning", "info"};
    char text[MESSAGE_MAX];
    va_list arguments;
    if (level == AIR_MESSAGE_INFO && (progress == NULL || !progress->verbose || progress->quiet)) {
        return;
    }
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    flockfile(stderr);
    if (progress != NULL && level == AIR_MESSAGE_ERROR) {
        progress->error_count++;
    }
    write_line(progress, names[level], text);
    funlockfile(stderr);
}

void cli_report(cli_progress *progress, const char *format, ...)
{
    char text[MESSAGE_MAX];
    va_list arguments;
    if (progress->quiet) {
        return;
    }
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    flockfile(stderr);
    write_line(progress, "info", text);
    funlockfile(stderr);
}

static void format_duration(double seconds, char *out, size_t size)
{
    if (seconds < 100.0) {
        snprintf(out, size, "%.0f s", seconds);
    } else if (seconds < 6000.0) {
        snprintf(out, size, "%.0f min", seconds / 60.0);
    } else {
        snprintf(out, size, "%.1f h", seconds / 3600.0);
    }
}

/* What is being done, and for which frame. */
static void format_what(const cli_progress *progress, char *out, size_t size)
{
    if (progress->in_sequence) {
        snprintf(out, size, "frame %lld (%zu of %zu): %s", progress->frame,
                 progress->frame_index + 1, progress->frame_count, progress->what);
    } else {
        snprintf(out, size, "%s", progress->what);
    }
}

static void draw_bar(cli_progress *progress, double fraction, double elapsed_s)
{
    char bar[BAR_WIDTH + 1], remaining[32] = "", what[WHAT_MAX];
    const int filled = (int)(fraction * BAR_WIDTH);
    memset(bar, '.', BAR_WIDTH);
    memset(bar, '#', (size_t)filled);
    bar[BAR_WIDTH] = '\0';
    if (fraction > 0.01 && elapsed_s > 1.0) {
        format_duration(elapsed_s * (1.0 - fraction) / fraction, remaining, sizeof remaining);
    }
    format_what(progress, what, sizeof what);
    fprintf(stderr, "\r\033[K%s [%s] %3.0f %%%s%s%s", what, bar, 100.0 * fraction,
            remaining[0] != '\0' ? ", " : "", remaining, remaining[0] != '\0' ? " left" : "");
    fflush(stderr);
    progress->bar_shown = true;
}

static void write_json_progress(const cli_progress *progress, double fraction, double elapsed_s)
{
    json_t *const line = json_pack("{s:s, s:s, s:f, s:f}", "event", "progress", "what",
                                   progress->what, "fraction", fraction, "seconds", elapsed_s);
    if (line != NULL && progress->in_sequence) {
        json_object_set_new(line, "frame", json_integer(progress->frame));
    }
    write_json_line(line);
}

static void show_progress(cli_progress *progress, double fraction, double now_s)
{
    const bool done = fraction >= 1.0;
    const int tenth = (int)(fraction * 10.0);
    const double elapsed_s = now_s - progress->start_s, pause_s = now_s - progress->shown_s;
    char what[WHAT_MAX];
    switch (progress->mode) {
    case CLI_PROGRESS_BAR:
        if (!done && pause_s < bar_interval_s) {
            return;
        }
        draw_bar(progress, fraction, elapsed_s);
        break;
    case CLI_PROGRESS_PLAIN:
        if (tenth <= progress->shown_tenth) {
            return;
        }
        format_what(progress, what, sizeof what);
        fprintf(stderr, "airlight: %s: %d %% after %.1f s\n", what, tenth * 10, elapsed_s);
        break;
    case CLI_PROGRESS_JSON:
        if (!done && pause_s < json_interval_s) {
            return;
        }
        write_json_progress(progress, fraction, elapsed_s);
        break;
    case CLI_PROGRESS_AUTO:
    case CLI_PROGRESS_NONE:
        return;
    }
    progress->shown_s = now_s;
    progress->shown_tenth = tenth;
}

void cli_progress_update(cli_progress *progress, double fraction, const char *what)
{
    if (progress->quiet || progress->mode == CLI_PROGRESS_NONE) {
        return;
    }
    const double now_s = cli_clock();
    fraction = fraction < 0.0 ? 0.0 : fraction > 1.0 ? 1.0 : fraction;
    flockfile(stderr);
    if (strncmp(progress->what, what, sizeof progress->what - 1) != 0) {
        snprintf(progress->what, sizeof progress->what, "%s", what);
        progress->start_s = now_s;
        progress->shown_s = now_s;
        progress->shown_tenth = 0;
    }
    show_progress(progress, fraction, now_s);
    funlockfile(stderr);
}

void cli_progress_frame(cli_progress *progress, long long frame, size_t index, size_t count)
{
    flockfile(stderr);
    progress->in_sequence = true;
    progress->frame = frame;
    progress->frame_index = index;
    progress->frame_count = count;
    progress->what[0] = '\0'; /* the same activity begins anew */
    funlockfile(stderr);
}
