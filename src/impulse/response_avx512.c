/* response_avx512.c: batches, sixteen floats at a time. */
#define IMPULSE_BATCH impulse_batch_avx512
#include "impulse/response_lanes.h"
