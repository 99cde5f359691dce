/* domain.h: the box of cells that holds all media of a scene, and their coefficients. */
#ifndef AIR_RENDER_ORDINATES_DOMAIN_H
#define AIR_RENDER_ORDINATES_DOMAIN_H

#include "scene/snapshot.h"

/* Where the cells of a box of `cells` along its longest side lie in the world, and the bounds of
 * all media, empty parts of grids included. cells 0: none. */
typedef struct ord_lattice {
    float base[3], cell_m; /* a corner of a cell */
    uint32_t cells;
    float low[3], high[3];
} ord_lattice;

/* World axes; cells are cubes. Planes hold one number per cell and channel. */
typedef struct ord_domain {
    air_context *context;
    const air_media *media;
    float origin[3]; /* the least corner */
    float cell_m;
    size_t size[3], cells;
    ord_lattice lattice;
    bool goes_on; /* on the lattice of the picture before: places count from its base */
    float *sigma_s, *sigma_a, *g; /* 3 planes each; g: mean cosine of all media's scattering */
} ord_domain;

/* The box about all media, grids only where they have density worth mention, `cells` along its
 * longest side, without coefficients: nothing to finish. Or on the lattice of the picture before,
 * if it is one of so many cells and the box has a number near to it: media whose bounds grow and
 * shrink do not take the cells along with them. Bounds that moved as a whole do: then it is the
 * medium that moves. Not by whole voxels of a grid: then it was cut elsewhere. lattice NULL: none.
 * AIR_ERROR_ARGUMENT: there are no media, or they have no size. */
air_status ord_domain_place(const air_snapshot *snapshot, uint32_t cells,
                            const ord_lattice *lattice, ord_domain *out);

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
