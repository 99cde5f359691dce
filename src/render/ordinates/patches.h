/* patches.h: lit surfaces as sources of light for the cells: what lights, surfaces and
 * media send to surfaces and these reflect, as a few diffuse patches [Elek2014, section 6]. */
#ifndef AIR_RENDER_ORDINATES_PATCHES_H
#define AIR_RENDER_ORDINATES_PATCHES_H

#include "render/ordinates/photons.h"

/* Events up to which those in surfaces are counted. Where more are allowed, all light that surfaces
 * send counts, whatever came before: what that adds beyond the limit is far less than what would be
 * left out else. */
enum { ORD_SURFACE_EVENTS = 7 };

/* Rounds [1, photons->rounds) as about `patches` sources, at least one where there is light. Light
 * of surfaces that face away from the domain is left out; else fluxes sum to the photons'. */
air_status ord_patches_choose(const ord_space *space, const ord_photons *photons, size_t patches,
                              ord_source_list *out);

/* The light of all lights that the method owns, after the surfaces' first reflection and more, by
 * max_depth events in surfaces and media. With a limit patches are as many for each reflection. */
air_status ord_patches_add(const ord_lighting *lighting, const ord_space *space, uint32_t max_depth,
                           ord_source_list *out);

#endif
