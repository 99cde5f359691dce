/* scene.h: scenes: what is in them, how they are loaded, edited and frozen.
 *
 * An air_scene is edited through handles; air_scene_commit freezes it into an immutable,
 * reference-counted air_snapshot, which is what renders and bakes read. Unchanged parts (geometry
 * with its accelerator, textures, grids) are shared between snapshots. Editing a scene is not
 * thread-safe; reading a snapshot is. */
#ifndef AIRLIGHT_SCENE_H
#define AIRLIGHT_SCENE_H

#include "airlight/frame.h"
#include "airlight/light.h"
#include "airlight/medium.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct air_scene air_scene;
typedef struct air_snapshot air_snapshot;

typedef enum air_units {
    AIR_UNITS_AUTO = 0,
    AIR_UNITS_RADIOMETRIC = 1,
    AIR_UNITS_PHOTOMETRIC = 2
} air_units;

/* ---- textures ---- */

typedef enum air_wrap { AIR_WRAP_REPEAT = 0, AIR_WRAP_CLAMP = 1, AIR_WRAP_MIRROR = 2 } air_wrap;
typedef enum air_filter_kind { AIR_TEXTURE_LINEAR = 0, AIR_TEXTURE_NEAREST = 1 } air_filter_kind;

typedef struct air_texture_desc {
    const char *name;
    size_t width, height; /* >= 1 */
    size_t channels;      /* 1..4 */
    const uint8_t *bytes; /* row 0 at the top, interleaved; or NULL */
    const float *floats;  /* likewise; exactly one of the two is set; copied */
    bool srgb;            /* bytes: colour channels carry the sRGB transfer function */
    air_wrap wrap_u, wrap_v;
    air_filter_kind filter;
} air_texture_desc;

/* ---- materials: glTF's metallic-roughness model, and those of the field's renderers ---- */

/* uv' = (m[0] u + m[1] v + m[2], m[3] u + m[4] v + m[5]); v runs downwards as in glTF. */
typedef struct air_texture_ref {
    air_handle texture; /* AIR_NONE: no texture */
    uint32_t uv_set;    /* 0 or 1 */
    float uv_transform[6];
} air_texture_ref;

typedef enum air_alpha_mode {
    AIR_ALPHA_OPAQUE = 0,
    AIR_ALPHA_MASK = 1,
    AIR_ALPHA_BLEND = 2
} air_alpha_mode;

typedef enum air_material_model {
    /* Lambert under GGX, mixed with metal; KHR_materials_transmission, _ior and _volume. */
    AIR_MATERIAL_METALLIC_ROUGHNESS = 0,
    /* An interface between two dielectrics: reflects and refracts [Walter2007]. */
    AIR_MATERIAL_DIELECTRIC = 1,
    /* A pane of a dielectric, thinner than can be seen: light that passes goes straight on. */
    AIR_MATERIAL_THIN_DIELECTRIC = 2,
    AIR_MATERIAL_CONDUCTOR = 3, /* a metal, by its complex index of refraction */
    AIR_MATERIAL_PLASTIC = 4,   /* Lambert below the interface of a dielectric */
    AIR_MATERIAL_BLEND = 5,     /* two other materials, by a weight */
    AIR_MATERIAL_NULL = 6       /* nothing: rays pass; for boundaries of media; emits nothing */
} air_material_model;

typedef enum air_microfacets {
    AIR_MICROFACETS_GGX = 0,
    AIR_MICROFACETS_BECKMANN = 1
} air_microfacets;

typedef struct air_material_desc {
    const char *name;
    air_material_model model;
    float base_color[4]; /* linear RGB in [0,1], and alpha; of a plastic: of what is below */
    air_texture_ref base_color_texture;
    float metallic, roughness;                  /* in [0,1] */
    air_texture_ref metallic_roughness_texture; /* G: roughness, B: metallic */
    float normal_scale;
    air_texture_ref normal_texture;
    float emission[3]; /* radiance, W/(m^2 sr) */
    air_texture_ref emission_texture;
    float specular; /* [0,1], scales the dielectric reflectance; 0 with metallic 0 is a pure Lambert
                       surface */
    float ior; /* of the dielectric, the side that normals point away from, over that of the other;
                  1.5 by default; [1, 1e4], of DIELECTRIC and PLASTIC from 1e-3; 1: index-matched */
    float transmission; /* METALLIC_ROUGHNESS: [0,1], share of the base that lets light through */
    air_texture_ref transmission_texture; /* R */
    bool thin_walled; /* METALLIC_ROUGHNESS: what passes is not bent (KHR_materials_transmission
                         without _volume); default true */
    /* All but METALLIC_ROUGHNESS, BLEND and NULL: distribution and width of the facets' slopes,
     * along the tangent and across, [0, 1e3]; alpha 0: perfectly smooth. */
    air_microfacets microfacets;
    float alpha_u, alpha_v;
    float reflectance[3], transmittance[3]; /* factors on what is reflected by facets and let
                                               through; [0,1], 1 by default */
    float eta[3], absorption[3]; /* CONDUCTOR: complex index eta - i absorption, over that of the
                                    outside; [0, 1e4], not both 0; default 0 and 1: a mirror */
    bool nonlinear; /* PLASTIC: light that is reflected inside takes the base's colour each time */
    air_handle blend[2];             /* BLEND: materials, neither BLEND nor NULL */
    float blend_weight;              /* of the second, [0,1], default 0.5; coverage and emission
                                        are the blend's own */
    air_texture_ref blend_texture;   /* R, a factor on it */
    air_texture_ref opacity_texture; /* R, a factor on alpha */
    air_texture_ref bump_texture;    /* R: height, metres after bump_scale, along the normal */
    float bump_scale;
    air_alpha_mode alpha_mode;
    float alpha_cutoff;
    bool double_sided; /* emission leaves both sides; reflection does unless one_sided */
    bool one_sided; /* METALLIC_ROUGHNESS, CONDUCTOR, PLASTIC: black from behind; default false */
    bool unlit;     /* shows base_color as radiance, neither reflects nor lights */
} air_material_desc;

/* White, metallic 0, roughness 1, no textures, opaque, ior 1.5, specular 1. */
AIR_API void air_material_desc_default(air_material_desc *desc);

/* ---- meshes ---- */

/* Quadrics are exact, of unit size before to_world, and have no vertices; normals point out, a
 * disk's along +Z. Texture coordinates: angle about Z from X over a turn; and of the sphere the
 * angle from +Z over pi, of the cylinder z, of the disk (first) the radius. */
typedef enum air_shape {
    AIR_SHAPE_TRIANGLES = 0,
    AIR_SHAPE_SPHERE = 1,   /* x^2 + y^2 + z^2 = 1 */
    AIR_SHAPE_CYLINDER = 2, /* x^2 + y^2 = 1, 0 <= z <= 1, open */
    AIR_SHAPE_DISK = 3      /* x^2 + y^2 <= 1, z = 0 */
} air_shape;

typedef struct air_mesh_desc {
    const char *name;
    air_shape shape;
    bool flip_normals;      /* fronts are where normals point away from; default false */
    const float *positions; /* 3 per vertex, finite */
    const float *normals;   /* 3 per vertex, or NULL: face normals */
    const float
        *tangents; /* 4 per vertex (w = handedness), or NULL: from uv_set of the normal texture */
    const float *uv[2];  /* 2 per vertex, or NULL */
    const float *colors; /* 4 per vertex, linear, multiply base_color; or NULL */
    size_t vertex_count;
    const uint32_t *indices; /* 3 per triangle */
    size_t triangle_count;
    air_handle material; /* AIR_NONE: the default material */
    float to_world[12];  /* 3 rows of 4, applied to all of the above */
    bool camera_visible; /* default true */
    bool casts_shadow;   /* default true */
    /* Where a scene file has it: node, and primitive of the node's mesh; default -1: nowhere. Told
     * on to what is made of the mesh (lightmap.h). */
    int32_t node, primitive;
} air_mesh_desc;

AIR_API void air_mesh_desc_default(air_mesh_desc *desc);

/* ---- cameras ---- */

typedef enum air_camera_kind {
    AIR_CAMERA_PERSPECTIVE = 0,
    AIR_CAMERA_ORTHOGRAPHIC = 1
} air_camera_kind;

typedef enum air_filter {
    AIR_FILTER_BOX = 0,
    AIR_FILTER_POINT = 1,
    AIR_FILTER_TENT = 2,
    AIR_FILTER_GAUSSIAN = 3,
    AIR_FILTER_MITCHELL = 4 /* B = C = 1/3 [Mitchell1988] */
} air_filter;
AIR_API float air_filter_radius_default(air_filter filter); /* pixels */

/* What a scene file asks of a camera's picture, for those who have no wish of their own. */
typedef struct air_film_hint {
    bool known;           /* default false, and the rest is not looked at */
    size_t width, height; /* 1..65535 */
    size_t crop[4];       /* x0, y0, x1, y1 */
    uint32_t samples;     /* per pixel, >= 1 */
    air_filter filter;
    float filter_radius; /* pixels */
} air_film_hint;

typedef struct air_camera_desc {
    const char *name;
    air_camera_kind kind;
    float to_world[12];   /* looks along its local -Z, +Y up; scale and mirroring are ignored */
    bool mirrored;        /* left and right change places; default false */
    float near_distance;  /* metres along -Z at which rays begin; default 0: at the eye */
    float fov_y_rad;      /* perspective: vertical field of view, (0, pi) */
    float half_height;    /* orthographic: half of the height seen, metres */
    float lens_radius;    /* perspective: of a thin lens, metres; default 0: a pinhole */
    float focus_distance; /* along -Z, metres, > 0; default 1 */
    air_film_hint film;
    float aspect; /* width / height used when only one of both is given; 0 never occurs: default 4/3
                   */
} air_camera_desc;

AIR_API void air_camera_desc_default(air_camera_desc *desc);

/* ---- editing ---- */

AIR_API air_status air_scene_create(air_context *context, air_scene **out_scene);
AIR_API void air_scene_destroy(air_scene *scene); /* NULL is legal; snapshots stay valid */

/* Adding copies everything the description points to and gives a handle that stays valid until
 * removed. AIR_ERROR_ARGUMENT with a message that names the object and the field when a value is
 * out of range: NaN or negative coefficients, |g| >= 1, zero-area lights, indices out of range, an
 * open mesh as a boundary, and so on. */
AIR_API air_status air_scene_add_texture(air_scene *scene, const air_texture_desc *desc,
                                         air_handle *out_handle);
AIR_API air_status air_scene_add_grid(air_scene *scene, const air_grid_desc *desc,
                                      air_handle *out_handle);
/* Loads a grid file: .nvdb (grid_name NULL: the grid called "density", else the first) or Mitsuba
 * .vol. A path with # (frame.h) is that of the scene's frame, if it has one. */
AIR_API air_status air_scene_load_grid(air_scene *scene, const char *path, const char *grid_name,
                                       air_handle *out_handle);
/* Raw little-endian float32, x fastest, filling the unit cube [0,1]^3. Likewise with #. */
AIR_API air_status air_scene_load_raw_grid(air_scene *scene, const char *path, const size_t size[3],
                                           size_t channels, air_handle *out_handle);
AIR_API air_status air_scene_add_material(air_scene *scene, const air_material_desc *desc,
                                          air_handle *out_handle);
AIR_API air_status air_scene_add_mesh(air_scene *scene, const air_mesh_desc *desc,
                                      air_handle *out_handle);
AIR_API air_status air_scene_add_medium(air_scene *scene, const air_medium_desc *desc,
                                        air_handle *out_handle);
AIR_API air_status air_scene_add_light(air_scene *scene, const air_light_desc *desc,
                                       air_handle *out_handle);
AIR_API air_status air_scene_add_camera(air_scene *scene, const air_camera_desc *desc,
                                        air_handle *out_handle);

/* Replaces what a handle names by a new description of the same sort; on failure the old one stays.
 */
AIR_API air_status air_scene_set_material(air_scene *scene, air_handle handle,
                                          const air_material_desc *desc);
/* Media keep their handles of a grid, and take what it then holds. Of a sequence it is no more
 * part.
 */
AIR_API air_status air_scene_set_grid(air_scene *scene, air_handle handle,
                                      const air_grid_desc *desc);
AIR_API air_status air_scene_set_mesh(air_scene *scene, air_handle handle,
                                      const air_mesh_desc *desc);
AIR_API air_status air_scene_set_medium(air_scene *scene, air_handle handle,
                                        const air_medium_desc *desc);
AIR_API air_status air_scene_set_light(air_scene *scene, air_handle handle,
                                       const air_light_desc *desc);
AIR_API air_status air_scene_set_camera(air_scene *scene, air_handle handle,
                                        const air_camera_desc *desc);

/* Moves a scene to a frame of its grid sequences: every grid that was loaded from a path with #
 * while the scene had a frame is loaded anew from the path at this one, and stays as it was under
 * its handle for all that refers to it; nothing else changes, so that a commit says
 * AIR_DIRTY_MEDIUM and shares the rest with the one before. Grids loaded later are those of this
 * frame. The frame that the scene has already reads nothing. AIR_FRAME_NONE, with which scenes
 * begin: paths are taken as they are. On failure (the message names the file) the scene stays at
 * the frame it had. AIR_ERROR_ARGUMENT: another negative frame, or one above AIR_FRAME_MAX. */
AIR_API air_status air_scene_set_frame(air_scene *scene, int64_t frame);

/* Says where the scene came from and what its loader assumed and warned of; shown by
 * air_snapshot_describe. Strings are copied; units are "radiometric" or "photometric". */
AIR_API air_status air_scene_set_source(air_scene *scene, const char *path, air_units light_units,
                                        air_units emissive_units);
AIR_API air_status air_scene_add_warning(air_scene *scene,
                                         const char *text); /* also sent as a warning message */

/* Removes an object. AIR_ERROR_ARGUMENT if the handle names nothing, or something still refers to
 * it. */
AIR_API air_status air_scene_remove(air_scene *scene, air_handle handle);

/* What changed between two commits. */
typedef enum air_dirty {
    AIR_DIRTY_CAMERA = 1,
    AIR_DIRTY_LIGHT = 2,
    AIR_DIRTY_MEDIUM = 4,
    AIR_DIRTY_TRANSFORM = 8, /* a mesh moved, its topology did not change */
    AIR_DIRTY_GEOMETRY = 16,
    AIR_DIRTY_MATERIAL = 32
} air_dirty;

/* Freezes the scene. *out_snapshot is owned by the caller (air_snapshot_release); *out_dirty (may
 * be NULL) is the or of air_dirty since the previous commit (everything on the first). A scene
 * without a camera gets one that frames its bounds. */
AIR_API air_status air_scene_commit(air_scene *scene, air_snapshot **out_snapshot,
                                    uint32_t *out_dirty);
AIR_API void air_snapshot_retain(air_snapshot *snapshot);  /* thread-safe */
AIR_API void air_snapshot_release(air_snapshot *snapshot); /* thread-safe; NULL is legal */

/* ---- loading ---- */

typedef struct air_load_params {
    const char *const *with; /* further sidecar files, in order; NAME.airlight.json beside the scene
                                is always read */
    size_t with_count;
    const char *const *media; /* command-line media such as "box=-1,0,-1:1,2,1,sigma_s=0.2,g=0.3" or
                                 "visibility=50" */
    size_t media_count;
    const char *environment; /* lat-long .hdr/.exr, "constant=R,G,B", or NULL */
    air_units light_units;   /* AUTO: photometric, as KHR_lights_punctual says */
    air_units
        emissive_units; /* AUTO: photometric, radiometric for files that Blender's exporter wrote */
    int32_t scene_index; /* which glTF scene; -1: the file's default, or the first */
    int64_t frame; /* of grids whose file names hold #; default AIR_FRAME_NONE: there are none such.
                      air_scene_set_frame goes on from there */
    /* Of Mitsuba's XML: values of $parameters, "name=value"; unknown elements and plugins are
     * replaced, with a warning that says by what, instead of refused; files may lie outside the
     * scene's folder. */
    const char *const *defines;
    size_t define_count;
    bool lenient;
    bool files_anywhere;
} air_load_params;

AIR_API void air_load_params_default(air_load_params *params);

/* Loads a .gltf, .glb or Mitsuba .xml scene with what its sidecar says. On failure *out_scene is
 * NULL and the message names the file, the place (JSON path or byte) and what was expected. */
AIR_API air_status air_scene_load(air_context *context, const char *path,
                                  const air_load_params *params, air_scene **out_scene);

/* ---- saving ---- */

/* Writes the scene as one .glb file: glTF for what glTF knows, and the airlight object of
 * docs/sidecar.md for the rest, such that air_scene_load gives the same scene. Environment images
 * and density grids go into files beside it, STEM.NAME.exr and STEM.NAME.vol; all of them appear
 * together or not at all. Of what the file cannot hold a warning says what it became
 * (docs/convert.md). AIR_ERROR_UNSUPPORTED: another ending, or more than 4 GiB;
 * AIR_ERROR_ARGUMENT: there is a STEM.airlight.json, which would be read with the file. */
AIR_API air_status air_scene_save(air_context *context, const air_scene *scene, const char *path);

/* ---- looking ---- */

typedef struct air_scene_info {
    size_t triangle_count, mesh_count, material_count, texture_count, light_count,
        emissive_triangle_count;
    size_t medium_count, camera_count;
    float bounds_min[3],
        bounds_max[3];                /* of meshes and bounded media; min > max if there are none */
    float media_min[3], media_max[3]; /* of bounded media alone; likewise */
    bool camera_in_file;
    bool light_present;
} air_scene_info;

AIR_API void air_snapshot_info(const air_snapshot *snapshot, air_scene_info *out_info);

/* A camera as it is in the snapshot; AIR_NONE: the first, or the one that frames the bounds. The
 * name is borrowed from the snapshot. AIR_ERROR_ARGUMENT: the handle names no camera. */
AIR_API air_status air_snapshot_camera_desc(const air_snapshot *snapshot, air_handle camera,
                                            air_camera_desc *out_desc);

#ifdef __cplusplus
}
#endif
#endif
