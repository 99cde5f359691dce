/* pack.h: rectangles onto pages. */
#ifndef AIR_ATLAS_PACK_H
#define AIR_ATLAS_PACK_H

#include "core/host.h"

/* A chart, or a mesh with a layout of its own. */
typedef struct air_pack_item {
    double size[2]; /* texels, > 0; rounded up */
    bool fixed;     /* must not be turned */
} air_pack_item;

/* The place of the item's first texel; its padding lies around it. */
typedef struct air_pack_place {
    uint32_t page;
    uint32_t x, y;
    uint32_t width, height; /* texels on the page, after scaling and turning */
    bool turned;            /* by 90 degrees: (x, y) of the item is at (y, width - x) */
} air_pack_place;

typedef struct air_pack_params {
    uint32_t padding;  /* texels on each side of an item that are its own: between two items there
                          are twice as many; default 2 */
    uint32_t max_size; /* sides of a page, at most 65536; default 4096 */
    size_t max_pages;  /* default SIZE_MAX */
    bool power_of_two; /* sides of pages; default true; else as small as they can be */
    bool turn;         /* items may be turned; default true */
    bool scale_to_fit; /* sizes shrink by a common factor until one page holds all; default false */
} air_pack_params;

void air_pack_params_default(air_pack_params *params);

typedef struct air_pack_page {
    uint32_t width, height;
} air_pack_page;

typedef struct air_pack {
    air_pack_place *places; /* of each item */
    size_t item_count;
    air_pack_page *pages;
    size_t page_count;
    double scale;       /* of sizes, <= 1; 1 unless scale_to_fit */
    double utilisation; /* texels of items by those of pages */
} air_pack;

/* Deterministic. AIR_ERROR_ARGUMENT: a parameter out of range, an item too large for a page (the
 * message names it and the size that it needs), more pages than allowed, or items that do not fit a
 * page at any scale. Free with air_pack_destroy. */
air_status air_pack_create(air_context *context, const air_pack_item *items, size_t item_count,
                           const air_pack_params *params, air_pack **out_pack);
void air_pack_destroy(air_context *context, air_pack *pack); /* NULL is legal */

/* Where a point of an item, in texels of the item before scaling, is on its page. */
void air_pack_point(const air_pack *pack, size_t item, const double point[2], double out[2]);

#endif
