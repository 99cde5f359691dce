/* greatest_avx2.c: the largest of numbers, eight at a time. */
#define ORDINATES_GREATEST ordinates_greatest_avx2
#include "ordinates/greatest.h"
