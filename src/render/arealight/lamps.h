/* lamps.h: the convex lamps that flat lights are to the arealight method. */
#ifndef AIR_RENDER_AREALIGHT_LAMPS_H
#define AIR_RENDER_AREALIGHT_LAMPS_H

#include "render/arealight/state.h"
#include "render/owner.h"

/* How many lamps the emissive meshes together would be. */
air_status air_area_lamps_count_emitters(const air_snapshot *snapshot, size_t *out_count);

/* Fills with->lamps with what the table gives to the method. On failure, too,
 * air_area_lamps_finish frees them. */
air_status air_area_lamps_make(air_with_arealight *with, const air_owner_table *owners);
void air_area_lamps_finish(air_with_arealight *with);

#endif
