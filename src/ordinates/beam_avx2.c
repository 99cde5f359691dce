/* beam_avx2.c: the sweep, two cells at a time. */
#define BEAM_DIRECTIONAL beam_directional_avx2
#include "ordinates/beam_lanes.h"
