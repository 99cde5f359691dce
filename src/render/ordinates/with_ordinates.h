/* with_ordinates.h: light in a grid at work in a scene: M1 and M2 of the lights that the ordinates
 * kernels own. */
#ifndef AIR_RENDER_WITH_ORDINATES_H
#define AIR_RENDER_WITH_ORDINATES_H

#include "path/path.h"
#include "scene/camera.h"

struct air_owner_table;

/* How light that is scattered more than once is found, in the order of the modes' names. */
typedef enum air_ordinates_mode {
    AIR_ORDINATES_MODE_DOM = 0,
    AIR_ORDINATES_MODE_CM = 1,
    AIR_ORDINATES_MODE_SIX = 2,
    AIR_ORDINATES_MODE_LITERAL = 3,
    AIR_ORDINATES_MODE_SHDOM = 4,
    AIR_ORDINATES_MODE_COUNT = 5
} air_ordinates_mode;

typedef struct air_with_ordinates air_with_ordinates;
typedef struct air_march_scratch air_march_scratch; /* one per worker */

/* Solves for what the table gives to the method, as seen from the view; *out is NULL where that is
 * nothing. split: M1 and M2 are wanted apart, else both may come as M2. The path, its snapshot, the
 * table, the view and the parameters must outlive it. */
air_status air_with_ordinates_create(const air_path *path, const struct air_owner_table *owners,
                                     const air_camera_view *view, const air_render_params *params,
                                     uint32_t terms, bool split, air_with_ordinates **out);
void air_with_ordinates_destroy(air_with_ordinates *with); /* NULL is legal */

/* Adds to a hash what the picture depends on beside the scene. */
uint64_t air_with_ordinates_fingerprint(const air_with_ordinates *with, uint64_t hash);

air_status air_march_scratch_create(const air_with_ordinates *with, air_march_scratch **out);
void air_march_scratch_destroy(const air_with_ordinates *with, air_march_scratch *scratch);

/* Adds the terms of count lanes that air_path_trace has traced. */
void air_with_ordinates_add(const air_with_ordinates *with, air_march_scratch *scratch,
                            air_path_lane *lanes, size_t count);

#endif
