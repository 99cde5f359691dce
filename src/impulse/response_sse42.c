/* response_sse42.c: batches, four floats at a time. */
#define IMPULSE_BATCH impulse_batch_sse42
#include "impulse/response_lanes.h"
