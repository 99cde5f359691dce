/* beam_sse42.c: the sweep, one cell at a time. */
#define BEAM_DIRECTIONAL beam_directional_sse42
#include "ordinates/beam_lanes.h"
