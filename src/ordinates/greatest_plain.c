/* greatest_plain.c: the largest of numbers, one after the other. */
#define ORDINATES_GREATEST ordinates_greatest_plain
#include "ordinates/greatest.h"
