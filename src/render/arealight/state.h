/* state.h: what with_arealight.c sets up and the files beside it use per ray. */
#ifndef AIR_RENDER_AREALIGHT_STATE_H
#define AIR_RENDER_AREALIGHT_STATE_H

#include "airlight/arealight_eval.h"
#include "render/arealight/with_arealight.h"

/* Points of a lamp with weights that sum to its area. */
typedef struct area_cubature {
    size_t count;
    double (*points)[3];
    double *weights;
} area_cubature;

/* A convex lamp that the method owns. */
typedef struct area_lamp {
    air_area_lamp shape;
    air_vec3 radiance;
    air_area_mode mode;
    bool casts_shadow;
    area_cubature few, many;
    /* For points uniform in area: cumulative shares of the fan's triangles. */
    double fan[AIR_AREA_MAX_VERTICES];
} area_lamp;

/* A lobe of a phase function, ready for integration. */
typedef struct area_lobe {
    bool rayleigh;
    double g, weight;
    int nodes;             /* per edge */
    air_area_lobe fits[2]; /* mix, ltsd */
} area_lobe;

/* One medium's phase function: a single one is its own only lobe, of weight 1. */
typedef struct area_phase {
    size_t lobe_count;
    area_lobe lobes[AIR_PHASE_MAX_LOBES];
} area_phase;

struct air_with_arealight {
    air_context *context;
    const air_path *path;
    const air_snapshot *snapshot;
    const air_render_params *params;
    area_lamp *lamps;
    size_t lamp_count, lamp_capacity;
    area_phase *phases;    /* by medium */
    bool surfaces, volume; /* is S0, M1 wanted? */
    bool ratio;
    bool convex; /* media are half-spaces' intersections and simply add up */
};

/* Points along a ray at which the light of a lamp is asked for. */
typedef struct area_nodes {
    size_t count;
    double t[AIR_AREA_MAX_NODES], w[AIR_AREA_MAX_NODES];
    double position[3][AIR_AREA_MAX_NODES], wo[3][AIR_AREA_MAX_NODES];
    double s[AIR_AREA_MAX_NODES], s_lobe[AIR_AREA_MAX_NODES];
    air_vec3 scattered[AIR_AREA_MAX_NODES]; /* sigma_s S of all media */
} area_nodes;

/* A ray to a lamp whose answer is waited for. */
typedef struct area_query {
    size_t lane;
    bool surface, ratio;
    air_vec3 value, highlight; /* what arrives if nothing is in between */
} area_query;

enum { AREA_QUERIES = 64 };

struct air_area_scratch {
    air_ray_media media; /* along the camera ray under way */
    area_nodes nodes;
    /* of the ways to a lamp's points */
    double shares[AIR_AREA_MAX_POINTS], lengths[AIR_AREA_MAX_POINTS];
    double begin[AIR_AREA_MAX_POINTS], end[AIR_AREA_MAX_POINTS];
    air_vec3 through[AIR_AREA_MAX_POINTS], reflected[AIR_AREA_MAX_POINTS];
    area_query queries[AREA_QUERIES];
    air_ray rays[AREA_QUERIES];
    uint8_t occluded[AREA_QUERIES];
    size_t query_count;
};

/* Light of one lamp along a camera ray without regard to what is in between: media laid out in
 * scratch->media. */
air_vec3 air_area_volume_light(const air_with_arealight *with, air_area_scratch *scratch,
                               const area_lamp *lamp, const double origin[3], const double dir[3]);

/* The same for what a surface reflects to the camera. */
air_vec3 air_area_surface_light(const air_with_arealight *with, air_area_scratch *scratch,
                                const area_lamp *lamp, const air_surface *surface, air_vec3 wo);

/* Transmittance of the media between two points. */
air_vec3 air_area_transmittance(const air_with_arealight *with, const double from[3],
                                const double to[3]);

#endif
