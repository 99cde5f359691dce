/* response_avx2.c: batches, eight floats at a time. */
#define IMPULSE_BATCH impulse_batch_avx2
#include "impulse/response_lanes.h"
