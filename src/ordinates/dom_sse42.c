#define DOM_KERNEL dom_kernel_sse42
#include "ordinates/dom_lanes.h"
