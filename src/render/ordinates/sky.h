/* sky.h: the sky as forward peaks of phase functions blur it.
 *
 * Scattering into the peak counts as no event (delta-M), so a camera ray that goes on to the sky
 * has that light from straight ahead: its share is what is let through with the peak counted as no
 * event, less what is let through at all. Taken from the sky's own picture it has none of the
 * ordinates' spots. */
#ifndef AIR_RENDER_ORDINATES_SKY_H
#define AIR_RENDER_ORDINATES_SKY_H

#include "render/ordinates/past.h"
#include "render/owner.h"
#include "scene/snapshot.h"

enum { ORD_SKY_WIDTH = 128, ORD_SKY_HEIGHT = 64 };

/* One environment; lat-long as its image. */
typedef struct ord_sky_map {
    const air_light *light;
    float *radiance; /* 4 per texel, blurred; NULL: light->color everywhere */
} ord_sky_map;

typedef struct ord_sky {
    air_context *context;
    ord_sky_map *maps;
    size_t count;
} ord_sky;

/* The environments that the method owns, blurred by the part of the phase function that is above
 * the cap (air_seen_cap), or as the past has them. On failure out is as after ord_sky_finish. */
air_status ord_sky_make(const air_snapshot *snapshot, const air_owner_table *owners,
                        air_phase phase, double share, ord_past *past, ord_sky *out);
void ord_sky_finish(ord_sky *sky);

/* Radiance from a direction. */
air_vec3 ord_sky_radiance(const ord_sky *sky, air_vec3 dir);

#endif
