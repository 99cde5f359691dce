/* frames.h: the frames of a sequence as options name them, and the files that belong to each. */
#ifndef AIR_CLI_FRAMES_H
#define AIR_CLI_FRAMES_H

#include <airlight/frame.h>

#include "output.h"

/* More frames than this in one run are taken for a mistake. */
enum { CLI_FRAMES_MAX = 100000 };

/* first, first + step, ... up to last. Not set: one frame without a number. */
typedef struct cli_frames {
    bool set;
    int64_t first, last, step;
} cli_frames;

/* Reads "N", "A-B" or "A-B/STEP"; NULL leaves *out not set. Prints what is wrong: exit code 2. */
cli_exit cli_frames_read(const char *text, cli_frames *out);

/* 1 where there are none. */
size_t cli_frames_count(const cli_frames *frames);
/* AIR_FRAME_NONE where there are none. */
int64_t cli_frames_at(const cli_frames *frames, size_t index);

/* Do all these names hold a run of #, as they must where there are several frames? Prints those
 * that do not, and runs that cannot be numbers: exit code 2. */
cli_exit cli_frames_check_names(cli_host *host, const cli_frames *frames, const cli_list *names);

/* A list whose items it owns. */
typedef struct cli_frame_names {
    cli_list list;
} cli_frame_names;

/* The names at a frame, AIR_FRAME_NONE: as they are. What *out held before is freed, also on
 * failure. */
cli_exit cli_frame_names_set(cli_host *host, const cli_list *names, int64_t frame,
                             cli_frame_names *out);
void cli_frame_names_finish(cli_frame_names *names);

#endif
