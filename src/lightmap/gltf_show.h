/* gltf_show.h: pages as textures of a glTF file, and materials that show them. */
#ifndef AIR_LIGHTMAP_GLTF_SHOW_H
#define AIR_LIGHTMAP_GLTF_SHOW_H

#include "airlight/lightmap.h"
#include "lightmap/gltf_copy.h"

enum { AIR_GLTF_SET = 1 }; /* lightmaps lie in TEXCOORD_1 */

/* A page as it is written. */
typedef struct air_gltf_page {
    air_sink png;
    float peak;      /* W/(m^2 sr) of a texel that is white */
    bool has_albedo; /* the page is multiplied by it */
    size_t clipped;  /* texels that are brighter */
    size_t texture;  /* index */
} air_gltf_page;

/* A copy of a material for one page. */
typedef struct air_gltf_material {
    size_t source; /* SIZE_MAX: the default material */
    size_t page;
    size_t moved; /* the set where its own TEXCOORD_1 went; AIR_GLTF_SET: nowhere */
    size_t index; /* of the copy */
} air_gltf_material;

typedef struct air_gltf_show {
    air_gltf_copy *copy;
    const air_lightmap *lightmap;
    air_lightmap_gltf_params params;
    air_gltf_page *pages;
    air_gltf_material *materials;
    size_t material_count, material_capacity;
    bool guessed; /* a texture of the base colour or of metal was not taken into account */
} air_gltf_show;

/* Encodes all pages and adds their textures. stem: NULL to embed the pictures, else they are files
 * STEM-lightmap-0.png, ... Finish also after a failure. */
air_status air_gltf_show_begin(air_gltf_show *self, const char *stem);
void air_gltf_show_finish(air_gltf_show *self);

/* Does a material (SIZE_MAX: the default one) show a lightmap? It does not if it emits, or is
 * unlit. */
air_status air_gltf_show_wanted(const air_gltf_show *self, size_t material, bool *out_wanted);
/* Does it use the set of coordinates that the lightmap takes? */
bool air_gltf_show_uses_set(const air_gltf_show *self, size_t material);
/* The copy of a material that shows a page (COORDINATES: whose set 1 has moved). */
air_status air_gltf_show_material(air_gltf_show *self, size_t material, size_t page, size_t moved,
                                  size_t *out_index);

#endif
