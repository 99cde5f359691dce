/* weld.h: which vertices are equal. */
#ifndef AIR_ATLAS_WELD_H
#define AIR_ATLAS_WELD_H

#include <stddef.h>
#include <stdint.h>

#include "core/host.h"

/* Keys of vertices: position (3 floats), or position and uv (5). Either array may be NULL. */
typedef struct air_weld_keys {
    const float *positions, *uv;
    size_t vertex_count;
} air_weld_keys;

/* out_first[v]: the first vertex whose key equals that of v, number by number (-0 equals 0; NaN
 * equals NaN of the same bits). Linear in expectation. Fails for want of memory only, without a
 * message. */
air_status air_weld(air_context *context, const air_weld_keys *keys, uint32_t *out_first);

#endif
