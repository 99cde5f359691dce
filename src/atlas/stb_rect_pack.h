/* stb_rect_pack.h: what this library takes from stb_rect_pack, behind a function of our own, so
 * that its names stay private to one file. */
#ifndef AIR_ATLAS_STB_RECT_PACK_H
#define AIR_ATLAS_STB_RECT_PACK_H

#include "core/host.h"

typedef struct air_rectangle {
    uint32_t width, height; /* >= 1, at most 65536 */
    uint32_t x, y;          /* where it is put */
    bool placed;
} air_rectangle;

/* Puts as many of the rectangles as it finds room for into width x height, by skylines, in their
 * order (highest first is best). Deterministic. Fails for want of memory only, without a message.
 */
air_status air_rectangles_place(air_context *context, uint32_t width, uint32_t height,
                                air_rectangle *rectangles, size_t count);

#endif
