#include "scene/grid_record.h"

static void destroy_grid(air_record *record)
{
    air_grid_destroy(((air_grid_record *)record)->grid);
}

air_status air_grid_record_create(air_context *context, const char *name, air_grid *grid,
                                  air_record **out_record)
{
    air_grid_record *record = air_record_create(context, sizeof *record, destroy_grid, name);
    if (record == NULL) {
        air_grid_destroy(grid);
        return AIR_ERROR_MEMORY;
    }
    record->grid = grid;
    *out_record = &record->base;
    return AIR_OK;
}
