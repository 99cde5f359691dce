/* moments.h: a map of heights around the camera for the moment modes. */
#ifndef AIR_RENDER_COLLIMATED_MOMENTS_H
#define AIR_RENDER_COLLIMATED_MOMENTS_H

#include "render/collimated/state.h"

/* Makes the lamp's map; its shadow view must be set. A lamp without shadows gets none. */
air_status air_collimated_moments_make(const air_with_collimated *with, collimated_lamp *lamp,
                                       const air_camera_view *view);

#endif
