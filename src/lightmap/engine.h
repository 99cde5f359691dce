/* engine.h: what the writers for engines share (docs/lightmap-engines.md). */
#ifndef AIR_LIGHTMAP_ENGINE_H
#define AIR_LIGHTMAP_ENGINE_H

#include <jansson.h>

#include "airlight/lightmap.h"
#include "core/host.h"

/* What a white Lambert surface would send out, W/(m^2 sr): R, G, B of a page over pi. */
air_status air_lightmap_page_radiance(air_context *context, const air_image *page,
                                      air_image **out_image);

/* name, node and primitive of a mesh in an object that lists meshes. */
void air_lightmap_name_mesh(json_t *object, const air_lightmap_mesh *mesh);

/* The rectangle of the page that the mesh's own TEXCOORD_1 cover: {"min": [x, y], "max": [x, y]}.
 */
json_t *air_lightmap_rectangle(const air_lightmap_mesh *mesh);

#endif
