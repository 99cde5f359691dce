#define DOM_KERNEL dom_kernel_avx512
#include "ordinates/dom_lanes.h"
