/* eval_avx512.c: S at many points, eight doubles at a time. */
#include "core/lanes_double.h"

#include "arealight/eval_lanes.h"

void air_area_eval_avx512(const air_area_plan *plan, const air_area_shading_points *points,
                          size_t count, double *out_s)
{
    eval_points(plan, points->position, points->wo, count, out_s);
}
