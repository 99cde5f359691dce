/* sources.h: a scene's lights as beams: directions and points of light, and what of each
 * reaches the cells without an event. */
#ifndef AIR_RENDER_ORDINATES_SOURCES_H
#define AIR_RENDER_ORDINATES_SOURCES_H

#include "airlight/ordinates_dom.h"
#include "airlight/ordinates_view.h"
#include "path/path.h"
#include "render/ordinates/domain.h"
#include "render/ordinates/past.h"
#include "render/ordinates/with_ordinates.h"
#include "render/owner.h"

/* World space. */
typedef struct ord_source {
    bool local;
    air_vec3 place; /* unit direction of travel; local: position */
    air_vec3 power; /* irradiance across it, W/m^2; local: intensity, W/sr */
    float lobe;     /* mean cosine of the directions it stands for */
    float radius_m; /* local: of the disk it stands for; 0: a point */
    bool cosine;    /* local: power is times the cosine to normal, of both signs if two_sided */
    bool two_sided, casts_shadow;
    air_vec3 normal;
    const air_light *light; /* whose windows or cone apply; NULL: none */
    float solid_angle;      /* of a part of the sky; 0: it is none */
    air_ordinates_mode mode;
    bool sky;        /* of an environment: cameras see its peak by sky.h */
    float inflow;    /* share, [0, 1]: see ord_inflow_choose */
    uint32_t events; /* before its light starts here: 0: of a light; else it is a patch of surface,
                        a square of the disk's second moment (patches.h) */
} ord_source;

typedef struct ord_source_list {
    air_context *context;
    ord_source *items;
    size_t count, capacity;
} ord_source_list;

/* What surfaces do with rays, and what the method was asked for. */
typedef struct ord_lighting {
    const air_path *path;
    const air_owner_table *owners;
    const air_ordinates_settings *settings;
    const float *importance; /* AIR_IMPORTANCE_TEXELS, or NULL */
    ord_past *past;          /* or NULL */
} ord_lighting;

/* An environment as the kernels take it. */
void ord_environment_map(const air_light *light, struct air_environment_map *out);

/* All sources of the lights that the method owns. */
air_status ord_sources_make(const ord_lighting *lighting, ord_source_list *out);
air_status ord_sources_add(ord_source_list *list, const ord_source *source);
void ord_sources_finish(ord_source_list *list);

/* Says how much of each part of the sky is to enter the solver's box by its faces: all that is
 * asked for, in [0, 1]. That is right in dense boxes, too, whose outermost cells have all of the
 * light by a layer thinner than they are; suns and bright windows, whose direction shows, stay
 * beams. Between both the share falls evenly: from picture to picture no part goes over at once.
 * False: nothing is to enter. */
bool ord_inflow_choose(ord_source_list *sources, float asked);

/* Gives them to the solver: each is shared out among the directions about it. */
air_status ord_inflow_set(const ord_source_list *sources, const air_dom_params *params,
                          air_dom *dom);

/* Scratch of ord_source_fluence: bytes. */
size_t ord_source_scratch(const ord_domain *domain);

/* Mean fluence of a source in every cell, three numbers and the transmittance on the way there, for
 * power 1: attenuated by extinction (three channels and their mean per cell, per metre), hidden by
 * surfaces. */
void ord_source_fluence(const ord_domain *domain, const ord_source *source, const air_path *path,
                        const float *extinction, void *scratch, float *out);

/* The share of a source that surfaces, windows and cones let through to a point, and its intensity
 * along a unit direction as a share of its power. */
float ord_source_share(const ord_source *source, const air_path *path, air_vec3 point);
float ord_source_intensity(const ord_source *source, air_vec3 dir);

/* As the kernels take it; fluence is what ord_source_fluence gave. */
air_seen_beam ord_source_beam(const ord_domain *domain, const ord_source *source,
                              const float *fluence);

#endif
