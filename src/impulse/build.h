/* build.h: what rows of tables share while they are built. */
#ifndef AIR_IMPULSE_BUILD_H
#define AIR_IMPULSE_BUILD_H

#include "impulse/tables.h"

void impulse_plan_destroy(air_context *context, impulse_plan *plan); /* NULL is legal */

#endif
