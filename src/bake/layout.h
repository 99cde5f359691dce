/* layout.h: where each mesh of a snapshot is on the pages of a lightmap. */
#ifndef AIR_BAKE_LAYOUT_H
#define AIR_BAKE_LAYOUT_H

#include "airlight/bake.h"
#include "atlas/coverage.h"
#include "scene/snapshot.h"

typedef struct air_bake_page {
    uint32_t width, height;
    air_atlas_part *parts; /* one per mesh on the page */
    float **positions;     /* of each part: owned where the mesh was cut, else NULL */
    uint32_t *part_meshes; /* the snapshot's mesh of each part */
    size_t part_count;
    air_coverage *coverage;
} air_bake_page;

typedef struct air_bake_layout {
    air_context *context;
    const air_snapshot *snapshot;
    air_lightmap_mesh *meshes; /* one for each mesh of the snapshot */
    size_t mesh_count;
    air_bake_page *pages;
    size_t page_count;
} air_bake_layout;

/* Errors name mesh and texel, see air_bake. */
air_status air_bake_layout_create(air_context *context, const air_snapshot *snapshot,
                                  const air_bake_params *params, air_bake_layout **out_layout);
void air_bake_layout_destroy(air_bake_layout *layout); /* NULL is legal */

#endif
