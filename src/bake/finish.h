/* finish.h: from the records of texels to the pages of a lightmap: noise, gaps, seams. */
#ifndef AIR_BAKE_FINISH_H
#define AIR_BAKE_FINISH_H

#include "bake/texels.h"

/* A page under way. */
typedef struct air_finished_page {
    air_image *image; /* channels as lightmap.h has them, and albedo.R, .G, .B */
    uint32_t *charts; /* of each texel; AIR_NO_CHART: free, or inside of something */
    size_t invalid;   /* texels inside of something: filled from their neighbours */
} air_finished_page;

/* Makes the image from the records of the page's sites, takes noise out and continues charts into
 * their surroundings as the parameters say. Free with air_finished_page_destroy, on failure too. */
air_status air_finish_page(air_context *context, const air_bake_params *params,
                           const air_texel_sites *sites, const air_site_list *list,
                           air_finished_page *out);
void air_finished_page_destroy(air_context *context, air_finished_page *page);

/* Makes both sides of seams agree, over all pages. */
air_status air_finish_seams(air_context *context, const air_bake_layout *layout,
                            const air_finished_page *pages);

#endif
