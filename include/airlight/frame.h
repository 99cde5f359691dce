/* frame.h: sequences of files, one for each frame of an animation.
 *
 * A path whose last part holds a run of # stands for a sequence: the run gives way to the number
 * of the frame, with zeros before it up to the length of the run. "smoke.####.vol" is
 * "smoke.0007.vol" at frame 7 and "smoke.12345.vol" at frame 12345. Folders may hold # as they
 * like. */
#ifndef AIRLIGHT_FRAME_H
#define AIRLIGHT_FRAME_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

/* AIR_FRAME_NONE: no frame is meant, and paths are taken as they are. Frames are numbered from 0 to
 * AIR_FRAME_MAX; runs have 1 to AIR_FRAME_DIGITS_MAX #. */
enum { AIR_FRAME_NONE = -1, AIR_FRAME_MAX = 999999999, AIR_FRAME_DIGITS_MAX = 9 };

/* The length of the run of # in the last part of a path, 0 if there is none. AIR_ERROR_ARGUMENT:
 * several runs, or a longer one than AIR_FRAME_DIGITS_MAX. Thread-safe. */
AIR_API air_status air_frame_digits(air_context *context, const char *path, size_t *out_digits);

/* The path at a frame; one without # is copied. size: of the buffer, with room for the final NUL;
 * strlen(path) + 10 always do. AIR_ERROR_ARGUMENT: a frame outside 0 to AIR_FRAME_MAX, a run that
 * air_frame_digits refuses, too small a buffer, which is then untouched. Thread-safe. */
AIR_API air_status air_frame_path(air_context *context, const char *path, int64_t frame,
                                  char *buffer, size_t size);

#ifdef __cplusplus
}
#endif
#endif
