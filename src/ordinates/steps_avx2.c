/* steps_avx2.c: steps, eight floats at a time. */
#define ORDINATES_STEPS ordinates_steps_avx2
#include "ordinates/steps_lanes.h"
