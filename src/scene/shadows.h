/* shadows.h: the shadow trees of a snapshot's collimated lights, made when first asked for and kept
 * for as long as light, meshes and media stay the same. */
#ifndef AIR_SCENE_SHADOWS_H
#define AIR_SCENE_SHADOWS_H

#include "airlight/shadow.h"
#include "scene/snapshot.h"

/* The unit vector towards a collimated light. */
void air_shadows_direction(const air_light *light, double out_to_light[3]);

/* A tree, and the box outside of which nothing lies in shadow. */
typedef struct air_shadow_view {
    const air_shadow_tree *tree; /* NULL: nothing throws a shadow */
    double low[3], high[3];
} air_shadow_view;

/* Does every medium end below the shadows that this light can throw, so that they lie in a box?
 * The media must be convex. */
bool air_shadows_end(const air_snapshot *snapshot, size_t light);

/* The tree over the opaque shadow-casting meshes, for rays inside the media. light: index of an
 * explicit collimated light for which air_shadows_end holds. The snapshot keeps the tree.
 * Thread-safe. */
air_status air_snapshot_shadows(const air_snapshot *snapshot, size_t light, air_shadow_view *out);

#endif
