/* unwrapped.h: lightmap coordinates for one mesh. */
#ifndef AIR_BAKE_UNWRAPPED_H
#define AIR_BAKE_UNWRAPPED_H

#include "bake/layout.h"

/* Texels along the two sides of a mesh's own rectangle. */
typedef struct air_mesh_rectangle {
    double width, height; /* whole numbers where the mesh was cut */
} air_mesh_rectangle;

/* Chooses between the mesh's own coordinates and new ones, and fills out_mesh, but for its page and
 * place there. Meshes that show nothing of their light (unlit) get no rectangle: width 0. */
air_status air_mesh_coordinates(air_context *context, const air_snapshot *snapshot, size_t mesh,
                                const air_bake_params *params, air_lightmap_mesh *out_mesh,
                                air_mesh_rectangle *out_rectangle);

/* Texels that a chart or a mesh keeps free around itself: two that meet have the padding between
 * them. */
static inline uint32_t air_half_padding(const air_bake_params *params)
{
    return (params->padding + 1) / 2;
}

#endif
