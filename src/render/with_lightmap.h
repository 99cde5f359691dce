/* with_lightmap.h: baked light instead of traced light: S0 and S+ of the surfaces a camera sees.
 *
 * What a surface sends is its albedo towards the camera times irradiance / pi: light comes as if
 * evenly from all sides, so highlights are those of an even sky. The front of a surface shows what
 * was baked; the back shows it too where the material is double-sided, else nothing. */
#ifndef AIR_RENDER_WITH_LIGHTMAP_H
#define AIR_RENDER_WITH_LIGHTMAP_H

#include "airlight/lightmap.h"
#include "path/path.h"

typedef struct air_with_lightmap air_with_lightmap;

/* The terms that are taken from a lightmap where there is one. */
static inline uint32_t air_lightmap_terms(const air_lightmap *lightmap)
{
    return lightmap != NULL ? 1u << AIR_TERM_S0 | 1u << AIR_TERM_S_PLUS : 0u;
}

/* Checks that the lightmap is one of this scene and gets it ready; *out is NULL where there is none
 * or neither of its terms is wanted. Warns, once, of meshes that it does not light. The path, its
 * snapshot and the lightmap must outlive it. AIR_ERROR_ARGUMENT: the lightmap is broken or another
 * scene's; the message names the mesh and both files. */
air_status air_with_lightmap_create(const air_path *path, const air_lightmap *lightmap,
                                    uint32_t terms, air_with_lightmap **out);
void air_with_lightmap_destroy(air_with_lightmap *with); /* NULL is legal */

/* Adds to a hash what the picture depends on. */
uint64_t air_with_lightmap_fingerprint(const air_with_lightmap *with, uint64_t hash);

/* Adds the terms of count lanes that air_path_trace has traced. */
void air_with_lightmap_add(const air_with_lightmap *with, air_path_scratch *scratch,
                           air_path_lane *lanes, size_t count);

#endif
