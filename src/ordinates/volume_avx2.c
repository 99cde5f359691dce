/* volume_avx2.c: the march, two rays at a time. */
#define VOLUME_MARCH volume_march_avx2
#include "ordinates/volume_lanes.h"
