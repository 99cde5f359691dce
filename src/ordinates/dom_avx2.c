/* dom_avx2.c: discrete ordinates, two directions at a time. */
#define DOM_KERNEL dom_kernel_avx2
#include "ordinates/dom_lanes.h"
