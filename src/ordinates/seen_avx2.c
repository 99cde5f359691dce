/* seen_avx2.c: source functions and moments of beams. */
#define SEEN_KERNEL seen_avx2
#include "ordinates/seen_lanes.h"
