/* fuzz_vol.c: any bytes as a Mitsuba grid volume: no crash, no leak, a sound grid or an error. */
#include "fuzz_grid.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static air_status load(air_context *context, air_grid **out_grid)
{
    return air_grid_load_vol(context, "input.vol", out_grid);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_load(data, size, load);
    return 0;
}
