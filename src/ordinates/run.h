/* run.h: what a run of ordinates consists of, and who takes its steps. */
#ifndef AIR_ORDINATES_RUN_H
#define AIR_ORDINATES_RUN_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "airlight/ordinates.h"

/* Borrowed; checked. */
typedef struct ordinates_run {
    const air_ordinates_cells *cells;
    const air_ordinates_params *params;
    const air_ordinates_results *results;
    void *scratch;
} ordinates_run;

/* What 1/m of scattering takes off the logarithm of the mean cosine. The printed form, g^tau, is
 * undefined for g <= 0 and is kept finite there. [Elek2014, eq. 4] */
static inline double ordinates_decay_rate(air_ordinates_decay decay, double g)
{
    return decay == AIR_ORDINATES_DECAY_PAPER ? (g < 1e-6 ? 13.8 : -log(g)) : 1.0 - g;
}

/* Faces of cells are numbered -i, +i, -j, +j, -k, +k. */
enum { ORDINATES_FACES = 6, ORDINATES_BEHIND = 4, ORDINATES_AHEAD = 5 };

/* Scratch in bytes of the plain version and of lanes. SIZE_MAX: more than there can be. */
size_t ordinates_scratch_plain(const air_ordinates_cells *cells,
                               const air_ordinates_params *params);
size_t ordinates_scratch_lanes(const air_ordinates_cells *cells,
                               const air_ordinates_params *params);

/* The largest of numbers by their bits below the sign, which are ordered as the numbers' sizes are,
 * NaN last; by those of the sign, too, if negative ones are to be the largest (-0 is not negative).
 * In each instruction set for speed: media are as much to read as to begin with. */
typedef uint32_t ordinates_greatest(const float *x, size_t count, bool with_sign);
ordinates_greatest ordinates_greatest_plain;
ordinates_greatest ordinates_greatest_sse42, ordinates_greatest_avx2, ordinates_greatest_avx512;

typedef void ordinates_steps(const ordinates_run *run);
ordinates_steps ordinates_steps_plain;
ordinates_steps ordinates_steps_sse42, ordinates_steps_avx2, ordinates_steps_avx512;

#endif
