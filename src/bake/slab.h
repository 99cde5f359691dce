/* slab.h: the sun over a layer of fog, seen from below: what the exact radiance of single
 * scattering under a slanted boundary [Dubouchet2019, our reading, D2] has more than that under a
 * boundary across the light, which is what the directional table holds. The table is wrong by -100
 * % to +61 % there.
 *
 * For each collimated light and each plane that bounds the medium towards it, over optical depth.
 */
#ifndef AIR_BAKE_SLAB_H
#define AIR_BAKE_SLAB_H

#include "scene/snapshot.h"

typedef struct air_slab air_slab;

/* *out is NULL where the medium is not one convex region of constant density, or no collimated
 * light is there. */
air_status air_slab_create(air_context *context, const air_snapshot *snapshot, size_t medium,
                           air_slab **out);
void air_slab_destroy(air_slab *slab); /* NULL is legal */

/* Irradiance to be added for a receiver in the medium, E0 = 1 across to_light; 0 for lights that
 * are not in it. May be negative. */
air_vec3 air_slab_correction(const air_slab *slab, uint32_t light, air_vec3 position,
                             air_vec3 to_light, air_vec3 normal);

#endif
