/* lanes_probe.h: core/lanes_exponential.h as functions over arrays, for each instruction set. */
#ifndef AIR_TESTS_LANES_PROBE_H
#define AIR_TESTS_LANES_PROBE_H

#include <stddef.h>

typedef void probe_function(const double *x, double *out, size_t count);

typedef struct lanes_probe {
    probe_function *exp, *transmittance, *loss, *log;
} lanes_probe;

/* By level of the x86-64 psABI. */
extern const lanes_probe lanes_probe_v2, lanes_probe_v3, lanes_probe_v4;

#endif
