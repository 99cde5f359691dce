/* film_share.h: visible shares, smoothed. */
#ifndef AIR_IMAGE_FILM_SHARE_H
#define AIR_IMAGE_FILM_SHARE_H

#include "image/film.h"

/* Smoothed sums O and U of the film's slots of kind AIR_SLOT_SHARE: 6 planes per such slot, O then
 * U, in the order of the slots; none if there is no such slot. */
typedef struct air_film_shares {
    air_context *context;
    size_t pixels;
    float *planes;
} air_film_shares;

air_status air_film_shares_init(air_film_shares *shares, const air_film *film, double samples);
void air_film_shares_finish(air_film_shares *shares);

#endif
