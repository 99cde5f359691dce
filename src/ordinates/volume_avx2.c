/* volume_avx2.c: the march, eight rays at a time; voxels from cells. */
#define VOLUME_MARCH volume_march_avx2
#define VOLUME_FILL  volume_fill_avx2
#include "ordinates/volume_lanes.h"

#include "ordinates/volume_fill_lanes.h"
