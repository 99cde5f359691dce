/* volume_avx512.c: the march, four rays at a time. */
#define VOLUME_MARCH volume_march_avx512
#include "ordinates/volume_lanes.h"
