/* bake.h: lightmaps, light of vertices, and probes of a snapshot, with the light that fog scatters.
 *
 * Surfaces are path-traced. What media do to light is exact (the default), or one of the models
 * that others use, or brute force; each is a sum of the layers that lightmap.h describes. */
#ifndef AIRLIGHT_BAKE_H
#define AIRLIGHT_BAKE_H

#include "airlight/impulse.h"
#include "airlight/lightmap.h"
#include "airlight/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum air_bake_media {
    AIR_BAKE_NONE = 0,      /* as if there were no media */
    AIR_BAKE_ATTENUATE = 1, /* media take light away, and scatter none */
    AIR_BAKE_IMPULSE = 2,   /* responses of infinite media along the paths [Dubouchet2019] */
    AIR_BAKE_EXACT = 3,     /* light by one event between light and receiver without bias, all else
                               from light cached in the media */
    AIR_BAKE_REFERENCE = 4, /* volumetric path tracing of every texel */
    AIR_BAKE_MEDIA_COUNT = 5
} air_bake_media;
/* "none", "attenuate", "impulse", "exact", "reference" */
AIR_API const char *air_bake_media_name(air_bake_media media);

typedef enum air_bake_uv {
    AIR_BAKE_UV_AUTO = 0, /* a mesh's TEXCOORD_1 where it has one that serves, else unwrapped */
    AIR_BAKE_UV_FILE = 1, /* TEXCOORD_1; meshes without are an error */
    AIR_BAKE_UV_UNWRAP = 2
} air_bake_uv;

typedef enum air_probe_kind {
    AIR_PROBES_FREE = 0, /* at the positions given */
    AIR_PROBES_GRID = 1, /* at origin + i step[0] + j step[1] + k step[2] */
    AIR_PROBES_AUTO = 2  /* a grid of this spacing over the scene's bounds */
} air_probe_kind;

typedef struct air_probe_request {
    const char *name;
    air_probe_kind kind;
    const float *positions; /* FREE: 3 per probe; borrowed */
    size_t count;           /* FREE */
    size_t size[3];         /* GRID */
    float origin[3], step[3][3];
    float spacing; /* AUTO: metres */
} air_probe_request;

typedef struct air_bake_params {
    uint32_t samples;     /* per texel, vertex and probe, [1, 65536]; default 256 */
    uint64_t seed;        /* default 0 */
    uint32_t max_bounces; /* surface and medium events before light reaches a receiver; default
                             4294967295 (unlimited); 0: direct light only */
    air_bake_media media; /* default AIR_BAKE_EXACT */
    /* Paths end at the first surface that is more than two texels away, in the light that a first
     * pass of a thirty-second of the samples found for its texel. Needs lightmaps; not with
     * AIR_BAKE_REFERENCE. false: paths are traced to their end. */
    bool final_gather; /* default true */
    /* EXACT: points of cached light along the longest side of each medium, [2, 128]; 0: 8 to 64, so
     * that they have about a fortieth of the bake's samples. Samples of each, [16, 65536]; 0: 32 to
     * 1024, likewise. */
    uint32_t cache_resolution, cache_samples;
    /* IMPULSE: the paper's tables, forms and rules as printed, for comparison; and how many events
     * are summed, [1, AIR_IMPULSE_BOUNCES_MAX]. */
    bool impulse_literal; /* default false */
    int impulse_bounces;  /* default 10 */
    const air_impulse_tables
        *impulse_tables; /* borrowed; NULL: built for the bake, in some seconds */

    bool lightmaps;         /* default true */
    air_bake_uv uv;         /* default AIR_BAKE_UV_AUTO */
    float texels_per_metre; /* > 0; default 16 */
    uint32_t mesh_size;     /* texels that the unit square of a mesh's own coordinates takes along
                               each side; default 0: as texels_per_metre asks */
    uint32_t page_size;     /* most texels along a side of a page, [16, 16384]; default 2048 */
    uint32_t padding;       /* texels between charts, [0, 64] and below half a page; default 4 */
    float chart_angle_rad;  /* unwrapping: how far normals of a chart stray; default 40 degrees */
    bool directional;       /* keep bands 0 and 1 of the incident radiance too; default false */
    bool denoise;           /* default true */
    bool stitch;            /* make seams invisible; default true */
    uint32_t dilate;        /* texels that charts are continued into their surroundings by; default
                               8; UINT32_MAX: everywhere */
    bool vertices;          /* light of all vertices; default false */
    const air_probe_request *probes; /* borrowed */
    size_t probe_count;

    /* Where what is done is kept, so that an interrupted bake can go on; removed when it is whole.
     * NULL: nowhere. With resume, what is there is used if it is of the same bake. */
    const char *progress_path;
    bool resume; /* default true */
} air_bake_params;

AIR_API void air_bake_params_default(air_bake_params *params);

/* What a bake took. */
typedef struct air_bake_report {
    size_t texels, vertices, probes; /* that were sampled */
    size_t invalid_texels;           /* inside of something: filled from their neighbours */
    size_t page_bytes, cache_bytes;  /* records of all texels; cached light in media */
    size_t resumed_jobs;
    double layout_s, cache_s, first_s, sample_s, finish_s; /* first_s: of final gathering */
} air_bake_report;

/* Bakes. *out_lightmap is the caller's (air_lightmap_destroy); out_report may be NULL. The result
 * depends on snapshot, params and build only, not on threads, interruptions or resuming. Errors:
 * AIR_ERROR_ARGUMENT names the option, or the mesh whose texture coordinates are missing or
 * overlap, with the texel; AIR_ERROR_INTERRUPTED when the progress callback asks to stop (what is
 * done is in progress_path); AIR_ERROR_IO when that cannot be written. */
AIR_API air_status air_bake(air_context *context, const air_snapshot *snapshot,
                            const air_bake_params *params, air_lightmap **out_lightmap,
                            air_bake_report *out_report);

#ifdef __cplusplus
}
#endif
#endif
