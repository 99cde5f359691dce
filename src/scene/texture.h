/* texture.h: textures: making them, and looking values up. */
#ifndef AIR_SCENE_TEXTURE_H
#define AIR_SCENE_TEXTURE_H

#include "scene/record.h"
#include "scene/snapshot.h"

typedef struct air_texture_record {
    air_record base;
    air_texture texture;
} air_texture_record;

/* Checks and copies a description. */
air_status air_texture_record_create(air_context *context, const air_texture_desc *desc,
                                     air_record **out_record);

/* The filtered RGBA value at (u, v), v running downwards, after the sRGB transfer where the texture
 * has it. One channel: grey; two: grey and alpha; alpha is 1 where there is none. */
void air_texture_lookup(const air_texture *texture, float u, float v, float out_rgba[4]);

/* Its RGB. */
air_vec3 air_texture_rgb(const air_texture *texture, float u, float v);

/* The value of texel (x, y) without filter or wrap, row 0 at the top. */
void air_texture_texel(const air_texture *texture, size_t x, size_t y, float out_rgba[4]);

/* The mean RGB over the triangle uv (already transformed), by a midpoint rule fine enough for the
 * texels it covers, up to 4096 points: a weight to sample by, not a radiance to shade with. */
air_vec3 air_texture_triangle_mean(const air_texture *texture, const float uv[3][2]);

/* (u, v) through the map of a slot. */
static inline void air_texture_slot_uv(const air_texture_slot *slot, const float uv[2],
                                       float out_uv[2])
{
    const float *m = slot->uv_transform;
    const float u = m[0] * uv[0] + m[1] * uv[1] + m[2];
    out_uv[1] = m[3] * uv[0] + m[4] * uv[1] + m[5];
    out_uv[0] = u;
}

#endif
