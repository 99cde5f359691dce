/* check.h: is a lightmap what airlight/lightmap.h says? */
#ifndef AIR_LIGHTMAP_CHECK_H
#define AIR_LIGHTMAP_CHECK_H

#include "airlight/lightmap.h"
#include "core/host.h"

/* Colours of a layer, "R", "G", "B". */
extern const char *const air_lightmap_colours[3];

/* Prefixes of directional light, in the order of y_lm: "L0", "L1.y", "L1.z", "L1.x". */
extern const char *const air_lightmap_bands[AIR_DIRECTIONAL_COEFFICIENTS];

/* All counts, indices, channels and numbers; the message begins with `file` and fails with `status`
 * (AIR_ERROR_ARGUMENT for what the caller made, AIR_ERROR_FORMAT for what a file held). */
air_status air_lightmap_check(air_context *context, const air_lightmap *lightmap, const char *file,
                              air_status status);

/* The planes "PREFIX.R", "PREFIX.G", "PREFIX.B" of an image (R, G, B for ""); false if one is
 * missing. */
bool air_lightmap_planes(const air_image *image, const char *prefix, const float *out[3]);

#endif
