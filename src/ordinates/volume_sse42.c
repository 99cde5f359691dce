/* volume_sse42.c: the march, four rays at a time; voxels from cells. */
#define VOLUME_MARCH volume_march_sse42
#define VOLUME_FILL  volume_fill_sse42
#include "ordinates/volume_lanes.h"

#include "ordinates/volume_fill_lanes.h"
