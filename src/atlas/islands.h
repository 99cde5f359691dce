/* islands.h: the charts of a layout that somebody else has made. */
#ifndef AIR_ATLAS_ISLANDS_H
#define AIR_ATLAS_ISLANDS_H

#include "atlas/surface.h"
#include "core/host.h"

/* Triangles are of one island where a chain of sides joins them whose ends have equal positions
 * (where given) and equal uv, number by number. out_charts: triangle_count numbers from 0, in the
 * order of the islands' first triangles. A side may have any number of triangles. */
air_status air_islands_find(air_context *context, const air_atlas_part *part, uint32_t *out_charts,
                            size_t *out_count);

#endif
