/* texels.h: the covered texels of a page as sites. */
#ifndef AIR_BAKE_TEXELS_H
#define AIR_BAKE_TEXELS_H

#include "bake/layout.h"
#include "bake/sites.h"

typedef struct air_texel_sites {
    const air_snapshot *snapshot;
    const air_bake_page *page;
    uint32_t *texels; /* y * width + x, by rows */
    size_t count;
    float uniform; /* see air_path_receiver */
    bool back;     /* the other sides of double-sided surfaces; there is nothing else */
} air_texel_sites;

air_status air_texel_sites_init(air_context *context, const air_snapshot *snapshot,
                                const air_bake_page *page, air_texel_sites *out);
void air_texel_sites_finish(air_context *context, air_texel_sites *sites);

/* The hit of a point of a page's coverage, its normal left out. */
air_hit air_texel_hit(const air_bake_page *page, const air_coverage_point *point);

/* air_site_list.draw, with air_texel_sites as user. */
bool air_texel_draw(const void *user, size_t site, const float u[2], air_path_receiver *out);

#endif
