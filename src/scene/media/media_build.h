/* media_build.h: from medium descriptions to the media of a snapshot. */
#ifndef AIR_SCENE_MEDIA_MEDIA_BUILD_H
#define AIR_SCENE_MEDIA_MEDIA_BUILD_H

#include "scene/media/grid.h"
#include "scene/media/media.h"

/* A description with the grids that its handles name, NULL where the handle is AIR_NONE. */
typedef struct air_medium_source {
    const air_medium_desc *desc;
    const air_grid *density_grid, *albedo_grid, *emission_grid;
} air_medium_source;

/* Checks every field of a description, closedness of a mesh boundary included; handles are not
 * looked at. On failure AIR_ERROR_ARGUMENT with a message that names the medium and the field. */
air_status air_medium_check(air_context *context, const air_medium_desc *desc);

/* Makes the media of checked descriptions. Names, planes and boundary meshes are copied; grids are
 * borrowed and must outlive *out. Fails with AIR_ERROR_ARGUMENT when regions exceed
 * AIR_MAX_REGIONS. */
air_status air_media_build(air_context *context, const air_medium_source *sources, size_t count,
                           air_media *out);
void air_media_finish(air_context *context, air_media *media); /* all zero is legal */

#endif
