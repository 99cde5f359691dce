/* shadow_walk_sse42.c: SSE4.2: four rays at once. */
#include "collimated/shadow_packet.h"

void air_shadow_walk_sse42(const air_shadow_tree *tree, const shadow_ray *of, size_t count,
                           shadow_list *lists)
{
    shadow_walk_packets(tree, of, count, lists);
}
