/* unwrap_frame.h: how a chart is turned. */
#ifndef AIR_ATLAS_UNWRAP_FRAME_H
#define AIR_ATLAS_UNWRAP_FRAME_H

#include <stddef.h>

/* The direction, in the plane of count >= 1 points (x, y, x, y and so on), that becomes x to the
 * right; the direction a quarter turn counterclockwise from it becomes up. The bounding rectangle
 * is the smallest, or within 2 % of it that which stands upright, and turned by quarters as nearly
 * upright as it can be. `up`: the direction that is up in the world, not 0. The points are sorted.
 */
void air_unwrap_frame(double *points, size_t count, double *hull, const double up[2],
                      double out_right[2]);

#endif
