/* film_resolve.c: from raw sums to a picture: the only place that divides. */
#include <string.h>

#include "image/film.h"
#include "image/film_share.h"

void air_resolve_params_default(air_resolve_params *params)
{
    params->layers = params->guides = params->variance = params->smooth = true;
}

static const char *const beauty_channels[3] = {"R", "G", "B"};

static const char *channel_suffix(const air_film_slot *slot, uint32_t c)
{
    static const char *const position[3] = {"X", "Y", "Z"};
    if (slot->kind == AIR_SLOT_GUIDE && slot->components == 1) {
        return "Z";
    }
    return strcmp(slot->name, "normal") == 0 ? position[c % 3] : beauty_channels[c % 3];
}

static bool shown(const air_film_slot *slot, const air_resolve_params *params)
{
    switch (slot->kind) {
    case AIR_SLOT_TERM:
    case AIR_SLOT_RATIO:
    case AIR_SLOT_SHARE:
        return params->layers && strcmp(slot->name, "beauty") != 0;
    case AIR_SLOT_GUIDE:
        return params->guides;
    case AIR_SLOT_SQUARES:
        return params->variance;
    }
    return false;
}

static uint32_t shown_components(const air_film_slot *slot)
{
    return air_slot_is_ratio(slot->kind) ? 3 : slot->components;
}

/* Creates the image with all channels: beauty, then those of the slots shown, in order. */
static air_status create_image(const air_film *film, const air_resolve_params *params,
                               air_image **out_image)
{
    enum { MAX_CHANNELS = 3 + 9 * AIR_FILM_MAX_SLOTS, NAME = AIR_FILM_NAME + 4 };
    char names[MAX_CHANNELS][NAME];
    const char *pointers[MAX_CHANNELS];
    size_t count = 0;
    for (; count < 3; count++) {
        strcpy(names[count], beauty_channels[count]);
    }
    for (uint32_t s = 0; s < film->layout.slot_count; s++) {
        const air_film_slot *slot = &film->layout.slots[s];
        for (uint32_t c = 0; shown(slot, params) && c < shown_components(slot); c++, count++) {
            strcpy(names[count], slot->name);
            strcat(names[count], ".");
            strcat(names[count], channel_suffix(slot, c));
        }
    }
    for (size_t i = 0; i < count; i++) {
        pointers[i] = names[i];
    }
    return air_image_create(film->context, air_film_width(film), air_film_height(film), count,
                            pointers, out_image);
}

static void total_pixel(const air_film *film, size_t pixel, double *out)
{
    const uint32_t stride = film->layout.stride;
    memset(out, 0, stride * sizeof *out);
    for (size_t n = 0; n < film->node_count; n++) {
        for (uint32_t k = 0; k < stride; k++) {
            out[k] += film->nodes[n].sums[pixel * stride + k];
        }
    }
}

static double sample_count(const air_film *film)
{
    double count = 0.0;
    for (size_t n = 0; n < film->node_count; n++) {
        count += film->nodes[n].end - film->nodes[n].begin;
    }
    return count;
}

/* Puts the smoothed visible shares in the place of the pixel's own: what is left of O / U counts.
 */
static void set_shares(const air_film *film, const air_film_shares *shares, size_t pixel,
                       double *sums)
{
    size_t next = 0;
    for (uint32_t s = 0; s < film->layout.slot_count; s++) {
        const air_film_slot *slot = &film->layout.slots[s];
        if (slot->kind != AIR_SLOT_SHARE) {
            continue;
        }
        for (uint32_t c = 0; c < 3; c++) {
            const float *planes = shares->planes + 6 * next * shares->pixels + pixel;
            const double o = (double)planes[c * shares->pixels];
            const double u = (double)planes[(3 + c) * shares->pixels];
            /* where no sample brought anything, nothing is known to be in the way */
            sums[slot->offset + 6 + c] = u > 0.0 ? o : 1.0;
            sums[slot->offset + 3 + c] = u > 0.0 ? u : 1.0;
        }
        next++;
    }
}

/* One component of a slot that is part of beauty. */
static double mean(const air_film_slot *slot, const double *sums, uint32_t c, double count)
{
    const double *s = sums + slot->offset;
    if (air_slot_is_ratio(slot->kind)) {
        return air_ratio_total(s, c) / count;
    }
    return s[c] / count;
}

static double beauty(const air_film *film, const double *sums, uint32_t c, double count)
{
    double sum = 0.0;
    for (uint32_t s = 0; s < film->layout.slot_count; s++) {
        const air_film_slot *slot = &film->layout.slots[s];
        if (slot->kind == AIR_SLOT_TERM || air_slot_is_ratio(slot->kind)) {
            sum += mean(slot, sums, c, count);
        }
    }
    return sum;
}

/* Of the mean over R replicates of n samples each: sum of squared deviations of their means over R
 * (R - 1). */
static double variance(const air_film *film, const air_film_slot *slot, const double *sums,
                       uint32_t c, double count)
{
    const double n = film->replicate_size, replicates = count / n;
    const double centre = beauty(film, sums, c, count);
    const double squares = sums[slot->offset + c] / (n * n) - replicates * centre * centre;
    return squares > 0.0 ? squares / (replicates * (replicates - 1.0)) : 0.0;
}

static void resolve_pixel(const air_film *film, const air_resolve_params *params,
                          const air_film_shares *shares, size_t pixel, double *sums, double count,
                          air_image *image)
{
    size_t channel = 0;
    total_pixel(film, pixel, sums);
    if (shares->planes != NULL) {
        set_shares(film, shares, pixel, sums);
    }
    for (uint32_t c = 0; c < 3; c++) {
        air_image_plane(image, channel++)[pixel] = (float)beauty(film, sums, c, count);
    }
    for (uint32_t s = 0; s < film->layout.slot_count; s++) {
        const air_film_slot *slot = &film->layout.slots[s];
        for (uint32_t c = 0; shown(slot, params) && c < shown_components(slot); c++) {
            const double value = slot->kind == AIR_SLOT_SQUARES
                                     ? variance(film, slot, sums, c, count)
                                     : mean(slot, sums, c, count);
            air_image_plane(image, channel++)[pixel] = (float)value;
        }
    }
}

air_status air_film_resolve(const air_film *film, const air_resolve_params *params,
                            air_image **out_image)
{
    air_resolve_params defaults;
    const double count = sample_count(film);
    air_image *image = NULL;
    double *sums = NULL;
    *out_image = NULL;
    if (params == NULL) {
        air_resolve_params_default(&defaults);
        params = &defaults;
    }
    if (count == 0.0) {
        return air_fail(film->context, AIR_ERROR_ARGUMENT, "the film holds no samples");
    }
    air_status status = create_image(film, params, &image);
    for (size_t i = 0; i < film->attribute_count && status == AIR_OK; i++) {
        status =
            air_image_set_attribute(image, film->attributes[i].name, film->attributes[i].value);
    }
    if (status == AIR_OK) {
        sums = air_allocate(film->context, film->layout.stride, sizeof *sums);
        status = sums == NULL ? air_fail_memory(film->context, "resolving the film") : AIR_OK;
    }
    air_film_shares shares = {.context = film->context};
    if (status == AIR_OK && params->smooth) {
        status = air_film_shares_init(&shares, film, count);
    }
    if (status != AIR_OK) {
        air_free(film->context, sums);
        air_image_destroy(image);
        return status;
    }
    for (size_t pixel = 0; pixel < air_film_pixel_count(film); pixel++) {
        resolve_pixel(film, params, &shares, pixel, sums, count, image);
    }
    air_film_shares_finish(&shares);
    air_free(film->context, sums);
    *out_image = image;
    return AIR_OK;
}
