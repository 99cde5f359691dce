/* beam.h: what the versions of a beam's sweep share. */
#ifndef AIR_ORDINATES_BEAM_H
#define AIR_ORDINATES_BEAM_H

#include "airlight/ordinates_beam.h"
#include "core/vec.h"

/* Beyond this nothing is left. */
#define BEAM_DEPTH_MOST 80.0f

/* BEAM_PAD: rows have room for that many cells at a time; BEAM_ROOM: numbers behind a plane without
 * such room. */
enum { BEAM_CHANNELS = 4, BEAM_PLANES = 5, BEAM_PAD = 4, BEAM_ROOM = 16 };

/* A sweep along the main axis w, across which u and v lie. Planes have a border of one cell:
 * [((v + 1) * row + u + 1) * numbers]. */
typedef struct beam_sweep {
    const air_beam_box *box;
    size_t count[3];     /* along u, v, w */
    size_t stride[3];    /* from cell to cell */
    size_t numbers;      /* of a cell in planes: BEAM_CHANNELS, or 1 where all of them are alike */
    size_t row;          /* cells of a row of planes */
    bool back;           /* travels towards smaller w */
    float shift[2];      /* how far upstream, in cells, the characteristic lies one layer before */
    float length;        /* of the characteristic within a layer, m */
    float *depth, *next; /* optical depths before and behind a layer */
    float *through;      /* transmittances of the former */
    float *sigma, *sum;  /* for versions that look at neighbours: a layer's extinction, and the
                            depths before and behind it together */
} beam_sweep;

beam_sweep beam_sweep_make(const air_beam_box *box, const float dir[3], size_t numbers,
                           void *scratch);

/* Weights of bilinear interpolation at a cell's centre less the shift: of the cell, its neighbours
 * upstream along u and v, and both; and by how much these lie away. */
typedef struct beam_stencil {
    float weight[4];
    ptrdiff_t to_u, to_v; /* -1 or 1 */
} beam_stencil;

beam_stencil beam_stencil_make(float shift_u, float shift_v);

/* What is special behind layer w at the box's sides: where light enters by them, and the border. */
void beam_close_sides(const beam_sweep *s, const beam_stencil *up, size_t w);

static inline size_t beam_place(const beam_sweep *s, size_t u, size_t v) /* of cell (u-1, v-1) */
{
    return (v * s->row + u) * s->numbers;
}

typedef void beam_directional(const air_beam_box *box, const float dir[3], void *scratch,
                              float *out_fluence);

beam_directional beam_directional_plain, beam_directional_sse42, beam_directional_avx2,
    beam_directional_avx512;

#endif
