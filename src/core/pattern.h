/* pattern.h: one number in [0, 1) for each sample of each pixel, in patterns that make averages
 * over a pixel, or over neighbouring pixels, converge faster than chance.
 *
 * Integer arithmetic throughout: the same bytes everywhere. Numbers are multiples of 2^-32. Thread-
 * safe. */
#ifndef AIR_CORE_PATTERN_H
#define AIR_CORE_PATTERN_H

#include <stdint.h>

#include "airlight/render.h"

enum { AIR_TILE_SIDE = 64, AIR_TILE_PIXELS = AIR_TILE_SIDE * AIR_TILE_SIDE };

/* Each number below AIR_TILE_PIXELS once, row by row, without low frequencies; seamless when tiled.
 */
typedef struct air_blue_noise {
    uint16_t rank[AIR_TILE_PIXELS];
} air_blue_noise;

/* Void and cluster [Ulichney1993]. Always the same tile; takes about 25 ms. */
void air_blue_noise_init(air_blue_noise *tile);

typedef struct air_pattern_source {
    air_pattern pattern;
    const air_blue_noise *tile; /* borrowed, for AIR_PATTERN_BLUE_NOISE; NULL there: systematic */
    uint32_t log2_count;        /* blue noise shows after 2^log2_count samples; at most 20 */
    uint32_t seed;
} air_pattern_source;

/* Every number by itself is uniform over seeds, so averages over any number of samples are
 * unbiased. */
double air_pattern_get(const air_pattern_source *source, uint32_t x, uint32_t y, uint32_t index);

#endif
