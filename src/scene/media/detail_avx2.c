/* detail_avx2.c: noise at many points, eight at a time. */
#define DETAIL_OCTAVE air_detail_octave_avx2
#include "scene/media/detail_octave.h"
