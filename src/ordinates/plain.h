/* plain.h: the state of a run in doubles, one cell after the other: what lanes are held against.
 *
 * Powers are in units of what 1 W/m^2 carries through the face of a cell. */
#ifndef AIR_ORDINATES_PLAIN_H
#define AIR_ORDINATES_PLAIN_H

#include <math.h>

#include "ordinates/run.h"
#include "ordinates/shares.h"

enum { PLAIN_LOBES = 6 };

typedef struct plain_grid {
    const ordinates_run *run;
    size_t size[3], stride[3], count;
    int lobes;                                       /* 1, or 6: lobe n lies about the normal of
                                                        face n */
    double *energy[PLAIN_LOBES], *mean[PLAIN_LOBES]; /* E and a of each cell */
    double *sent[PLAIN_LOBES], *moment[PLAIN_LOBES]; /* on its way to each cell, and its a times it
                                                      */
    double *absorb, *turn;      /* optical depths of half a cell: of absorption, of the mean cosine;
                                   LITERAL: what is left after them */
    double *fluence, *seen;     /* so far */
    double *beam;               /* of one slice: what still travels unscattered */
    ordinates_upwind_row *rows; /* SIX */
    air_ordinates_books books;
} plain_grid;

/* Sends light on from a cell, or out of the grid. */
static inline void plain_send(plain_grid *self, size_t cell, const size_t at[3], int face, int lobe,
                              double energy, double moment)
{
    const int axis = face / 2;
    const bool up = face % 2 != 0;
    if (up ? at[axis] + 1 == self->size[axis] : at[axis] == 0) {
        self->books.out[face] += energy;
        return;
    }
    const size_t to = up ? cell + self->stride[axis] : cell - self->stride[axis];
    self->sent[lobe][to] += energy;
    self->moment[lobe][to] += moment;
}

/* One step: light is sent from every cell, then received. */
typedef void plain_step(plain_grid *self);
plain_step plain_step_literal, plain_step_cm, plain_step_six;

#endif
