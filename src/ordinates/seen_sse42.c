/* seen_sse42.c: source functions and moments of beams. */
#define SEEN_KERNEL seen_sse42
#include "ordinates/seen_lanes.h"
