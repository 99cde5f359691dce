/* shadow_build.h: from triangles in light space to the cells of the tree. */
#ifndef AIR_COLLIMATED_SHADOW_BUILD_H
#define AIR_COLLIMATED_SHADOW_BUILD_H

#include "collimated/shadow_mesh.h"

/* Fills nodes and blocks of a tree whose frame is set; on failure they are to be freed all the
 * same. */
air_status air_shadow_build(const air_shadow_tree_params *params, const shadow_mesh *mesh,
                            air_shadow_tree *tree);

#endif
