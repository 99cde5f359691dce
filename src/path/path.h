/* path.h: the reference: unbiased volumetric path tracing of a block of samples at once.
 *
 * Walks start at a camera, or at a receiver: a point of a surface or of space whose incident light
 * is asked for. Sixteen samples of one pixel or receiver go together through the stages trace,
 * scatter, connect, so that rays meet the scene in packets. What one sample gives does not depend
 * on the fifteen others. */
#ifndef AIR_PATH_PATH_H
#define AIR_PATH_PATH_H

#include "airlight/render.h"
#include "core/sobol.h"
#include "path/ray_media.h"
#include "scene/surface.h"

enum { AIR_PATH_LANES = 16, AIR_RECEIVER_AXES = 13 };

/* What walks make of media. */
typedef enum air_path_media {
    AIR_PATH_SCATTER = 0,   /* events in them: the whole truth */
    AIR_PATH_IGNORE = 1,    /* as if there were none */
    AIR_PATH_ATTENUATE = 2, /* nothing but transmittance, and what `respond` adds */
    AIR_PATH_GATHER = 3     /* transmittance, and light scattered towards walks that stay on
                               surfaces, of a source that the caller knows; by one event between
                               light and receiver it is asked for without bias (through.c) */
} air_path_media;

/* AIR_PATH_GATHER: the light that a point of a medium scatters towards wo, over sigma_s: the
 * integral of phase function times radiance over all directions. lights: light straight from the
 * lights too. scattered NULL: no light. */
typedef struct air_path_source {
    air_vec3 (*scattered)(const void *user, air_vec3 position, uint32_t medium, air_vec3 wo,
                          bool lights);
    const void *user;
    bool through; /* light by one event between a light and the receiver is asked for in a way that
                     has no spikes (through.c), also with AIR_PATH_SCATTER; the source gives none of
                     it */
} air_path_source;

/* A stretch of a path between two vertices, or a vertex and a light. */
typedef struct air_path_segment {
    air_vec3 origin, dir;
    float length;               /* AIR_FAR: to a light at infinity */
    const air_ray_media *media; /* along it */
} air_path_segment;

/* AIR_PATH_ATTENUATE: light that media scatter while it travels a segment, as irradiance at the
 * segment's origin, on a plane of each of `count` unit normals. Both NULL: none. */
typedef struct air_path_respond {
    /* Of a light of unit strength at the segment's end: intensity 1 (point, spot), irradiance 1
     * across the segment (infinite), intensity max(0, cos) about light->normal (area). */
    void (*light)(const void *user, const air_path_segment *segment, const air_light_point *light,
                  const air_vec3 *normals, size_t count, air_vec3 *out);
    /* Of a patch of intensity max(0, cos) about normal. */
    void (*patch)(const void *user, const air_path_segment *segment, air_vec3 normal,
                  const air_vec3 *normals, size_t count, air_vec3 *out);
    const void *user;
} air_path_respond;

/* Light that surfaces are known to get, so that walks from receivers need not find out: it is added
 * as the base reflects it, and walks go on by facets only. Not with AIR_PATH_SCATTER. */
typedef struct air_path_arrived {
    /* Irradiance at a hit on the side from which it was seen: never scattered by media, and
     * scattered. False: not known there, the walk goes on. NULL: nowhere. */
    bool (*irradiance)(const void *user, const air_hit *hit, bool front, air_vec3 out[2]);
    const void *user;
} air_path_arrived;

typedef struct air_path_settings {
    uint32_t max_depth;
    /* wanted[(light_owner * (medium_count + 1) + medium) * AIR_TERM_COUNT + term]: what path is to
     * compute; medium_count stands for no medium. Borrowed. NULL: all of it. */
    const uint8_t *wanted;
    uint32_t terms; /* mask over everything, emission and background too */
    bool guides;
    void (*vertex_hook)(void *user, size_t x, size_t y, uint32_t sample,
                        const air_path_vertex *vertex);
    void *vertex_hook_user;
    air_path_media media;
    air_path_source source;
    air_path_respond respond;
    air_path_arrived arrived;
} air_path_settings;

/* What is the same for all samples of a render. */
typedef struct air_path {
    const air_snapshot *snapshot;
    const air_media *media; /* the snapshot's, or none */
    const air_ray_backend *rays;
    const air_sobol *sobol;
    air_path_settings settings;
    bool hittable_lights; /* some light can be met by a sampled direction, or some medium emits */
    bool emissive_media;
    bool endless;  /* some medium neither ends nor absorbs */
    bool sharp;    /* some surface may reflect or let through single directions: light of S0 that
                      comes so is path's, whoever owns the rest, since no other method can ask it */
    bool pervious; /* some mesh casts no shadow: then shadow rays see what directions do not */
    bool whole_volume; /* the media are one convex region of constant density: distances can follow
                          lights from infinity in closed form */
    air_collimated_medium volume; /* that region */
    bool extended_lights;         /* some light has an area or fills directions */
    bool passes_media; /* what media scatter to the camera is asked for and all other methods': rays
                          from there pass them (terms that are not asked for change no numbers) */
    /* The lights that vertices ask: the snapshot's; at first events less those that are wholly
     * other methods' there, on surfaces less environments of one radiance, which directions drawn
     * by the surface meet as well. Views: only their cdf may be their own. */
    air_light_table lights[2][2]; /* [at a first event][on a surface] */
    float *cdfs[2][2];            /* owned; NULL: the snapshot's */
} air_path;

/* On failure the path is as after air_path_finish. */
air_status air_path_init(air_path *path, const air_snapshot *snapshot, const air_sobol *sobol,
                         const air_path_settings *settings);
void air_path_finish(air_path *path);

/* A point whose incident light is asked for. Walks that start here have it as their first vertex,
 * of depth 1. */
typedef struct air_path_receiver {
    air_vec3 position;
    air_vec3 normal;      /* unit: the axis of the cosine; light comes from its side */
    air_vec3 geometric;   /* unit, of the surface: light comes from this side too */
    float offset;         /* by which rays leave the surface, see air_surface */
    bool sphere;          /* a point of space: light comes from everywhere, there are no normals */
    const air_vec3 *axes; /* normals for air_path_respond; borrowed */
    size_t axis_count;    /* at most AIR_RECEIVER_AXES */
    float uniform;        /* [0, 1]: share of directions drawn evenly, not by the cosine */
} air_path_receiver;

/* One sample: in and out. */
typedef struct air_path_lane {
    air_vec3 origin, dir; /* of the camera's ray; of a receiver's first ray: out */
    air_sampler sampler;
    float u_distance,
        u_pick;   /* the last two numbers of the sampler's set 0; the first two chose the ray */
    float u_beam; /* for what the collimated method draws */
    uint32_t x, y, sample;
    air_hit hit; /* what the first ray met, transparent surfaces passed */
    air_vec3 terms[AIR_TERM_COUNT];
    /* Receivers: terms are what comes along dir, over the density of dir per solid angle: S0 from
     * lights, S+ by way of surfaces, M1 from lights by one event in a medium, M2 otherwise by
     * media. Light asked for at the receiver itself, and light by one event between a light and the
     * receiver (air_path_source.through), likewise over their densities, are apart. */
    const air_path_receiver *receiver; /* borrowed; camera samples: not looked at */
    float through_weight;              /* in: factor on light by one event; 0: not asked for */
    bool left;                         /* a first ray was drawn */
    air_vec3 connected, connected_dir;
    air_vec3 through, through_dir;
    air_light_point through_light; /* whose light is asked for through media */
    float through_probability;     /* with which it was chosen */
    /* air_path_respond, for each axis of the receiver: what media scatter of light asked for at the
     * receiver; and of each unit of radiance that leaves the first surface along -dir (over the
     * density of dir). first: the transmittance of that first ray, 0: it met no surface. */
    air_vec3 lit[AIR_RECEIVER_AXES], patch[AIR_RECEIVER_AXES];
    float lit_share; /* how much of that light gets through */
    air_vec3 first;
    air_vec3 albedo, normal;
    float depth; /* of the first surface, 0 if there is none */
} air_path_lane;

typedef struct air_path_scratch air_path_scratch; /* one per worker */
size_t air_path_scratch_size(void);

/* The product of 1 - alpha over the surfaces with coverage that a shadow ray meets. */
float air_path_alpha_transmittance(const air_path *path, const air_ray *shadow_ray);

/* What surfaces let through of shadow rays: 0 where one is in the way, else the product of 1 -
 * alpha over those with coverage; 1 for rays whose mask is 0. occluded: scratch of `count` bytes.
 */
void air_path_shares(const air_path *path, const air_ray *rays, size_t count, uint8_t *occluded,
                     float *out_shares);

/* Traces lanes[0..count), count <= AIR_PATH_LANES; the terms, guides included, are overwritten. */
void air_path_trace(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                    size_t count);

/* The same from receivers. Of a lane: sampler, receiver and through_weight are read. */
void air_path_receive(const air_path *path, air_path_scratch *scratch, air_path_lane *lanes,
                      size_t count);

/* Of the media between the camera and what a traced lane met (lane->hit), all of them where that
 * is nothing: in closed form, else the unbiased estimate that emission seen there is weighted by.
 */
air_vec3 air_path_view_transmittance(const air_path *path, air_path_scratch *scratch,
                                     const air_path_lane *lane);

#endif
