/* grid_record.h: a voxel grid as scenes and snapshots share it. */
#ifndef AIR_SCENE_GRID_RECORD_H
#define AIR_SCENE_GRID_RECORD_H

#include "airlight/frame.h"
#include "scene/media/grid.h"
#include "scene/record.h"

/* A file of a grid, or a sequence of files: a path with # (airlight/frame.h). */
typedef struct air_grid_file {
    const char *path;
    const char *name; /* of a grid in an .nvdb file, NULL: the one to be taken by default */
    bool raw;         /* the values alone, of this size: */
    size_t size[3];
    size_t channels;
} air_grid_file;

typedef struct air_grid_record {
    air_record base;
    air_grid *grid;         /* owned */
    air_grid_file sequence; /* where the grids of other frames are, strings owned; path NULL: the
                               grid is the same at all */
} air_grid_record;

air_status air_grid_record_create(air_context *context, const air_grid_desc *desc,
                                  air_record **out_record);

/* Loads the file, or that of the frame. AIR_FRAME_NONE: the path is taken as it is. */
air_status air_grid_record_load(air_context *context, const air_grid_file *file, int64_t frame,
                                air_record **out_record);

#endif
