/* oracle_ordinates_field.h: what a kernel makes of a cube under a beam, in the form that photons
 * are given in. */
#ifndef AIR_TESTS_ORACLE_ORDINATES_FIELD_H
#define AIR_TESTS_ORACLE_ORDINATES_FIELD_H

#include "airlight/ordinates.h"
#include "airlight/ordinates_dom.h"
#include "oracle_ordinates.h"

/* Of n^3 cells; the beam is in all of it. */
typedef struct cube_field {
    size_t n;
    double *fluence, *flux; /* flux along z */
    double *bins;           /* [k][i][cosine to z], mean of the two middle slices; NULL: none */
    double leaves[FACES];   /* shares of what enters */
    double imbalance;       /* of the books */
    double energy, mean_cosine, residual; /* rectilinear: of cell (n/2 - 1, n/2 - 1, n/2) */
    double scattered;                     /* fluence there without the light's factor */
} cube_field;

/* By the rectilinear kernel; all false where something could not be had. */
bool field_by_steps(air_context *context, const simulated *what, size_t n,
                    const air_ordinates_params *params, bool with_bins, cube_field *out);

/* By discrete ordinates: bands and directions of params count. */
typedef struct field_dom {
    int bands, polar, azimuths;
    air_dom_solve_params solve;
} field_dom;
bool field_by_dom(air_context *context, const simulated *what, size_t n, const field_dom *how,
                  bool with_bins, cube_field *out);

void field_finish(cube_field *self);

/* Mean of unscattered light over the depth z0 .. z1 of extinction sigma. */
double field_beam(double sigma, double z0, double z1);

#endif
