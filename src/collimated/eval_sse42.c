/* eval_sse42.c: T of many rays, two doubles at a time. */
#include "collimated/eval_lanes.h"

void air_eval_rays_sse42(const air_eval_batch *batch, const air_collimated_rays *rays, size_t count,
                         double *out_t, double *out_log)
{
    eval_rays(batch, rays, count, out_t, out_log);
}
