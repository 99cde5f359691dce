/* eval.h: what the versions of air_area_eval_* share. */
#ifndef AIR_AREALIGHT_EVAL_H
#define AIR_AREALIGHT_EVAL_H

#include "airlight/arealight_eval.h"
#include "arealight/edge.h"
#include "arealight/scatter_lobes.h"

/* What is the same for all points. */
typedef struct air_area_plan {
    const air_area_lamp *lamp;
    double peak;  /* the peak of the phase function is at peak * wo, peak = 1 or -1 */
    double gamma; /* |g| */
    bool lobes;   /* else edges */

    air_edge_rule rule;     /* by edges */
    air_lobe_halves halves; /* by lobes */
} air_area_plan;

typedef void air_area_version(const air_area_plan *plan, const air_area_shading_points *points,
                              size_t count, double *out_s);
typedef void air_area_version_float(const air_area_plan *plan,
                                    const air_area_shading_points_float *points, size_t count,
                                    float *out_s);

air_area_version air_area_eval_sse42, air_area_eval_avx2, air_area_eval_avx512;
air_area_version_float air_area_eval_float_sse42, air_area_eval_float_avx2,
    air_area_eval_float_avx512;

/* The plain version; of floats too, in double. */
air_area_version air_area_eval_c;
air_area_version_float air_area_eval_float_c;

#endif
