/* stb_rect_pack.c: the one file that holds stb_rect_pack. */
#include "atlas/stb_rect_pack.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* In the place of qsort, whose order of equal members each C library chooses: what is given is
 * sorted already, and shall stay in its order. */
static void keep_order(void *base, size_t count, size_t size,
                       int (*compare)(const void *, const void *))
{
    (void)base;
    (void)count;
    (void)size;
    (void)compare;
}

/* Not popped: gcc asks at the end of the file. */
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpragmas"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#define STBRP_SORT keep_order
#include <stb/stb_rect_pack.h>
#pragma GCC diagnostic pop

air_status air_rectangles_place(air_context *context, uint32_t width, uint32_t height,
                                air_rectangle *rectangles, size_t count)
{
    stbrp_context packer;
    stbrp_node *nodes = air_allocate(context, width, sizeof *nodes);
    stbrp_rect *rects = air_allocate(context, count, sizeof *rects);
    const bool good = nodes != NULL && rects != NULL && count <= INT_MAX;
    if (good) {
        stbrp_init_target(&packer, (int)width, (int)height, nodes, (int)width);
        for (size_t i = 0; i < count; i++) {
            rects[i].w = (int)rectangles[i].width;
            rects[i].h = (int)rectangles[i].height;
        }
        (void)stbrp_pack_rects(&packer, rects, (int)count);
        for (size_t i = 0; i < count; i++) {
            rectangles[i].placed = rects[i].was_packed != 0;
            rectangles[i].x = rectangles[i].placed ? (uint32_t)rects[i].x : 0;
            rectangles[i].y = rectangles[i].placed ? (uint32_t)rects[i].y : 0;
        }
    }
    air_free(context, rects);
    air_free(context, nodes);
    return good ? AIR_OK : AIR_ERROR_MEMORY;
}
