/* snapshot.h: the frozen scene as render and bake read it. Everything here is immutable once
 * committed. */
#ifndef AIR_SCENE_SNAPSHOT_H
#define AIR_SCENE_SNAPSHOT_H

#include <stdatomic.h>

#include "airlight/scene.h"
#include "core/host.h"
#include "core/quadric.h"
#include "core/vec.h"
#include "scene/lights/light_table.h"
#include "scene/media/media.h"
#include "scene/optics.h"

/* Ray masks. A mesh carries those bits that apply to it, none where its material is NULL; a ray
 * asks for one of them. */
enum {
    AIR_MASK_CAMERA = 1,        /* camera-visible meshes */
    AIR_MASK_SCATTER = 2,       /* all other meshes: rays after the first event */
    AIR_MASK_SHADOW_OPAQUE = 4, /* shadow-casting meshes whose material is opaque */
    AIR_MASK_SHADOW_ALPHA = 8   /* shadow-casting meshes with MASK or BLEND */
};

typedef struct air_texture {
    char *name;
    size_t width, height, channels;
    uint8_t *bytes; /* or */
    float *floats;
    bool srgb;
    air_wrap wrap_u, wrap_v;
    air_filter_kind filter;
} air_texture;

/* A texture as a material uses it; texture NULL: constant 1 (normal map: none). */
typedef struct air_texture_slot {
    const air_texture *texture;
    uint32_t uv_set;
    float uv_transform[6];
} air_texture_slot;

typedef struct air_material {
    char *name;
    air_material_model model; /* NULL too where an interface has the same index on both sides */
    air_vec3 base_color;
    float alpha;
    float metallic, roughness, normal_scale, specular, ior;
    air_vec3 emission;
    air_texture_slot base_color_slot, metallic_roughness_slot, normal_slot, emission_slot;
    air_alpha_mode alpha_mode; /* OPAQUE too where coverage cannot be less than 1 */
    float alpha_cutoff;
    bool double_sided, one_sided, unlit;
    bool textured; /* any slot has a texture */
    float transmission;
    bool thin_walled;
    air_optics optics;
    air_texture_slot transmission_slot, blend_slot, opacity_slot, bump_slot;
    float bump_scale;
    const struct air_material *blend[2]; /* of the same snapshot */
    float blend_weight;
} air_material;

/* A mesh in world space: triangles, or a quadric. */
typedef struct air_mesh {
    char *name;
    const air_quadric *quadric; /* NULL: triangles; else there are none, nor vertices */
    float *positions;           /* 3 per vertex, one float of padding */
    float *normals, *tangents, *uv[2], *colors; /* may be NULL */
    size_t vertex_count;
    uint32_t *indices;
    size_t triangle_count;
    uint32_t material; /* index into materials; 0 is the default material */
    uint32_t mask;
    uint32_t first_emitter; /* light table index of triangle 0 if it emits, else UINT32_MAX */
    bool flip; /* the front is where (p1-p0)x(p2-p0), or a quadric's normal, points away from:
                  to_world mirrors triangles, or normals are to be flipped */
    int32_t node, primitive; /* as described */
} air_mesh;

typedef struct air_camera {
    char *name;
    air_camera_kind kind;
    float to_world[12]; /* orthonormal; left-handed if mirrored */
    bool mirrored;
    float near_distance;
    float fov_y_rad, half_height, aspect;
    float lens_radius, focus_distance;
    air_film_hint film;
    air_handle handle;
    bool framed; /* made by commit to frame the bounds */
} air_camera;

struct air_snapshot {
    air_context *context;
    atomic_size_t references;
    const air_mesh **meshes; /* their arrays may be shared with other snapshots */
    size_t mesh_count;
    size_t triangle_count;
    void *accelerator;       /* of meshes, in order; NULL if there are none */
    air_material *materials; /* [0] is the default material */
    size_t material_count;
    size_t texture_count;
    air_light_table lights;
    air_media media;
    air_camera *cameras; /* at least one */
    size_t camera_count;
    bool camera_in_file;
    bool has_alpha; /* some mesh carries AIR_MASK_SHADOW_ALPHA */
    float bounds_min[3], bounds_max[3];
    struct air_shared *shared;             /* what all the above is part of (shared.h) */
    char *source;                          /* the file it came from, "" if none */
    air_units light_units, emissive_units; /* never AUTO */
    char **warnings;                       /* said while loading */
    size_t warning_count;
};

/* The index of the camera that a handle names (AIR_NONE: 0), SIZE_MAX if none. */
size_t air_snapshot_camera(const air_snapshot *snapshot, air_handle handle);

#endif
