/* finish.h: from the records of texels to the pages of a lightmap. */
#ifndef AIR_BAKE_FINISH_H
#define AIR_BAKE_FINISH_H

#include "bake/texels.h"

/* Makes the page's image (lightmap.h lists its channels) from the records of its sites. Texels of
 * which less than half of the samples were outside of solid things are filled from their
 * neighbours; out_invalid counts them. */
air_status air_bake_finish(air_context *context, const air_bake_params *params,
                           const air_texel_sites *sites, const air_site_list *list,
                           air_image **out_image, size_t *out_invalid);

#endif
