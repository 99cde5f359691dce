/* phase_fit.h: tabulated phase functions as mixtures of a few lobes.
 *
 * A table gives values at cosines of the scattering angle, linear in between, in any unit. It is
 * divided by its integral over the sphere and fitted by a non-negative sum of lobes out of a fixed
 * set: isotropic, Rayleigh, and Henyey and Greenstein's with |g| up to 0.98. What is made small is
 * the integral over the sphere of (fit - p)^2 / (p + 0.01 / (4 pi)): errors count in relation to
 * the table's value, more where there is more light. The fit is deterministic. */
#ifndef AIRLIGHT_PHASE_FIT_H
#define AIRLIGHT_PHASE_FIT_H

#include "airlight/medium.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Fits a table of count >= 2 values: cosines between the directions of travel before and after,
 * rising from -1 to 1; values finite, >= 0, not all 0. Both arrays are borrowed for the call.
 * *out_mixture: up to AIR_PHASE_MAX_LOBES lobes whose weights sum to 1, by falling weight.
 * *out_error (may be NULL): the root of the integral above, the rms relative error as scattered
 * light meets it; at most about half of it of the light goes another way than the table says.
 * AIR_ERROR_ARGUMENT with a message to context (which may be NULL) if the table is not in order.
 * Thread-safe; a table of 1000 values takes some tens of milliseconds at most. */
AIR_API air_status air_phase_fit(air_context *context, const double *cosines, const double *values,
                                 size_t count, air_phase_mixture *out_mixture, double *out_error);

#ifdef __cplusplus
}
#endif
#endif
