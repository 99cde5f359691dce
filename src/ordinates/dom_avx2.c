#define DOM_KERNEL dom_kernel_avx2
#include "ordinates/dom_lanes.h"
