/* grid_record.h: a voxel grid as scenes and snapshots share it. */
#ifndef AIR_SCENE_GRID_RECORD_H
#define AIR_SCENE_GRID_RECORD_H

#include "scene/media/grid.h"
#include "scene/record.h"

typedef struct air_grid_record {
    air_record base;
    air_grid *grid; /* owned */
} air_grid_record;

/* Takes the grid, also on failure. */
air_status air_grid_record_create(air_context *context, const char *name, air_grid *grid,
                                  air_record **out_record);

#endif
