/* pack.c: pages are filled one after the other by skylines; the last one is made as small as it can
 * be. Items lying, standing and as they are given are tried, and what needs least is taken. */
#include "atlas/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "atlas/stb_rect_pack.h"
#include "core/vec.h"

typedef enum arrangement {
    ARRANGE_LYING,
    ARRANGE_STANDING,
    ARRANGE_GIVEN,
    ARRANGEMENT_COUNT
} arrangement;

void air_pack_params_default(air_pack_params *params)
{
    *params = (air_pack_params){.padding = 2,
                                .max_size = 4096,
                                .max_pages = SIZE_MAX,
                                .power_of_two = true,
                                .turn = true,
                                .scale_to_fit = false};
}

/* An item with its padding. */
typedef struct cell {
    uint32_t width, height;
    uint32_t item;
    bool turned;
} cell;

typedef struct packing {
    air_context *context;
    const air_pack_item *items;
    size_t item_count;
    const air_pack_params *params;
    uint32_t side; /* of the largest page */
    cell *cells;   /* those that have no place yet come first */
    air_rectangle *rectangles;
    air_pack result; /* of the arrangement at work */
} packing;

/* ---- cells ---- */

/* Rounding may leave a hair more than whole texels. */
static uint32_t texels_of(double size, double scale)
{
    return (uint32_t)double_max(ceil(size * scale - 1e-6), 1.0);
}

/* Highest first, then widest, then by number. */
static int compare_cells(const void *a, const void *b)
{
    const cell *x = a, *y = b;
    if (x->height != y->height) {
        return x->height > y->height ? -1 : 1;
    }
    if (x->width != y->width) {
        return x->width > y->width ? -1 : 1;
    }
    return (x->item > y->item) - (x->item < y->item);
}

static void make_cells(packing *p, arrangement how, double scale)
{
    const uint32_t around = 2 * p->params->padding;
    for (size_t i = 0; i < p->item_count; i++) {
        const air_pack_item *item = &p->items[i];
        const uint32_t width = texels_of(item->size[0], scale);
        const uint32_t height = texels_of(item->size[1], scale);
        const bool wrong = how == ARRANGE_LYING ? width < height : width > height;
        const bool turned = p->params->turn && !item->fixed && how != ARRANGE_GIVEN && wrong;
        p->cells[i] = (cell){(turned ? height : width) + around, (turned ? width : height) + around,
                             (uint32_t)i, turned};
    }
    qsort(p->cells, p->item_count, sizeof *p->cells, compare_cells);
}

static uint64_t area_of(const cell *cells, size_t count)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += (uint64_t)cells[i].width * cells[i].height;
    }
    return sum;
}

/* ---- one page ---- */

/* Puts what it can of the cells on a page; how many. */
static air_status try_page(packing *p, const cell *cells, size_t count, air_pack_page page,
                           size_t *out_placed)
{
    for (size_t i = 0; i < count; i++) {
        p->rectangles[i] = (air_rectangle){cells[i].width, cells[i].height, 0, 0, false};
    }
    const air_status status =
        air_rectangles_place(p->context, page.width, page.height, p->rectangles, count);
    *out_placed = 0;
    for (size_t i = 0; i < count && status == AIR_OK; i++) {
        *out_placed += p->rectangles[i].placed;
    }
    return status;
}

/* Places of the rectangles that have one; their cells go to the end, the others stay in order. */
static void keep_places(packing *p, cell *cells, size_t count, uint32_t page, cell *placed)
{
    const uint32_t padding = p->params->padding;
    size_t left = 0, done = 0;
    for (size_t i = 0; i < count; i++) {
        const air_rectangle *r = &p->rectangles[i];
        if (!r->placed) {
            cells[left++] = cells[i];
            continue;
        }
        p->result.places[cells[i].item] = (air_pack_place){page,
                                                           r->x + padding,
                                                           r->y + padding,
                                                           r->width - 2 * padding,
                                                           r->height - 2 * padding,
                                                           cells[i].turned};
        placed[done++] = cells[i];
    }
    memcpy(cells + left, placed, done * sizeof *placed);
}

static air_pack_page cropped(const packing *p, size_t count)
{
    air_pack_page page = {1, 1};
    for (size_t i = 0; i < count; i++) {
        const air_rectangle *r = &p->rectangles[i];
        if (r->placed) {
            page.width = r->x + r->width > page.width ? r->x + r->width : page.width;
            page.height = r->y + r->height > page.height ? r->y + r->height : page.height;
        }
    }
    return page;
}

/* The smallest page with sides of powers of two that holds all cells: by area, the squarest first,
 * wide before high. The largest page is known to. */
static air_status shrink_power(packing *p, const cell *cells, size_t count, air_pack_page *page)
{
    const uint64_t needed = area_of(cells, count);
    for (int sum = 0; sum <= 32; sum++) {
        for (int wide = (sum + 1) / 2; wide <= sum && wide <= 16; wide++) {
            for (int k = 0; k < (2 * wide == sum ? 1 : 2); k++) {
                const int a = k == 0 ? wide : sum - wide;
                const air_pack_page at = {1u << a, 1u << (sum - a)};
                size_t placed;
                if (at.width > p->side || at.height > p->side ||
                    (uint64_t)at.width * at.height < needed) {
                    continue;
                }
                const air_status status = try_page(p, cells, count, at, &placed);
                if (status != AIR_OK || placed == count) {
                    *page = at;
                    return status;
                }
            }
        }
    }
    return AIR_OK;
}

/* The smallest square that holds all, in steps of 2 %, cut where nothing is. */
static air_status shrink_free(packing *p, const cell *cells, size_t count, air_pack_page *page)
{
    double side = sqrt((double)area_of(cells, count));
    for (size_t i = 0; i < count; i++) {
        side = double_max(side, (double)cells[i].width);
    }
    for (;; side *= 1.02) {
        const double whole = double_min(ceil(side), (double)p->side);
        const air_pack_page at = {(uint32_t)whole,
                                  (uint32_t)double_min(2.0 * whole, (double)p->side)};
        size_t placed;
        const air_status status = try_page(p, cells, count, at, &placed);
        if (status != AIR_OK) {
            return status;
        }
        const air_pack_page cut = cropped(p, count);
        if ((placed == count && cut.height <= 1.1 * whole) || at.width == p->side) {
            *page = cut;
            return AIR_OK;
        }
    }
}

/* ---- pages ---- */

static air_status add_page(packing *p, air_pack_page page)
{
    air_pack_page *grown =
        air_reallocate(p->context, p->result.pages, p->result.page_count + 1, sizeof *grown);
    if (grown == NULL) {
        return AIR_ERROR_MEMORY;
    }
    grown[p->result.page_count++] = page;
    p->result.pages = grown;
    return AIR_OK;
}

/* Fills a page with what is left; the last one shrinks. *left: cells without a place. */
static air_status fill_page(packing *p, size_t *left, cell *spare)
{
    air_pack_page page = {p->side, p->side};
    const uint32_t number = (uint32_t)p->result.page_count;
    size_t placed;
    air_status status = try_page(p, p->cells, *left, page, &placed);
    if (status == AIR_OK && placed == *left) {
        status = p->params->power_of_two ? shrink_power(p, p->cells, *left, &page)
                                         : shrink_free(p, p->cells, *left, &page);
    } else if (status == AIR_OK && !p->params->power_of_two) {
        page = cropped(p, *left);
    }
    status = status == AIR_OK ? add_page(p, page) : status;
    if (status == AIR_OK) {
        keep_places(p, p->cells, *left, number, spare);
        *left -= placed;
    }
    return status;
}

static void finish_result(air_context *context, air_pack *result)
{
    air_free(context, result->pages);
    air_free(context, result->places);
    *result = (air_pack){.places = NULL};
}

static air_status arrange(packing *p, arrangement how, double scale, cell *spare)
{
    size_t left = p->item_count;
    p->result = (air_pack){.item_count = p->item_count, .scale = scale};
    p->result.places = air_allocate(p->context, p->item_count, sizeof *p->result.places);
    air_status status = p->result.places != NULL ? AIR_OK : AIR_ERROR_MEMORY;
    make_cells(p, how, scale);
    while (left > 0 && status == AIR_OK) {
        status = fill_page(p, &left, spare);
    }
    return status;
}

static double page_area(const air_pack *pack)
{
    double sum = 0.0;
    for (size_t i = 0; i < pack->page_count; i++) {
        sum += (double)pack->pages[i].width * (double)pack->pages[i].height;
    }
    return sum;
}

static bool is_better(const air_pack *a, const air_pack *b)
{
    return a->page_count < b->page_count ||
           (a->page_count == b->page_count && page_area(a) < page_area(b));
}

/* The best arrangement into *out. */
static air_status arrange_all(packing *p, double scale, cell *spare, air_pack *out)
{
    for (int how = 0; how < ARRANGEMENT_COUNT; how++) {
        const air_status status = arrange(p, (arrangement)how, scale, spare);
        if (status != AIR_OK || (how > 0 && !is_better(&p->result, out))) {
            finish_result(p->context, &p->result);
        } else {
            finish_result(p->context, out);
            *out = p->result;
        }
        if (status != AIR_OK) {
            return status;
        }
    }
    const double area = page_area(out);
    double used = 0.0;
    for (size_t i = 0; i < out->item_count; i++) {
        used += (double)out->places[i].width * (double)out->places[i].height;
    }
    out->utilisation = area > 0.0 ? used / area : 0.0;
    return AIR_OK;
}

/* ---- scaling ---- */

static air_status fits_one_page(packing *p, double scale, bool *out_fits)
{
    const air_pack_page page = {p->side, p->side};
    *out_fits = false;
    for (int how = 0; how < ARRANGEMENT_COUNT && !*out_fits; how++) {
        size_t placed;
        make_cells(p, (arrangement)how, scale);
        const air_status status = try_page(p, p->cells, p->item_count, page, &placed);
        if (status != AIR_OK) {
            return status;
        }
        *out_fits = placed == p->item_count;
    }
    return AIR_OK;
}

/* The largest scale found that fits, to a thousandth: 1, or by halving intervals. */
static air_status find_scale(packing *p, double most, double *out_scale)
{
    double low = 0.0, high = most;
    bool fits;
    air_status status = fits_one_page(p, most, &fits);
    if (status == AIR_OK && fits) {
        *out_scale = most;
        return AIR_OK;
    }
    status = status == AIR_OK ? fits_one_page(p, 0.0, &fits) : status;
    if (status == AIR_OK && !fits) {
        return air_fail(p->context, AIR_ERROR_ARGUMENT,
                        "pack: %zu items of one texel with a padding of %u do not fit a page of "
                        "%u x %u texels",
                        p->item_count, p->params->padding, p->side, p->side);
    }
    while (status == AIR_OK && high > 1.001 * low && high > 1e-12) {
        const double middle = 0.5 * (low + high);
        status = fits_one_page(p, middle, &fits);
        low = fits ? middle : low;
        high = fits ? high : middle;
    }
    *out_scale = low;
    return status;
}

/* ---- all of it ---- */

/* The largest side of an item in texels, with its padding. */
static double needed_by(const air_pack_item *item, uint32_t padding)
{
    const double longer = double_max(item->size[0], item->size[1]);
    return double_max(ceil(longer - 1e-6), 1.0) + 2.0 * (double)padding;
}

static air_status check(air_context *context, const packing *p, double *out_largest)
{
    const air_pack_params *params = p->params;
    if (params->max_size < 1 || params->max_size > 65536 || params->max_pages < 1 ||
        params->padding > 1024 || 2 * params->padding >= p->side || p->item_count > INT32_MAX) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "pack: %zu items, pages of %u texels, %zu at most, padding %u: expected "
                        "1 to 65536 texels, at least one page and room between the paddings",
                        p->item_count, params->max_size, params->max_pages, params->padding);
    }
    *out_largest = 0.0;
    for (size_t i = 0; i < p->item_count; i++) {
        const air_pack_item *item = &p->items[i];
        if (!(item->size[0] > 0.0 && item->size[1] > 0.0) ||
            !isfinite(item->size[0] + item->size[1])) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "pack: item %zu: size %g x %g: expected positive numbers", i,
                            item->size[0], item->size[1]);
        }
        const double needed = needed_by(item, params->padding);
        if (needed > (double)p->side && !params->scale_to_fit) {
            return air_fail(context, AIR_ERROR_ARGUMENT,
                            "pack: item %zu of %.0f x %.0f texels needs a page of at least %.0f "
                            "texels with its padding; pages have at most %u",
                            i, ceil(item->size[0]), ceil(item->size[1]), needed, p->side);
        }
        *out_largest = double_max(*out_largest, double_max(item->size[0], item->size[1]));
    }
    return AIR_OK;
}

/* With powers of two, the one below. */
static uint32_t side_of(const air_pack_params *params)
{
    uint32_t side = params->max_size;
    while (params->power_of_two && (side & (side - 1)) != 0) {
        side &= side - 1;
    }
    return side;
}

static air_status pack_all(packing *p, double largest, air_pack *out)
{
    cell *spare = air_allocate(p->context, p->item_count, sizeof *spare);
    double scale = 1.0;
    air_status status = AIR_OK;
    p->cells = air_allocate(p->context, p->item_count, sizeof *p->cells);
    p->rectangles = air_allocate(p->context, p->item_count, sizeof *p->rectangles);
    if (spare == NULL || p->cells == NULL || p->rectangles == NULL) {
        status = AIR_ERROR_MEMORY;
    }
    if (status == AIR_OK && p->params->scale_to_fit && p->item_count > 0) {
        const double room = (double)(p->side - 2 * p->params->padding);
        status = find_scale(p, double_min(1.0, room / largest), &scale);
    }
    status = status == AIR_OK ? arrange_all(p, scale, spare, out) : status;
    air_free(p->context, p->rectangles);
    air_free(p->context, p->cells);
    air_free(p->context, spare);
    return status;
}

air_status air_pack_create(air_context *context, const air_pack_item *items, size_t item_count,
                           const air_pack_params *params, air_pack **out_pack)
{
    packing p = {.context = context,
                 .items = items,
                 .item_count = item_count,
                 .params = params,
                 .side = side_of(params)};
    double largest = 0.0;
    *out_pack = NULL;
    air_status status = check(context, &p, &largest);
    if (status != AIR_OK) {
        return status;
    }
    air_pack *self = air_allocate(context, 1, sizeof *self);
    status = self != NULL ? pack_all(&p, largest, self) : AIR_ERROR_MEMORY;
    if (status == AIR_OK && self->page_count > params->max_pages) {
        status = air_fail(context, AIR_ERROR_ARGUMENT,
                          "pack: %zu items need %zu pages of %u texels: expected at most %zu",
                          item_count, self->page_count, p.side, params->max_pages);
    }
    if (status != AIR_OK) {
        air_pack_destroy(context, self);
        return status == AIR_ERROR_MEMORY ? air_fail_memory(context, "pack") : status;
    }
    *out_pack = self;
    return AIR_OK;
}

void air_pack_destroy(air_context *context, air_pack *self)
{
    if (self != NULL) {
        finish_result(context, self);
        air_free(context, self);
    }
}

void air_pack_point(const air_pack *pack, size_t item, const double point[2], double out[2])
{
    const air_pack_place *place = &pack->places[item];
    const double x = point[0] * pack->scale, y = point[1] * pack->scale;
    out[0] = (double)place->x + (place->turned ? y : x);
    out[1] = (double)place->y + (place->turned ? (double)place->height - x : y);
}
