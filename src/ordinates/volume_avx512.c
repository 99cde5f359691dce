/* volume_avx512.c: the march, sixteen rays at a time; voxels from cells. */
#define VOLUME_MARCH volume_march_avx512
#define VOLUME_FILL  volume_fill_avx512
#include "ordinates/volume_lanes.h"

#include "ordinates/volume_fill_lanes.h"
