/* phase_fit.h: what air_phase_fit checks, for callers with messages of their own. */
#ifndef AIR_CORE_PHASE_FIT_H
#define AIR_CORE_PHASE_FIT_H

#include "airlight/phase_fit.h"

enum { AIR_PHASE_FAULT_SIZE = 128 };

/* What is wrong with a table, as in "cosines[3] is 0.2, but must be above cosines[2]", or NULL. The
 * text is in buffer or static. */
const char *air_phase_table_fault(const double *cosines, const double *values, size_t count,
                                  char buffer[AIR_PHASE_FAULT_SIZE]);

#endif
