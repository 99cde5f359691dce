/* lightmap.h: baked light: what it consists of, its files, and its forms for engines.
 *
 * A lightmap is what `airlight bake` makes: irradiance on surfaces in atlas pages, light of
 * vertices and of probes. Each is kept in three layers that add up: light straight from emitters,
 * light by way of surfaces, and what media scatter (docs/baking.md).
 *
 * Units: pages and vertices hold irradiance, W/m^2 of each channel, of the side the vertex normals
 * point to; probes hold the incident radiance, W/(m^2 sr), as coefficients of real spherical
 * harmonics without Condon-Shortley phase, index l^2 + l + m. All numbers are linear Rec. 709.
 *
 * A lightmap may be read from several threads at once, edited from one. Functions that write return
 * AIR_ERROR_ARGUMENT for one that is not what is said here (the message names what is wrong), and
 * AIR_ERROR_IO where a file cannot be written; then no file under a final name has changed. */
#ifndef AIRLIGHT_LIGHTMAP_H
#define AIRLIGHT_LIGHTMAP_H

#include "airlight/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum air_light_layer {
    AIR_LAYER_DIRECT = 0,   /* from emitters, attenuated by media on the way */
    AIR_LAYER_INDIRECT = 1, /* by way of surfaces, attenuated likewise */
    AIR_LAYER_MEDIA = 2,    /* scattered by media at least once */
    AIR_LAYER_COUNT = 3
} air_light_layer;
/* "direct", "indirect", "media" */
AIR_API const char *air_light_layer_name(air_light_layer layer);

enum { AIR_PROBE_COEFFICIENTS = 9, AIR_DIRECTIONAL_COEFFICIENTS = 4 };

/* A mesh's place in the atlas. */
typedef struct air_lightmap_mesh {
    char *name;
    uint32_t mesh;     /* index among the snapshot's meshes */
    int32_t node;      /* where a glTF file has it: node and primitive of that node's mesh; -1 if */
    int32_t primitive; /* it came from elsewhere */
    int32_t page;      /* -1: not in the atlas */
    float scale[2]; /* page coordinates = uv * scale + offset, v downwards, 0 to 1 over the page */
    float offset[2];
    /* The mesh cut for the atlas; all NULL and 0 where the mesh's own TEXCOORD_1 serve. Vertex i is
     * the mesh's vertex sources[i] with lightmap coordinates uv[2 i], uv[2 i + 1]. */
    size_t vertex_count, triangle_count;
    uint32_t *sources;
    float *uv;
    uint32_t *indices; /* 3 per triangle, triangles in the mesh's order */
} air_lightmap_mesh;

/* Light of the vertices of one mesh. */
typedef struct air_vertex_light {
    uint32_t mesh;
    int32_t node, primitive;
    char *name;
    size_t vertex_count;
    float *layers[AIR_LAYER_COUNT]; /* 3 per vertex */
} air_vertex_light;

/* Probes. Those of a grid lie at origin + i step[0] + j step[1] + k step[2], i fastest. */
typedef struct air_probe_set {
    char *name;
    size_t count;
    float *positions;               /* 3 per probe */
    float *layers[AIR_LAYER_COUNT]; /* per probe 9 coefficients of 3 channels */
    float *validity;                /* [0, 1]: share of what a probe sees that is no back face */
    bool grid;
    size_t size[3]; /* size[0] * size[1] * size[2] == count */
    float origin[3], step[3][3];
} air_probe_set;

typedef struct air_lightmap {
    /* Pages. Channels of each: R, G, B (the sum of the layers), then "direct.R", ..., "indirect.R",
     * ..., "media.R", ...; where known "albedo.R", ... (means of the diffuse albedo); with
     * directional light "L1.y.R", "L1.z.R", "L1.x.R", ... (the coefficients 1, 2 and 3 of the
     * incident radiance of all layers together; in front of them, "L0.R", ...); and "coverage.Y":
     * share of the texel that is covered, 0 where only dilated. Rows from the top, v = 0. */
    size_t page_count;
    air_image **pages;
    size_t mesh_count;
    air_lightmap_mesh *meshes;
    size_t vertex_light_count;
    air_vertex_light *vertex_lights;
    size_t probe_set_count;
    air_probe_set *probe_sets;
    bool directional;
    bool photometric; /* the scene's lights were photometric: 683 lm/W lead back to lux and nits */
    char *scene;      /* path of the scene, as given */
    char *media;      /* "none", "attenuate", "impulse", "exact", "reference" */
    struct air_context *context;
} air_lightmap;

/* An empty lightmap: no pages, no meshes, media "none", scene "". What is hung into it later must
 * come from the context's allocator, pages from air_image_create. On failure *out_lightmap is NULL.
 */
AIR_API air_status air_lightmap_create(air_context *context, air_lightmap **out_lightmap);
/* Frees all that it points to, and itself. NULL is legal. */
AIR_API void air_lightmap_destroy(air_lightmap *lightmap);

/* ---- files: a folder with lightmap.json, page-0.exr ..., cuts.bin, vertices-0.exr ...,
 * probes.json: docs/lightmap-format.md ---- */

typedef struct air_lightmap_save_params {
    bool half; /* pages in 16-bit floats; default true */
} air_lightmap_save_params;
AIR_API void air_lightmap_save_params_default(air_lightmap_save_params *params);

/* Writes into `folder`, which is created where it is missing. lightmap.json comes last, so a folder
 * that has it is whole; files of an earlier bake in the same folder are replaced. */
AIR_API air_status air_lightmap_save(air_context *context, const air_lightmap *lightmap,
                                     const char *folder, const air_lightmap_save_params *params);
/* Reads such a folder through the context's reader. AIR_ERROR_IO: a file is missing;
 * AIR_ERROR_FORMAT: anything is not as docs/lightmap-format.md says; the message names file and
 * place. On failure *out_lightmap is NULL. */
AIR_API air_status air_lightmap_load(air_context *context, const char *folder,
                                     air_lightmap **out_lightmap);

/* ---- for engines: docs/lightmap-engines.md ---- */

/* EMISSIVE: the surface sends out what it reflects: base colour black, emission = albedo x
 * irradiance / pi, by the pages' albedo.R, .G, .B where they have them, else by the material's base
 * colour factor. Every viewer shows it. LIGHTMAP: the material stays and gets MOZ_lightmap,
 * irradiance in lux. COORDINATES: nothing is shown, only TEXCOORD_1 are there, for an engine that
 * brings the pages in. */
typedef enum air_lightmap_show {
    AIR_SHOW_EMISSIVE = 0,
    AIR_SHOW_LIGHTMAP = 1,
    AIR_SHOW_COORDINATES = 2
} air_lightmap_show;

typedef struct air_lightmap_gltf_params {
    air_lightmap_show show; /* default AIR_SHOW_EMISSIVE */
    float scale;      /* of all light, positive and finite; default 1: the scene's own units */
    bool keep_lights; /* LIGHTMAP: punctual lights stay, though they are baked; default false */
} air_lightmap_gltf_params;
AIR_API void air_lightmap_gltf_params_default(air_lightmap_gltf_params *params);

/* A copy of the glTF scene that was baked, with the lightmap in it: meshes cut for the atlas where
 * it says so, TEXCOORD_1 in page coordinates, a texture for each page, materials that show it.
 * Surfaces that emit (EMISSIVE) or are unlit stay as they are. path ends in .glb (all in one) or
 * .gltf (with NAME.bin and NAME-lightmap-0.png, ... beside). Whatever else the scene has is kept.
 * params NULL: the defaults. AIR_ERROR_FORMAT: the scene is not the one that was baked;
 * AIR_ERROR_UNSUPPORTED: geometry compressed by KHR_draco_mesh_compression or
 * EXT_meshopt_compression. */
AIR_API air_status air_lightmap_save_gltf(air_context *context, const air_lightmap *lightmap,
                                          const char *scene_path, const char *path,
                                          const air_lightmap_gltf_params *params);

typedef struct air_lightmap_godot_params {
    float scale; /* of all light, positive and finite; default 1 */
} air_lightmap_godot_params;
AIR_API void air_lightmap_godot_params_default(air_lightmap_godot_params *params);

/* lightmap.tres (LightmapGIData), lightmap.exr (a texture array, its slices one below the other)
 * and its .import file, for Godot 4 and a glTF copy with AIR_SHOW_COORDINATES. scene_path: the glTF
 * scene, for the names of nodes. Probes: the first grid of at least 2 x 2 x 2. What cannot be said
 * is left out with a warning. params NULL: the defaults. */
AIR_API air_status air_lightmap_save_godot(air_context *context, const air_lightmap *lightmap,
                                           const char *scene_path, const char *folder,
                                           const air_lightmap_godot_params *params);

/* lightmap-0.ktx2, ... (halfs, irradiance / pi) and bevy.json with the rectangle of each mesh. What
 * is cut needs a glTF copy with AIR_SHOW_COORDINATES. AIR_ERROR_UNSUPPORTED: a rectangle that
 * leaves its page. */
AIR_API air_status air_lightmap_save_bevy(air_context *context, const air_lightmap *lightmap,
                                          const char *folder);
/* The largest irradiance / pi of all pages, W/(m^2 sr): what a white surface would send out there.
 */
AIR_API float air_lightmap_peak(const air_lightmap *lightmap);
/* 8-bit PNG with a shared multiplier, irradiance / pi = rgb * a * range with rgb and a linear in
 * [0, 1], and rgbm.json. The error of each channel is at most 1/255 of the texel's largest one, or
 * range / (2 * 255^2) where that is more. Brighter texels are clamped, with a warning;
 * air_lightmap_peak is the least range without. AIR_ERROR_ARGUMENT: range is not positive and
 * finite. */
AIR_API air_status air_lightmap_save_rgbm(air_context *context, const air_lightmap *lightmap,
                                          const char *folder, float range);

#ifdef __cplusplus
}
#endif
#endif
