/* with_collimated.h: the collimated kernel at work in a scene: S0 and M1 of the lights it owns. */
#ifndef AIR_RENDER_WITH_COLLIMATED_H
#define AIR_RENDER_WITH_COLLIMATED_H

#include "airlight/collimated.h"
#include "path/path.h"
#include "render/ratio.h"
#include "scene/camera.h"

struct air_owner_table;

/* How visibility along a ray is found. */
typedef enum air_collimated_mode {
    AIR_COLLIMATED_EXACT = 0, /* lit stretches from the scene's triangles: no noise */
    AIR_COLLIMATED_MODE_RM =
        1, /* one sample each, as the estimators of the kernel, in their order */
    AIR_COLLIMATED_MODE_DS = 2,
    AIR_COLLIMATED_MODE_WVDS = 3,
    AIR_COLLIMATED_MODE_REES = 4,
    AIR_COLLIMATED_MODE_REDS = 5,
    AIR_COLLIMATED_MODE_ME = 6, /* moments of a map of heights: 4 or 6, weights shared by the rays
                                   of a row or each ray's own */
    AIR_COLLIMATED_MODE_ME6 = 7,
    AIR_COLLIMATED_MODE_ME_IDEAL = 8,
    AIR_COLLIMATED_MODE_ME6_IDEAL = 9,
    AIR_COLLIMATED_MODE_COUNT = 10
} air_collimated_mode;

typedef struct air_with_collimated air_with_collimated;
typedef struct air_collimated_scratch air_collimated_scratch; /* one per worker */

/* Gets ready what the table gives to the method: shadow trees, maps, cells. *out is NULL where that
 * is nothing. The path, its snapshot and the table must outlive it. terms: as in
 * air_render_params. A mode that needs one point for all camera rays is replaced by exact, with a
 * warning, where the view has none. */
air_status air_with_collimated_create(const air_path *path, const struct air_owner_table *owners,
                                      const air_camera_view *view, uint32_t terms,
                                      air_with_collimated **out);
void air_with_collimated_destroy(air_with_collimated *with); /* NULL is legal */

/* Is the mode one of the kernel's estimators? Which one? */
static inline bool air_collimated_mode_samples(air_collimated_mode mode)
{
    return mode >= AIR_COLLIMATED_MODE_RM && mode <= AIR_COLLIMATED_MODE_REDS;
}

static inline air_collimated_estimator air_collimated_mode_estimator(air_collimated_mode mode)
{
    return (air_collimated_estimator)(mode - AIR_COLLIMATED_MODE_RM);
}

/* Does some light keep three sums? */
bool air_with_collimated_is_ratio(const air_with_collimated *with);

air_status air_collimated_scratch_create(const air_with_collimated *with,
                                         air_collimated_scratch **out);
void air_collimated_scratch_destroy(const air_with_collimated *with,
                                    air_collimated_scratch *scratch);

/* Adds to the terms of traced lanes; ratios[0..count) are overwritten. */
void air_with_collimated_add(const air_with_collimated *with, air_collimated_scratch *scratch,
                             air_path_lane *lanes, air_lane_ratios *ratios, size_t count);

#endif
