/* diff_temporal.h: reading two sequences of pictures, frame by frame. */
#ifndef AIR_CLI_DIFF_TEMPORAL_H
#define AIR_CLI_DIFF_TEMPORAL_H

#include <airlight/temporal.h>

#include "frames.h"

/* Takes in all frames of two names with #. *out is the caller's also on failure. */
cli_exit cli_diff_sequences(cli_host *host, char *const paths[2], const cli_frames *frames,
                            air_temporal **out);

#endif
