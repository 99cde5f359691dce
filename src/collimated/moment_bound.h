/* moment_bound.h: how much of a distribution on [-1, 1] lies below a depth, as far as its first
 * four or six moments tell. */
#ifndef AIR_COLLIMATED_MOMENT_BOUND_H
#define AIR_COLLIMATED_MOMENT_BOUND_H

#include <stddef.h>

enum { AIR_MOMENT_MOST = 6 };

/* moments[0 .. count]: sums of weight depth^k, count 4 or 6, moments[0] > 0. bias in (0, 1].
 * Returns the mass below depth plus overestimation times the mass that may lie at it, over
 * moments[0]: the sharp lower bound at 0, the sharp upper one at 1. In [0, 1]. */
double air_moment_bound(const double *moments, size_t count, double bias, double depth,
                        double overestimation);

#endif
