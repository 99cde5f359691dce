/* shadow_walk_sse42.c: SSE4.2: two times four lanes. */
#include <immintrin.h>

#include "collimated/shadow_lanes.h"

static inline unsigned lane_bits(lane_mask mask)
{
    const __m128 *halves = (const __m128 *)&mask;
    return (unsigned)_mm_movemask_ps(halves[0]) | (unsigned)_mm_movemask_ps(halves[1]) << 4;
}

void air_shadow_walk_sse42(const air_shadow_tree *tree, const shadow_ray *ray, float begin,
                           float end, shadow_list *list)
{
    shadow_traverse(tree, ray, begin, end, shadow_test_lanes, list);
}
