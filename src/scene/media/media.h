/* media.h: the media of a snapshot, ready for rays: coefficients, density fields, boundaries; and
 * the segments of a ray. */
#ifndef AIR_SCENE_MEDIA_MEDIA_H
#define AIR_SCENE_MEDIA_MEDIA_H

#include "airlight/collimated.h"
#include "airlight/medium.h"
#include "core/host.h"
#include "core/quadric.h"
#include "core/vec.h"
#include "scene/media/detail.h"

struct air_grid;

typedef struct air_plane {
    air_vec3 n;
    float h; /* inside: n.x <= h */
} air_plane;

/* Four planes at once; unused ones are n = 0, h = 1, which hold everywhere. */
typedef float air_plane_lanes __attribute__((vector_size(16)));
typedef struct air_plane_pack {
    air_plane_lanes x, y, z, h;
} air_plane_pack;
enum { AIR_MAX_PLANE_PACKS = (AIR_MAX_PLANES + 2 + 3) / 4 };

typedef enum air_region_kind {
    AIR_REGION_EVERYWHERE = 0,
    AIR_REGION_CONVEX = 1, /* planes */
    AIR_REGION_MESH = 2,   /* boundary mesh `mesh` of the boundary accelerator */
    AIR_REGION_ELLIPSOID = 3
} air_region_kind;

/* A region of space filled by one medium: layered media become one entry per layer, so that a
 * constant density is always a constant inside its region. */
typedef struct air_region {
    air_region_kind kind;
    uint32_t medium;
    air_plane planes[AIR_MAX_PLANES + 2]; /* a layer adds two */
    size_t plane_count;
    uint32_t mesh;
    air_quadric ellipsoid;
    float density; /* constant media: the factor on the medium's coefficients, but for detail */
    /* set by air_media_prepare */
    air_plane_pack packs[AIR_MAX_PLANE_PACKS]; /* the planes again */
    size_t pack_count;
    bool constant;                       /* its density, detail included */
    air_vec3 sigma_s, sigma_t, emission; /* constant media: with the density, without detail */
} air_region;

typedef struct air_medium {
    char *name;
    air_vec3 sigma_s, sigma_a, sigma_t, emission; /* at density 1 */
    air_phase phase;
    air_density_kind kind; /* layered media are AIR_DENSITY_CONSTANT here, one region per layer */
    air_density_kind declared_kind;
    air_boundary_kind boundary; /* after recognition: of a mesh perhaps box or convex */
    air_vec3 up;
    float base_height, inverse_scale_height;
    const struct air_grid *density_grid, *albedo_grid, *emission_grid;
    float world_to_grid[12]; /* to index space of the density grid */
    float world_to_albedo[12], world_to_emission[12];
    air_detail_field detail; /* a factor on the density */
    air_combine combine;
    int32_t priority;
    float bounds_min[3], bounds_max[3]; /* infinite where unbounded */
    air_phase_mixture mixture;          /* what phase points to if it is one */
} air_medium;

typedef struct air_media {
    air_medium *media;
    size_t count;
    air_region *regions;
    size_t region_count;            /* at most AIR_MAX_REGIONS */
    const air_ray_backend *backend; /* the context's; set by air_media_build */
    void *boundary_accelerator;     /* of mesh boundaries; NULL if none */
    air_ray_mesh
        *boundary_meshes; /* what the accelerator holds: closed, oriented outwards, owned */
    size_t boundary_mesh_count;
    bool any_replace;
    bool all_constant; /* every region is of constant density */
} air_media;

static inline bool air_medium_is_detailed(const air_medium *medium)
{
    return medium->detail.strength > 0.0f;
}

/* Is the density constant in each of its regions? */
static inline bool air_medium_is_constant(const air_medium *medium)
{
    return medium->kind == AIR_DENSITY_CONSTANT && !air_medium_is_detailed(medium);
}

/* A bound on the coefficients of a medium anywhere, over those without detail. */
static inline float air_medium_most(const air_medium *medium)
{
    return air_detail_most(&medium->detail);
}

/* Is there one medium, everywhere? */
static inline bool air_media_fill_space(const air_media *media)
{
    return media->region_count == 1 && media->regions[0].kind == AIR_REGION_EVERYWHERE &&
           media->regions[0].plane_count == 0;
}

enum { AIR_MAX_REGIONS = 64, AIR_MAX_SEGMENTS = 256 };

/* A part of a ray in which the set of regions does not change. */
typedef struct air_segment {
    float t0, t1;
    uint64_t regions; /* bit r: region r is present (after replacement) */
} air_segment;

/* Fills what regions hold for the sake of speed; air_media_build's last step. */
void air_media_prepare(air_media *media);

/* A convex region's planes as the collimated kernel takes them. */
void air_region_planes(const air_region *region, air_collimated_medium *out);

/* The segments of the ray from t = 0 to tmax (may be INFINITY), in order, without empty sets; at
 * most AIR_MAX_SEGMENTS are kept. dir is unit. Returns their number. */
size_t air_media_segments(const air_media *media, air_vec3 origin, air_vec3 dir, float tmax,
                          air_segment *out);

#endif
