/* solving.h: the light in the cells, by discrete ordinates: one solution under way. */
#ifndef AIR_RENDER_ORDINATES_SOLVING_H
#define AIR_RENDER_ORDINATES_SOLVING_H

#include "airlight/ordinates_dom.h"
#include "airlight/ordinates_view.h"
#include "render/ordinates/sources.h"
#include "render/ordinates/state.h"

enum { ORD_CHANNELS = AIR_DOM_STRIDE };

typedef struct ord_solving {
    air_with_ordinates *with;
    const air_path *path;
    const ord_domain *domain;
    air_seen_box box;
    air_dom_params dom;
    air_dom_phase phase;
    ord_source_list sources;
    uint32_t scatter_most; /* events after which light may be scattered once more */
    float *extinction[2];  /* for all light, and the true one; channels and mean of each cell */
    float *view_depth;     /* between each cell and the camera, by the former */
    double peak_ratio;     /* optical depth of events that count as none, over that of the others */
    float *moments;        /* of beams */
    bool inflow;           /* some of the sky enters by the faces: */
    float *through;        /* moments of it, where it was not scattered */
    float *fluence[2];     /* of a block's sources, likewise */
    char *scratch;         /* of a block's sources */
    size_t scratch_size;
    air_seen_beam beams[2][ORD_BLOCK];
    size_t begin, count, solved;       /* the block, of which the first are the solver's */
    double factors[AIR_DOM_BANDS_MAX]; /* of the medium under way */
    size_t medium;
} ord_solving;

/* ---- medium.c ---- */

/* What the solver takes for the media, before anything else. */
void ord_solving_set_phase(ord_solving *self);

/* Fills extinction, peak_ratio and view_depth. */
void ord_solving_set_medium(ord_solving *self);

/* The largest optical depth across a cell, of unscattered light. */
double ord_solving_thickness(const ord_solving *self);

/* ---- unscattered.c ---- */

/* Brings the sources of mode dom to the front, in their order; returns their number. */
size_t ord_solved_first(ord_source_list *sources);

/* Adds the light of sources [first, end), of which those below `solved` are the solver's, to the
 * moments and to what media show. */
air_status ord_take_sources(ord_solving *self, size_t first, size_t end, size_t solved);

/* ---- scattered.c ---- */

/* Solves for light that is scattered on, and adds it to what media show. */
air_status ord_scatter(ord_solving *self, uint32_t max_depth);

#endif
