/* phase.c: the public face of phase.h. */
#include "core/phase.h"

float air_phase_eval(air_phase phase, float cos_theta) { return phase_eval(phase, cos_theta); }
