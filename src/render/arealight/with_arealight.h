/* with_arealight.h: the arealight kernel at work in a scene: S0 and M1 of the lamps it owns. */
#ifndef AIR_RENDER_WITH_AREALIGHT_H
#define AIR_RENDER_WITH_AREALIGHT_H

#include "airlight/arealight.h"
#include "path/path.h"
#include "render/ratio.h"

struct air_owner_table;

/* How the phase function is integrated over a lamp, in the order of the modes' names. */
typedef enum air_area_mode {
    AIR_AREA_MODE_EDGE = 0,      /* exactly, by the lamp's edges */
    AIR_AREA_MODE_MIX = 1,       /* by two lobes */
    AIR_AREA_MODE_LTSD = 2,      /* the paper's two lobes, and its transmittance */
    AIR_AREA_MODE_VOLUME_RIS = 3 /* not: samples, of which one is kept */
} air_area_mode;

typedef struct air_with_arealight air_with_arealight;
typedef struct air_area_scratch air_area_scratch; /* one per worker */

/* Gets ready what the table gives to the method; *out is NULL where that is nothing. terms: those
 * of the parameters that are to be computed. The path, its snapshot, the table and the parameters
 * must outlive it. */
air_status air_with_arealight_create(const air_path *path, const struct air_owner_table *owners,
                                     const air_render_params *params, uint32_t terms,
                                     air_with_arealight **out);
void air_with_arealight_destroy(air_with_arealight *with); /* NULL is legal */

/* Are visible shares estimated, three sums each for surfaces and for the volume? */
bool air_with_arealight_is_ratio(const air_with_arealight *with); /* of NULL: false */

air_status air_area_scratch_create(const air_with_arealight *with, air_area_scratch **out);
void air_area_scratch_destroy(const air_with_arealight *with, air_area_scratch *scratch);

/* Adds the terms of count lanes that air_path_trace has traced; ratios gets what stands in three
 * sums. */
void air_with_arealight_add(const air_with_arealight *with, air_area_scratch *scratch,
                            air_path_lane *lanes, air_lane_ratios *ratios, size_t count);

#endif
