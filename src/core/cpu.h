/* cpu.h: which instruction sets the machine has. */
#ifndef AIR_CORE_CPU_H
#define AIR_CORE_CPU_H

#include "airlight/context.h"

/* The best level that kernels are built for and this machine runs; AIR_CPU_C at least. */
air_cpu air_cpu_detect(void);

#endif
