/* render.h: rendering a snapshot into a film, and what films can do.
 *
 * Light is split into terms, so that several methods can share a picture: each (light, medium,
 * term) has exactly one owner. Beauty is the sum of the terms. */
#ifndef AIRLIGHT_RENDER_H
#define AIRLIGHT_RENDER_H

#include "airlight/area_table.h"
#include "airlight/image.h"
#include "airlight/lightmap.h"
#include "airlight/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum air_term {
    AIR_TERM_S0 = 0,         /* direct light on surfaces: light, surface, camera */
    AIR_TERM_S_PLUS = 1,     /* surfaces after further events */
    AIR_TERM_M1 = 2,         /* single scattering in media of light straight from the emitter */
    AIR_TERM_M2 = 3,         /* light scattered in media after two or more events */
    AIR_TERM_EMISSION = 4,   /* emitters and emissive media seen directly */
    AIR_TERM_BACKGROUND = 5, /* the environment seen directly */
    AIR_TERM_COUNT = 6
} air_term;

enum { AIR_TERMS_ALL = 63, AIR_AREA_MAX_DRAWS = 1024 };

/* "S0", "S+", "M1", "M2", "emission", "background". */
AIR_API const char *air_term_name(air_term term);

typedef enum air_method {
    AIR_METHOD_PATH = 0,       /* everything, by unbiased path tracing */
    AIR_METHOD_COLLIMATED = 1, /* S0 and M1 of collimated lights where all media are convex and of
                                  constant density */
    AIR_METHOD_AREALIGHT = 2,  /* S0 and M1 of lamps: flat polygons, and emissive meshes without
                                  texture, where all media are of constant density */
    AIR_METHOD_ORDINATES = 3,  /* M1 and M2 where all media have an end: light in a grid */
    AIR_METHOD_COUNT = 4
} air_method;
AIR_API const char *air_method_name(air_method method);

/* The owner of every (light, medium, term). Lights are indexed as the snapshot lists them
 * (air_scene_info.light_count of them, emissive meshes together as one behind the last), media
 * likewise; surface terms, emission and background use medium index medium_count ("no medium"). */
typedef struct air_owner_table air_owner_table;
/* Parses "auto", "interactive", "METHOD[:MODE]" or "LIGHT=METHOD[:MODE],...". A method that does
 * not apply falls back to path with one warning that says why. auto: collimated:exact where it
 * applies, else path. interactive: ordinates where it applies, without noise but with the blur of
 * its cells; where it does not, and where collimated applies and light meets at most one scattering
 * event along the media's longest sides, as auto. LIGHT may have any of these, and means all lights
 * of that name; lights that are not named are auto's.
 * Modes of collimated: exact (the default), rm, ds, wvds, rees, reds, me, me6, me-ideal, me6-ideal
 * (docs/collimated.md). Modes of arealight: edge (the default), mix, ltsd, volume-ris
 * (docs/arealight.md). Modes of ordinates: dom (the default), cm, six, literal, shdom
 * (docs/ordinates.md). */
AIR_API air_status air_owner_table_create(air_context *context, const air_snapshot *snapshot,
                                          const char *methods, air_owner_table **out_table);
AIR_API void air_owner_table_destroy(air_owner_table *table);
AIR_API air_method air_owner_table_get(const air_owner_table *table, size_t light, size_t medium,
                                       air_term term);
/* The mode in which the method of a light works, "" if it has none. Static storage. */
AIR_API const char *air_owner_table_mode(const air_owner_table *table, size_t light);

/* Everything `airlight info --json` prints, as JSON text: triangles, lights, media with boundary
 * kind, cameras, bounds, units assumed, owner table, warnings. Query with buffer NULL and *size =
 * 0: *size becomes the size needed with the final NUL; then call with a buffer of that size. */
AIR_API air_status air_snapshot_describe(const air_snapshot *snapshot, char *buffer, size_t *size);

/* How the numbers of one pixel's samples are laid out, for the distances that sampled modes draw.
 */
typedef enum air_pattern {
    AIR_PATTERN_INDEPENDENT = 0,
    /* Van der Corput's sequence, Owen-scrambled anew for each pixel: of the first 2^m samples, and
     * of each later run of 2^m that starts at a multiple of it, one falls into each [j, j+1)/2^m.
     */
    AIR_PATTERN_STRATIFIED = 1,
    /* The same sequence moved by one offset xi for each pixel, modulo 1: the first 2^m samples are
     * {(j + xi')/2^m}, all at the same place of their strata. */
    AIR_PATTERN_SYSTEMATIC = 2,
    /* Systematic, with offsets that differ between neighbouring pixels as far as can be: errors
     * become blue noise across the picture, which the eye and filters average out. */
    AIR_PATTERN_BLUE_NOISE = 3
} air_pattern;

/* A stretch of a ray in which the same media are present: bit i of the mask is medium i of the
 * snapshot. */
typedef struct air_media_interval {
    float t0, t1;
    uint64_t media_mask;
} air_media_interval;

/* A vertex of a camera path, as the hook sees it: after its segment was sampled, before light is
 * gathered. */
typedef struct air_path_vertex {
    float position[3];
    float dir_in[3];     /* direction of travel that arrived here */
    float throughput[3]; /* of the path up to the vertex, sigma_s included where it lies in a medium
                          */
    float segment_length;                /* of the ray that arrived */
    const air_media_interval *intervals; /* media along that ray up to the surface it ends on, in
                                            order; valid during the call */
    size_t interval_count;
    uint64_t media_mask; /* media present at the vertex; 0 in clear air */
    uint32_t depth;      /* 1 = first event */
    bool on_surface;
    float normal[3]; /* surfaces: on the side the ray came from */
} air_path_vertex;

struct air_film;

/* What lives on from picture to picture, so that the next frame of a sequence begins where the last
 * one ended: of method ordinates the light in the cells, how these lie in the world, what the
 * camera saw of the sky, and skies made ready. Nothing need be said about what has changed: what is
 * kept is held against the scene at hand. A picture that is rendered with a state depends on the
 * pictures rendered with it before, in their order, and on nothing else that is new; with a state
 * that has seen none it is the picture without. */
typedef struct air_render_state air_render_state;
AIR_API air_status air_render_state_create(air_context *context, air_render_state **out_state);
AIR_API void air_render_state_destroy(air_render_state *state); /* NULL is legal */

/* Of method ordinates (docs/ordinates.md). */
typedef struct air_ordinates_settings {
    uint32_t cells;      /* along the longest side of the media's bounds, [2, 256]; default 32 */
    uint32_t directions; /* for each environment, [1, 4096]; default 64 */
    uint32_t patches;    /* about so many of each lamp with an area, of all surfaces for what lights
                            send them, and again for what media send them, [1, 4096]; default 64 */
    int bands; /* of dom and shdom, as in air_dom_params; 0: 4, and 7 where a medium scatters
                  ahead with a mean cosine above 0.9; default 5 */
    int polar, azimuths; /* likewise; 0, the default: the least that the bands take */
    uint32_t sweeps;     /* of dom and shdom at most, >= 1; default 64. A max_depth up to it is
                            kept; one above is as good as none */
    double change;       /* of a sweep, below which these end, >= 0; default 1e-3 */
    uint32_t steps;      /* of literal, cm and six at most, [1, 4096]; default 32 */
    uint32_t march;      /* looks per cell along camera rays, [1, 64]; default 2 */
    bool prefilter;      /* directions stand for parts of the sky, not for points; default true */
    bool importance;     /* directions by what the camera sees of them; default false */
    bool residuum;       /* literal, cm, six: light that has lost its direction goes on in one grid;
                            default true */
    bool bilateral;      /* light is taken from cells of like density; default true */
} air_ordinates_settings;

typedef struct air_render_params {
    air_handle camera;                 /* AIR_NONE: the first one */
    size_t width, height;              /* 1..65535 */
    size_t crop[4];                    /* x0, y0, x1, y1 within the picture; default: all of it */
    uint32_t sample_begin, sample_end; /* samples per pixel [begin, end); begin a multiple of 16 */
    uint64_t seed;
    uint32_t max_depth;  /* surface and medium events together; 1 = direct light and single
                            scattering;  default 4294967295 (unlimited) */
    uint32_t terms;      /* mask of 1 << air_term; default AIR_TERMS_ALL */
    const char *methods; /* see air_owner_table_create; default "auto" */
    air_filter filter;   /* default box */
    float filter_radius; /* pixels, (0, 16]; air_filter_radius_default of the filter */
    air_pattern pattern; /* default AIR_PATTERN_STRATIFIED */
    /* Of method arealight: the rule and the number of its nodes along each stretch of a ray in a
     * medium; how many samples of visibility each sample takes per lamp (0: nothing is in the way
     * of lamps), each chosen from so many candidates (Volume-RIS: as many). */
    air_area_rule area_rule;          /* default AIR_AREA_EQUIANGULAR */
    uint32_t area_nodes;              /* [1, AIR_AREA_MAX_NODES]; default 8 */
    uint32_t shadow_samples;          /* [0, AIR_AREA_MAX_DRAWS]; default 1 */
    uint32_t shadow_candidates;       /* [1, AIR_AREA_MAX_DRAWS]; default 8 */
    const air_area_table *area_table; /* lobes of modes ltsd or mix, whichever it is for; borrowed;
                                         NULL: the library's */
    air_ordinates_settings ordinates;
    /* Borrowed, read and changed: one render at a time, or AIR_ERROR_ARGUMENT, and with the context
     * that it was made with. A render that fails or is interrupted while light is carried to the
     * cells leaves it as it was. Default NULL: none. */
    air_render_state *state;
    /* The light on surfaces that the camera sees (S0 and S+), as it was baked, instead of tracing
     * it: what a surface sends is its albedo towards the camera times irradiance / pi. S0 is the
     * layer direct, S+ the layers indirect and media, of as many bounces as were baked. With
     * directional light, normal maps turn the irradiance. Backs of surfaces are dark unless their
     * material is double-sided: then both sides show the front's light. Meshes that are on no page
     * are dark, with a warning. All other terms are as without. AIR_ERROR_ARGUMENT names a mesh
     * that is not the scene's. Borrowed; default NULL: none. */
    const air_lightmap *lightmap;
    double time_limit_s; /* INFINITY: none. Stops after the pass in which it is exceeded */
    size_t tile_size;    /* pixels; has no influence on the result; default 32 */
    bool layers; /* keep the terms apart in the film, for layers; else they share one slot; default
                    false */
    bool guides; /* keep albedo, normal and depth (the way from where rays begin) of the first
                    surface too; default false */
    uint32_t variance_replicates; /* 0: none; else the samples are that many independent scramblings
                                     and the film keeps the variance of their mean; sample_end -
                                     sample_begin must be a multiple of it; 0 or >= 2 */
    /* Called for every path vertex, concurrently; NULL: none. */
    void (*vertex_hook)(void *user, size_t x, size_t y, uint32_t sample,
                        const air_path_vertex *vertex);
    void *vertex_hook_user;
    /* Called after each progressive pass with the film so far; return false to stop; NULL: none. */
    bool (*pass_done)(void *user, const struct air_film *film);
    void *pass_user;
} air_render_params;

AIR_API void air_render_params_default(air_render_params *params);

/* ---- film: raw sums; only resolve divides ---- */

typedef struct air_film air_film;

/* Renders. When the progress callback or pass_done asks to stop, or the time is over, *out_film
 * holds the passes done and the status is AIR_OK for the time limit and pass_done,
 * AIR_ERROR_INTERRUPTED for progress. On other failures *out_film is NULL. The result depends on
 * snapshot, params and build only, not on threads or tiles. */
AIR_API air_status air_render(air_context *context, const air_snapshot *snapshot,
                              const air_render_params *params, air_film **out_film);
AIR_API void air_film_destroy(air_film *film);

AIR_API size_t air_film_width(const air_film *film);
AIR_API size_t air_film_height(const air_film *film);
/* First and one past the last sample held; a film made of parts that do not touch reports the hull.
 */
AIR_API void air_film_samples(const air_film *film, uint32_t *out_begin, uint32_t *out_end);

/* Adds the samples of `other` to `film`: same size, crop, seed, terms, settings, disjoint samples,
 * else AIR_ERROR_ARGUMENT. Films whose sample ranges are adjacent at multiples of 16 merge to the
 * bytes of one run. */
AIR_API air_status air_film_merge(air_film *film, const air_film *other);

/* Raw sums to and from a file (.film, docs/film-format.md). */
AIR_API air_status air_film_save(const air_film *film, const char *path);
AIR_API air_status air_film_load(air_context *context, const char *path, air_film **out_film);

/* String attributes kept with the film and copied to resolved images; copied. value NULL removes.
 */
AIR_API air_status air_film_set_attribute(air_film *film, const char *name, const char *value);

typedef struct air_resolve_params {
    bool layers;   /* one layer per term beside R,G,B where the film has them: "S0.R", ...; default
                      true */
    bool guides;   /* "albedo.R", ..., "normal.X", ..., "depth.Z" where the film has them; default
                      true */
    bool variance; /* of the mean: "variance.R", ... where the film has replicates; default true */
    bool smooth;   /* smooth the visible shares of lamps (method arealight) before they are divided;
                      default true */
} air_resolve_params;

AIR_API void air_resolve_params_default(air_resolve_params *params);
/* Divides the sums: R,G,B and what else was asked for. AIR_ERROR_ARGUMENT if the film holds no
 * samples. */
AIR_API air_status air_film_resolve(const air_film *film, const air_resolve_params *params,
                                    air_image **out_image);

#ifdef __cplusplus
}
#endif
#endif
