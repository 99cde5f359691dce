/* seen_avx512.c: source functions and moments of beams. */
#define SEEN_KERNEL seen_avx512
#include "ordinates/seen_lanes.h"
