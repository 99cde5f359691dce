#include "image/film_share.h"

#include <string.h>

#include "airlight/denoise.h"

static const air_film_slot *find_slot(const air_film *film, const char *name)
{
    for (uint32_t s = 0; s < film->layout.slot_count; s++) {
        if (strcmp(film->layout.slots[s].name, name) == 0) {
            return &film->layout.slots[s];
        }
    }
    return NULL;
}

/* The mean over samples of one sum, as a plane. */
static void fill_plane(const air_film *film, uint32_t offset, double samples, float *out)
{
    const uint32_t stride = film->layout.stride;
    for (size_t p = 0; p < air_film_pixel_count(film); p++) {
        double sum = 0.0;
        for (size_t n = 0; n < film->node_count; n++) {
            sum += film->nodes[n].sums[p * stride + offset];
        }
        out[p] = (float)(sum / samples);
    }
}

/* A sum of the first pixel's, which is the same for all. */
static double sample_total(const air_film *film, uint32_t offset)
{
    double sum = 0.0;
    for (size_t n = 0; n < film->node_count; n++) {
        sum += film->nodes[n].sums[offset];
    }
    return sum;
}

static air_status smooth(const air_film *film, air_film_shares *shares, double samples,
                         float *guides)
{
    const size_t pixels = shares->pixels;
    const air_film_slot *depth = find_slot(film, "depth"), *normal = find_slot(film, "normal");
    air_denoise_guides seen = {air_film_width(film), air_film_height(film), NULL, {NULL}, NULL};
    if (depth != NULL) {
        fill_plane(film, depth->offset, samples, guides);
        seen.depth = guides;
    }
    air_status status = AIR_OK;
    size_t next = 0;
    for (uint32_t s = 0; s < film->layout.slot_count && status == AIR_OK; s++) {
        const air_film_slot *slot = &film->layout.slots[s];
        float *planes[6];
        if (slot->kind != AIR_SLOT_SHARE) {
            continue;
        }
        const bool on_surfaces = strcmp(slot->name, "S0") == 0 && normal != NULL;
        for (uint32_t c = 0; c < 3; c++) {
            float *plane = guides + (c + 1) * pixels;
            seen.normal[c] = on_surfaces ? plane : NULL;
            if (on_surfaces) {
                fill_plane(film, normal->offset + c, samples, plane);
            }
        }
        for (uint32_t k = 0; k < 6; k++) { /* sums 6, 7, 8 are O, 3, 4, 5 are U */
            planes[k] = shares->planes + (6 * next + k) * pixels;
            fill_plane(film, slot->offset + (k < 3 ? 6 + k : k), samples, planes[k]);
        }
        status = air_denoise_shares(film->context, &seen, sample_total(film, slot->offset + 12),
                                    planes + 3, planes, 3);
        next++;
    }
    return status;
}

air_status air_film_shares_init(air_film_shares *shares, const air_film *film, double samples)
{
    size_t slots = 0;
    *shares = (air_film_shares){film->context, air_film_pixel_count(film), NULL};
    for (uint32_t s = 0; s < film->layout.slot_count; s++) {
        slots += film->layout.slots[s].kind == AIR_SLOT_SHARE;
    }
    if (slots == 0) {
        return AIR_OK;
    }
    float *guides = air_allocate(film->context, 4 * shares->pixels, sizeof *guides);
    shares->planes = air_allocate(film->context, 6 * slots * shares->pixels, sizeof(float));
    air_status status = guides == NULL || shares->planes == NULL
                            ? air_fail_memory(film->context, "resolving the film")
                            : smooth(film, shares, samples, guides);
    air_free(film->context, guides);
    if (status != AIR_OK) {
        air_film_shares_finish(shares);
    }
    return status;
}

void air_film_shares_finish(air_film_shares *shares)
{
    air_free(shares->context, shares->planes);
    shares->planes = NULL;
}
