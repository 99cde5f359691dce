/* draw_tile_avx2.c: tiles of draws for AVX2. */
#include "collimated/draw_tile.h"

void air_draw_tile_avx2(air_collimated_estimator estimator, const air_collimated_profile *profile,
                        air_draw_tile *tile)
{
    air_draw_all(estimator, profile, tile);
}
