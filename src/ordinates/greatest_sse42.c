/* greatest_sse42.c: the largest of numbers, four at a time. */
#define ORDINATES_GREATEST ordinates_greatest_sse42
#include "ordinates/greatest.h"
