/* shadow_walk_avx512.c: AVX-512: eight lanes, with its masks. */
#include <immintrin.h>

#include "collimated/shadow_lanes.h"

static inline unsigned lane_bits(lane_mask mask)
{
    return (unsigned)_mm256_movepi32_mask((__m256i)mask);
}

void air_shadow_walk_avx512(const air_shadow_tree *tree, const shadow_ray *ray, float begin,
                            float end, shadow_list *list)
{
    shadow_traverse(tree, ray, begin, end, shadow_test_lanes, list);
}
