/* eval_float_avx2.c: S at many points, eight floats at a time. */
#include "core/lanes_float.h"

#include "arealight/eval_lanes.h"

void air_area_eval_float_avx2(const air_area_plan *plan,
                              const air_area_shading_points_float *points, size_t count,
                              float *out_s)
{
    eval_points(plan, points->position, points->wo, count, out_s);
}
