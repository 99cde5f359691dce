/* dom_avx512.c: discrete ordinates, four directions at a time. */
#define DOM_KERNEL dom_kernel_avx512
#include "ordinates/dom_lanes.h"
