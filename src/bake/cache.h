/* cache.h: the light that media scatter towards surfaces, beyond what is asked for without bias:
 * one grid of incident radiance per medium, in harmonics of bands 0 to 2, filled once by `path`
 * with the real boundaries and occluders and looked up along the rays of the surfaces' walks.
 *
 * A grid point stands for the cell around it: its samples lie evenly in that cell, so that lamps
 * inside give what the cell has on average. Points inside of solid things are left out. */
#ifndef AIR_BAKE_CACHE_H
#define AIR_BAKE_CACHE_H

#include "bake/sites.h"

typedef struct air_light_cache air_light_cache;

enum { AIR_CACHE_SAMPLES_LEAST = 32, AIR_CACHE_SAMPLES_MOST = 1024 };

typedef struct air_light_cache_params {
    uint32_t resolution; /* points along the longest side of a medium, >= 2 */
    uint32_t samples;    /* of each point; 0: 32 to 1024, as the budget has them */
    double budget;       /* samples of all points together */
    uint32_t max_depth;  /* events, the point's own counted */
    uint32_t seed;
} air_light_cache_params;

/* Makes and fills the grids of all media of a snapshot. */
air_status air_light_cache_create(air_context *context, const air_snapshot *snapshot,
                                  const air_sobol *sobol, const air_light_cache_params *params,
                                  air_bake_progress *progress, double fraction_end,
                                  air_light_cache **out_cache);
void air_light_cache_destroy(air_light_cache *cache); /* NULL is legal */

/* air_path_source.scattered with the cache as user. */
air_vec3 air_light_cache_scattered(const void *cache, air_vec3 position, uint32_t medium,
                                   air_vec3 wo, bool lights);

/* Bytes held. */
size_t air_light_cache_bytes(const air_light_cache *cache);

#endif
