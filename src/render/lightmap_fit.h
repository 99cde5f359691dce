/* lightmap_fit.h: is a lightmap one of this scene? */
#ifndef AIR_RENDER_LIGHTMAP_FIT_H
#define AIR_RENDER_LIGHTMAP_FIT_H

#include "airlight/lightmap.h"
#include "scene/snapshot.h"

/* Number, names and triangles of the meshes; the coordinates that the lightmap counts on.
 * AIR_ERROR_ARGUMENT: not so; the message names the mesh, and the files of both. */
air_status air_lightmap_fit(const air_lightmap *lightmap, const air_snapshot *snapshot);

#endif
