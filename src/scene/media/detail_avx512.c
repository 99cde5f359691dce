/* detail_avx512.c: noise at many points, for machines with AVX-512. */
#define DETAIL_OCTAVE air_detail_octave_avx512
#include "scene/media/detail_octave.h"
