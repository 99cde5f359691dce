/* grids.h: light carried through grids of its own for each direction and lamp: the modes
 * cm, six and literal, and in harmonics alone, shdom. */
#ifndef AIR_RENDER_ORDINATES_GRIDS_H
#define AIR_RENDER_ORDINATES_GRIDS_H

#include "render/ordinates/sources.h"
#include "render/ordinates/state.h"

/* What all of these modes share. */
typedef struct ord_carrying {
    air_with_ordinates *with;
    const ord_domain *domain;
    const ord_source_list *sources;
    air_seen_box box;        /* the domain's cells and the camera */
    const float *extinction; /* 4 per cell */
    air_dom_phase phase;
    bool grey;   /* the coefficients of all channels are the same */
    float *rest; /* power that lost its direction, W/m^3, 4 per cell; NULL: it is dropped */
} ord_carrying;

/* Adds to with->carried what cells scatter towards the camera of the sources of modes cm, six and
 * literal. Reads `rest` where it is not NULL: adds to it. */
air_status ord_carry_directions(ord_carrying *self);
air_status ord_carry_points(ord_carrying *self);

/* Lets what is in `rest` scatter on, by discrete ordinates. */
air_status ord_carry_rest(ord_carrying *self);

/* The sources of mode shdom. */
air_status ord_carry_harmonics(ord_carrying *self);

/* All of them, as they occur. */
air_status ord_carry(ord_carrying *self);

/* Is the source carried in a grid of its own? */
static inline bool ord_source_is_carried(const ord_source *source)
{
    return source->mode == AIR_ORDINATES_MODE_CM || source->mode == AIR_ORDINATES_MODE_SIX ||
           source->mode == AIR_ORDINATES_MODE_LITERAL;
}

/* Trilinear in numbers of the domain's cells, `stride` apart, 0 beyond its border; in the box's
 * frame. */
float ord_domain_sample(const ord_domain *domain, const float *values, size_t stride,
                        const float local[3]);

#endif
