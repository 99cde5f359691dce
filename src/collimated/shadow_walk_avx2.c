/* shadow_walk_avx2.c: AVX2: eight lanes. */
#include <immintrin.h>

#include "collimated/shadow_lanes.h"

static inline unsigned lane_bits(lane_mask mask)
{
    return (unsigned)_mm256_movemask_ps((__m256)mask);
}

void air_shadow_walk_avx2(const air_shadow_tree *tree, const shadow_ray *ray, float begin,
                          float end, shadow_list *list)
{
    shadow_traverse(tree, ray, begin, end, shadow_test_lanes, list);
}
