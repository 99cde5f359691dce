/* steps_sse42.c: steps, four floats at a time. */
#define ORDINATES_STEPS ordinates_steps_sse42
#include "ordinates/steps_lanes.h"
