/* lanes_angle_probe.h: core/lanes_angle.h and the roots under it as functions over arrays, for each
 * instruction set and precision. */
#ifndef AIR_TESTS_LANES_ANGLE_PROBE_H
#define AIR_TESTS_LANES_ANGLE_PROBE_H

#include <stddef.h>

/* Counts are multiples of 16. All compute in the probe's precision, whose numbers doubles hold. */
typedef struct lanes_angle_probe {
    void (*inverse_root)(const double *x, double *out, size_t count);
    void (*inverse)(const double *x, double *out, size_t count);
    void (*root)(const double *x, double *out, size_t count);
    void (*angle)(const double *x, const double *y, double *out, size_t count); /* of any length */
    /* Of floats alone; else NULL. */
    void (*exp2)(const double *x, double *out, size_t count); /* of [-125, 0] */
    void (*log2)(const double *x, double *out, size_t count);
} lanes_angle_probe;

/* By level of the x86-64 psABI. */
extern const lanes_angle_probe lanes_angle_v2_double, lanes_angle_v3_double, lanes_angle_v4_double,
    lanes_angle_v2_float, lanes_angle_v3_float, lanes_angle_v4_float;

#endif
