/* first_light.h: final gathering. A first pass with few samples finds the light of all texels; in
 * the bake proper, walks end at the first surface, which reflects what its texel got.
 *
 * A texel's light is the mean over what it covers, so looking up the texel and not between texels
 * is right on average, whatever varies within it. Double-sided surfaces have two lights. What is
 * not known is left to the walk: surfaces on no page, texels inside of something, and texels that
 * two differently turned surfaces share. */
#ifndef AIR_BAKE_FIRST_LIGHT_H
#define AIR_BAKE_FIRST_LIGHT_H

#include "bake/layout.h"
#include "bake/sites.h"
#include "bake/texels.h"

typedef struct air_first_light air_first_light;

/* Room for the light of all pages of a layout, which is borrowed; none is known yet. */
air_status air_first_light_create(air_context *context, const air_bake_layout *layout,
                                  air_first_light **out_light);
void air_first_light_destroy(air_first_light *light); /* NULL is legal */

/* Has a page surfaces with two sides? */
bool air_first_light_has_backs(const air_first_light *light, size_t page);

/* Takes the records of a page's texels, or of their backs (texels.h). */
air_status air_first_light_take(air_first_light *light, size_t page, const air_texel_sites *sites,
                                const air_site_list *list);

/* air_path_arrived.irradiance, with the first light as user. */
bool air_first_light_irradiance(const void *light, const air_hit *hit, bool front, air_vec3 out[2]);

#endif
