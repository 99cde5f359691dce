/* volume_sse42.c: the march, one ray at a time. */
#define VOLUME_MARCH volume_march_sse42
#include "ordinates/volume_lanes.h"
