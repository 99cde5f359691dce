/* steps_avx512.c: steps, sixteen floats at a time. */
#define ORDINATES_STEPS ordinates_steps_avx512
#include "ordinates/steps_lanes.h"
