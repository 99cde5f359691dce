/* state.h: what with_ordinates.c sets up and march.c uses per ray. */
#ifndef AIR_RENDER_ORDINATES_STATE_H
#define AIR_RENDER_ORDINATES_STATE_H

#include "airlight/ordinates_dom.h"
#include "render/ordinates/domain.h"
#include "render/ordinates/sky.h"
#include "render/ordinates/voxels.h"
#include "render/ordinates/with_ordinates.h"
#include "scene/media/field.h"

/* One medium as the march meets it. */
typedef struct ord_medium {
    float peak;   /* share of its scattering that counts as none */
    float *light; /* what it scatters towards the camera, over sigma_s: 4 per cell; NULL: nothing */
    float *first; /* likewise, of light straight from the lights, with the true extinction; only
                     where that is wanted apart */
} ord_medium;

struct air_with_ordinates {
    air_context *context;
    const air_snapshot *snapshot;
    const air_path *path;
    const air_ordinates_settings *settings;
    air_dom_params rule; /* bands and angles; the rest is not set */
    ord_past *past;      /* or NULL */
    uint64_t history;    /* of what was taken from there; 0: nothing */
    ord_domain domain;
    ord_sky sky;
    ord_medium *media; /* by medium */
    size_t medium_count;
    float *carried; /* what cells scatter towards the camera, over sigma_s, of light that grids of
                       its own carried; with the true extinction; NULL: there is none */
    float *extinction;  /* of each cell, mean over channels */
    float largest;      /* of these */
    ord_voxels *voxels; /* by region; NULL: none */
    bool all, single;   /* march for both terms together; for M1 alone */
    bool first_wanted;  /* M1 is */
    bool carries;       /* some light has grids of its own */
};

/* Stretches of rays that go through voxels of one region each; lanes that meet others go by
 * themselves. */
enum { ORD_SPANS = 8 };

typedef struct ord_span {
    float t0, t1;
    uint32_t region;
} ord_span;

enum { ORD_MARCH_BLOCK = 16 /* steps looked at together; at most AIR_LOOKS */ };

struct air_march_scratch {
    air_ray_media media;
    ord_span spans[AIR_PATH_LANES][ORD_SPANS];
    size_t span_count[AIR_PATH_LANES];
    /* On a block of steps, region by region of those present. */
    air_coefficients found[AIR_MAX_REGIONS][ORD_MARCH_BLOCK];
};

enum { ORD_BLOCK = 16 /* sources whose fluences are in memory at a time */ };

/* Sets with->rule: what is asked for, or what the media need. */
void ord_rule_choose(air_with_ordinates *with);

/* Bytes that a solution takes at its height, from the domain's size, the settings and what is
 * wanted. `deep`: light of more than one event. */
double ord_memory(const air_with_ordinates *with, bool deep);

/* Fills with->media. */
air_status ord_solve(air_with_ordinates *with, const struct air_owner_table *owners,
                     const air_camera_view *view, const air_render_params *params);

/* Radiance towards the camera along the rays of count lanes: [0] of all light, [1] of M1 alone, as
 * asked for. */
void ord_march(const air_with_ordinates *with, air_march_scratch *scratch,
               const air_path_lane *lanes, size_t count, air_vec3 (*out)[2]);

#endif
