/* march.h: along camera rays: what march.c and march_voxels.c share. */
#ifndef AIR_RENDER_ORDINATES_MARCH_H
#define AIR_RENDER_ORDINATES_MARCH_H

#include "render/ordinates/state.h"

/* In one stretch of a ray at most. */
#define ORD_MOST_STEPS 16384.0f

/* What a ray has gathered so far, and what of light from farther away gets through. */
typedef struct ord_gathered {
    air_vec3 through[ORD_MARCHES], sum[ORD_MARCHES];
} ord_gathered;

/* Adds to g, lane by lane, what the spans in scratch send, which follow nothing that is not in
 * them. */
void ord_march_voxels(const air_with_ordinates *with, const air_march_scratch *scratch,
                      const air_path_lane *lanes, size_t count, ord_gathered *g);

#endif
