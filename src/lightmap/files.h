/* files.h: what the files of a lightmap's folder have in common (docs/lightmap-format.md). */
#ifndef AIR_LIGHTMAP_FILES_H
#define AIR_LIGHTMAP_FILES_H

#include "airlight/lightmap.h"
#include "image/staging.h"
#include "lightmap/place.h"

enum {
    AIR_LIGHTMAP_VERSION = 1,
    AIR_VERTEX_IMAGE_WIDTH = 1024, /* vertices per row of the images of vertex light */
    AIR_CUT_HEADER = 16            /* bytes: "airlight", version, number of meshes */
};

/* Little-endian, whatever the machine. */
static inline void air_put_u32(uint8_t bytes[4], uint32_t value)
{
    for (int i = 0; i < 4; i++) {
        bytes[i] = (uint8_t)(value >> (8 * i));
    }
}

static inline uint32_t air_get_u32(const uint8_t bytes[4])
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/* Real spherical harmonics without Condon-Shortley phase of a unit vector, index l^2 + l + m, l
 * <= 2. */
void air_lightmap_harmonics(const double direction[3], double out[AIR_PROBE_COEFFICIENTS]);

/* ---- vertex_image.c: vertex light as an image; vertex i at column i mod width ---- */

air_status air_vertex_light_to_image(air_context *context, const air_vertex_light *light,
                                     air_image **out_image);
/* Fills the layers from an image; light->vertex_count is known. what: the file, for messages. */
air_status air_vertex_light_from_image(air_context *context, const char *what,
                                       const air_image *image, air_vertex_light *light);

/* ---- probe_json.c ---- */

json_t *air_probe_sets_to_json(const air_lightmap *lightmap);
/* Fills lightmap->probe_sets. */
air_status air_probe_sets_from_json(const air_place *root, air_lightmap *lightmap);

#endif
