/* sequence.h: a scene that is loaded once and then moved from frame to frame. */
#ifndef AIR_CLI_SEQUENCE_H
#define AIR_CLI_SEQUENCE_H

#include "frames.h"
#include "scene_options.h"

typedef struct cli_sequence {
    air_scene *scene;
    air_snapshot *snapshot; /* of the frame it is at */
    uint32_t dirty; /* the or of air_dirty since it was last set to 0 by who renders the frames */
    air_handle camera; /* as the file has it; AIR_NONE: the one that frames the bounds */
    bool orbits;
    double orbit_deg;      /* each frame, about +Y */
    air_camera_desc still; /* the camera as the file has it; not used where it frames the bounds */
    air_handle turned; /* a camera that stands for the one that frames the bounds, or AIR_NONE */
} cli_sequence;

/* Loads and freezes the scene at the frame, AIR_FRAME_NONE for a scene without. A zeroed sequence
 * that failed to open may be closed. */
cli_exit cli_sequence_open(cli_host *host, const char *path, const cli_scene_options *options,
                           int64_t frame, cli_sequence *out);
void cli_sequence_close(cli_sequence *sequence);

/* Through which camera the frames are seen, and how it turns; its name has to stay. */
cli_exit cli_sequence_set_camera(cli_host *host, const cli_camera *camera, const cli_real *orbit,
                                 cli_sequence *sequence);

/* Moves to a frame: its grids, and the camera turned by as many times orbit_deg around the centre
 * of the media, or of the scene where no medium has bounds. What the frame looks like does not
 * depend on those before it. */
cli_exit cli_sequence_move(cli_host *host, cli_sequence *sequence, int64_t frame);

/* What the frame is seen through. */
air_handle cli_sequence_camera(const cli_sequence *sequence);

#endif
