/* ordinates_domain.h: the box of cells that holds all media of a scene, and their coefficients. */
#ifndef AIR_RENDER_ORDINATES_DOMAIN_H
#define AIR_RENDER_ORDINATES_DOMAIN_H

#include "scene/snapshot.h"

/* World axes; cells are cubes. Planes hold one number per cell and channel. */
typedef struct ord_domain {
    air_context *context;
    const air_media *media;
    float origin[3]; /* the least corner */
    float cell_m;
    size_t size[3], cells;
    float *sigma_s, *sigma_a, *g; /* 3 planes each; g: mean cosine of all media's scattering */
} ord_domain;

/* The box about all media, grids only where they have density worth mention, `cells` along its
 * longest side, without coefficients: nothing to finish. AIR_ERROR_ARGUMENT: there are none, or
 * they have no size. */
air_status ord_domain_place(const air_snapshot *snapshot, uint32_t cells, ord_domain *out);

/* Gives a box that was placed the means of the media's coefficients. On failure it is as after
 * ord_domain_finish. */
air_status ord_domain_fill(ord_domain *domain);
void ord_domain_finish(ord_domain *domain); /* also of one that is all 0 */

/* A point in the box's frame. */
static inline air_vec3 ord_domain_local(const ord_domain *domain, air_vec3 world)
{
    return vec3_sub(world, vec3_load(domain->origin));
}

static inline air_vec3 ord_domain_world(const ord_domain *domain, air_vec3 local)
{
    return vec3_add(local, vec3_load(domain->origin));
}

/* Where cell number `cell` is along each axis. */
static inline void ord_domain_cell(const ord_domain *domain, size_t cell, size_t out[3])
{
    out[0] = cell % domain->size[0];
    out[1] = cell / domain->size[0] % domain->size[1];
    out[2] = cell / domain->size[0] / domain->size[1];
}

#endif
