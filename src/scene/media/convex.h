/* convex.h: convex regions as sets of planes: from boxes, their bounds, and whether there is
 * anything inside. */
#ifndef AIR_SCENE_MEDIA_CONVEX_H
#define AIR_SCENE_MEDIA_CONVEX_H

#include "scene/media/media.h"

/* n.x <= h from (n.x, n.y, n.z, h) with a normal of any length; false if that is 0 or a number is
 * not finite. */
bool air_convex_plane(const float values[4], air_plane *out);

/* The six faces of the image of [-1,1]^3 under an affine map; false if it has no volume or is not
 * finite. */
bool air_convex_box_planes(const float box_to_world[12], air_plane out_planes[6]);

/* The bounds of that image. */
void air_convex_box_bounds(const float box_to_world[12], float out_min[3], float out_max[3]);

/* The axis-aligned bounds of the intersection of half-spaces with unit normals, infinite where it
 * is unbounded. False if it is empty or flat. plane_count <= AIR_MAX_PLANES. */
bool air_convex_bounds(const air_plane *planes, size_t plane_count, float out_min[3],
                       float out_max[3]);

/* Are these six planes the faces of a parallelepiped: three pairs of parallel ones? */
bool air_convex_is_box(const air_plane *planes, size_t plane_count);

#endif
