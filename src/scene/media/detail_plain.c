/* detail_plain.c: noise at many points, with what all machines have. */
#define DETAIL_OCTAVE air_detail_octave_plain
#include "scene/media/detail_octave.h"
