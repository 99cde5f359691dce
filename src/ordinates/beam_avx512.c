/* beam_avx512.c: the sweep, four cells at a time. */
#define BEAM_DIRECTIONAL beam_directional_avx512
#include "ordinates/beam_lanes.h"
