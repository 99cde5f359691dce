/* pattern.c: numbers of samples, and the blue-noise tile. */
#include "core/pattern.h"

#include <stdbool.h>
#include <stddef.h>

#include "core/sobol.h"

enum { SIDE = AIR_TILE_SIDE, PIXELS = AIR_TILE_PIXELS, TILE_BITS = 12 };

/* ---- the tile ---- */

/* Binary pictures are ranked by how crowded their pixels are: the sum over the set pixels of a
 * Gaussian (4/5)^(d^2) of the distance d on the torus, standard deviation 1.497 ([Ulichney1993]
 * uses 1.5). Sums of integers: ties are ties everywhere and removing undoes adding. In steps of
 * 2^-24 nothing is left of it at distance 9, and sums are below 14.1 x 2^24, so they fit. */
enum { REACH = 8, WIDTH = 2 * REACH + 1 };

typedef struct crowd {
    uint32_t density[PIXELS];
    uint32_t set[PIXELS]; /* 0 or ~0 */
    uint32_t kernel[WIDTH][WIDTH];
} crowd;

static void make_kernel(uint32_t kernel[WIDTH][WIDTH])
{
    double row[WIDTH], value = 1.0, step = 0.8; /* (4/5)^(d^2) grows by (4/5)^(2d + 1) */
    for (int d = 0; d <= REACH; d++) {
        row[REACH + d] = row[REACH - d] = value;
        value *= step;
        step *= 0.8 * 0.8;
    }
    for (int y = 0; y < WIDTH; y++) {
        for (int x = 0; x < WIDTH; x++) {
            kernel[y][x] = (uint32_t)(row[y] * row[x] * 0x1p24);
        }
    }
}

static void toggle(crowd *self, int at)
{
    self->set[at] = ~self->set[at];
    for (int y = 0; y < WIDTH; y++) {
        uint32_t *row = self->density + SIDE * ((at / SIDE + y - REACH) & (SIDE - 1));
        for (int x = 0; x < WIDTH; x++) {
            const uint32_t weight = self->kernel[y][x];
            row[(at % SIDE + x - REACH) & (SIDE - 1)] += self->set[at] != 0 ? weight : 0u - weight;
        }
    }
}

/* The density of a set pixel, or the emptiness of one that is not; 0 for the others, which loses to
 * all: densities of set pixels are at least 2^24, all are below 2^28. */
static uint32_t rank_key(const crowd *self, uint32_t flip, int i)
{
    return (self->density[i] ^ flip) & (self->set[i] ^ flip);
}

/* The most crowded set pixel, or the least crowded one that is not set; the first of equals. */
static int extreme(const crowd *self, bool set)
{
    const uint32_t flip = set ? 0u : ~0u;
    uint32_t best = 0;
    int at = 0;
    for (int i = 0; i < PIXELS; i++) {
        const uint32_t key = rank_key(self, flip, i);
        best = key > best ? key : best;
    }
    while (rank_key(self, flip, at) != best) {
        at++;
    }
    return at;
}

/* About a tenth of the pixels at random, moved from clusters into voids until that changes nothing.
 */
static int make_seeds(crowd *self)
{
    int count = 0;
    for (uint32_t i = 0; i < PIXELS / 10; i++) {
        const int at = (int)(air_hash32(i + 1) % PIXELS);
        if (self->set[at] == 0) {
            toggle(self, at);
            count++;
        }
    }
    for (;;) {
        const int cluster = extreme(self, true);
        toggle(self, cluster);
        const int hole = extreme(self, false);
        toggle(self, hole);
        if (hole == cluster) {
            return count;
        }
    }
}

/* Ranks below those of the seeds go to the seeds, from the tightest cluster downwards; ranks above
 * to the largest void each time. (Clusters of pixels that are not set are voids of those that are:
 * the densities of both add to a constant. So the paper's last two phases are one.) */
void air_blue_noise_init(air_blue_noise *tile)
{
    crowd now = {0}, seeds;
    make_kernel(now.kernel);
    const int count = make_seeds(&now);
    seeds = now;
    for (int rank = count - 1; rank >= 0; rank--) {
        const int at = extreme(&now, true);
        toggle(&now, at);
        tile->rank[at] = (uint16_t)rank;
    }
    for (int rank = count; rank < PIXELS; rank++) {
        const int at = extreme(&seeds, false);
        toggle(&seeds, at);
        tile->rank[at] = (uint16_t)rank;
    }
}

/* ---- samples ---- */

/* The tile's rank below the first log2_count bits, which are chance: the 2^log2_count samples do
 * not depend on them. The seed moves the tile. */
static uint32_t blue_offset(const air_pattern_source *source, uint32_t x, uint32_t y, uint32_t hash)
{
    const uint32_t move = air_hash32(source->seed);
    const uint32_t at = (y + move / SIDE) % SIDE * SIDE + (x + move) % SIDE;
    const uint32_t m = source->log2_count < 32 - TILE_BITS ? source->log2_count : 32 - TILE_BITS;
    const uint32_t mask = (uint32_t)((PIXELS - 1ull) << (32 - TILE_BITS) >> m);
    const uint32_t rank = (uint32_t)source->tile->rank[at] << (32 - TILE_BITS) >> m;
    return (hash & ~mask) | rank;
}

double air_pattern_get(const air_pattern_source *source, uint32_t x, uint32_t y, uint32_t index)
{
    const uint32_t hash = air_hash_combine(air_hash_combine(air_hash32(source->seed), x), y);
    uint32_t bits = 0;
    switch (source->pattern) {
    case AIR_PATTERN_STRATIFIED:
        bits = air_reverse_bits(air_owen_reversed(index, hash));
        break;
    case AIR_PATTERN_SYSTEMATIC:
        bits = air_reverse_bits(index) + hash;
        break;
    case AIR_PATTERN_BLUE_NOISE:
        bits = air_reverse_bits(index) +
               (source->tile != NULL ? blue_offset(source, x, y, hash) : hash);
        break;
    case AIR_PATTERN_INDEPENDENT:
    default:
        bits = air_hash_combine(hash, index);
        break;
    }
    return bits * 0x1p-32;
}
