/* greatest_avx512.c: the largest of numbers, sixteen at a time. */
#define ORDINATES_GREATEST ordinates_greatest_avx512
#include "ordinates/greatest.h"
