/* interval.h: sets of stretches of a ray: sorted, disjoint intervals of its parameter.
 *
 * Plain functions over the caller's arrays: no allocation, thread-safe. */
#ifndef AIRLIGHT_INTERVAL_H
#define AIRLIGHT_INTERVAL_H

#include <stddef.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* [begin, end] in metres along a ray; empty unless begin < end. In a list they are sorted and
 * disjoint: the end of one is below the begin of the next. */
typedef struct air_interval {
    double begin, end;
} air_interval;

/* Sorts count intervals in place, drops the empty ones and joins those that touch or overlap.
 * Returns how many are left. */
AIR_API size_t air_intervals_join(air_interval *intervals, size_t count);

/* What of [begin, end] a list leaves uncovered, in order: at most count + 1 intervals, written to
 * out (which may not overlap the list). Returns their number. */
AIR_API size_t air_intervals_gaps(const air_interval *intervals, size_t count, double begin,
                                  double end, air_interval *out);

/* The intersection of two lists: at most a_count + b_count - 1 intervals (0 if either is empty),
 * written to out (which may overlap neither). Returns their number. */
AIR_API size_t air_intervals_intersect(const air_interval *a, size_t a_count, const air_interval *b,
                                       size_t b_count, air_interval *out);

#ifdef __cplusplus
}
#endif
#endif
