/* draw_tile_avx512.c: tiles of draws for AVX-512. */
#include "collimated/draw_tile.h"

void air_draw_tile_avx512(air_collimated_estimator estimator, const air_collimated_profile *profile,
                          air_draw_tile *tile)
{
    air_draw_all(estimator, profile, tile);
}
