/* dom_sse42.c: discrete ordinates, one direction at a time. */
#define DOM_KERNEL dom_kernel_sse42
#include "ordinates/dom_lanes.h"
