/* eval.h: what the versions of air_collimated_eval share. */
#ifndef AIR_COLLIMATED_EVAL_H
#define AIR_COLLIMATED_EVAL_H

#include "airlight/collimated.h"

/* Two parallel planes n.x <= front and -n.x <= back; a plane without a partner has back = INFINITY.
 */
typedef struct air_eval_slab {
    double normal[3];
    double front, back;
    double inverse; /* 1 / n.l where n faces the light; else 0 */
} air_eval_slab;

/* Faces towards the light for which T has a form without loops. */
enum { AIR_EVAL_BOX_LINES = 3 };

/* What is the same for all rays: the medium as slabs, those that face the light first, repeated if
 * need be until there are AIR_EVAL_BOX_LINES of them. */
typedef struct air_eval_batch {
    size_t count, facing;
    air_eval_slab slabs[AIR_COLLIMATED_MAX_PLANES + AIR_EVAL_BOX_LINES];
    double sigma_t; /* > 0 */
} air_eval_batch;

/* T and log T (out_log may be NULL) of count rays. batch->facing > 0. */
typedef void air_eval_rays(const air_eval_batch *batch, const air_collimated_rays *rays,
                           size_t count, double *out_t, double *out_log);

air_eval_rays air_eval_rays_sse42, air_eval_rays_avx2, air_eval_rays_avx512;

/* The plain version. */
void air_eval_rays_c(const air_collimated_medium *medium, const double to_light[3], double sigma_t,
                     const air_collimated_rays *rays, size_t count, double *out_t, double *out_log);

#endif
