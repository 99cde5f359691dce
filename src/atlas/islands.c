/* islands.c: disjoint sets joined over equal sides. */
#include "atlas/islands.h"

#include "atlas/edge_table.h"
#include "atlas/sets.h"
#include "atlas/weld.h"

air_status air_islands_find(air_context *context, const air_atlas_part *part, uint32_t *out_charts,
                            size_t *out_count)
{
    const air_weld_keys keys = {part->positions, part->uv, part->vertex_count};
    air_edge_table table = {NULL, 0};
    uint32_t *names = air_allocate(context, part->vertex_count, sizeof *names);
    if (names == NULL || air_weld(context, &keys, names) != AIR_OK ||
        air_edge_table_init(context, names, part->vertex_count, part->indices, part->triangle_count,
                            &table) != AIR_OK) {
        air_free(context, names);
        return air_fail_memory(context, "islands");
    }
    air_sets_init(out_charts, part->triangle_count);
    for (size_t i = 1; i < table.count; i++) {
        if (table.edges[i].low == table.edges[i - 1].low &&
            table.edges[i].high == table.edges[i - 1].high) {
            air_sets_join(out_charts, table.edges[i - 1].triangle, table.edges[i].triangle);
        }
    }
    *out_count = air_sets_number(out_charts, part->triangle_count);
    air_edge_table_finish(context, &table);
    air_free(context, names);
    return AIR_OK;
}
