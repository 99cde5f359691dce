/* interval.c: sorted lists of intervals: joined, turned inside out, intersected. */
#include "airlight/interval.h"

/* Lists come nearly sorted, so insertion is the fastest. */
static void sort_by_begin(air_interval *intervals, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        const air_interval moved = intervals[i];
        size_t k = i;
        for (; k > 0 && intervals[k - 1].begin > moved.begin; k--) {
            intervals[k] = intervals[k - 1];
        }
        intervals[k] = moved;
    }
}

size_t air_intervals_join(air_interval *intervals, size_t count)
{
    size_t kept = 0;
    sort_by_begin(intervals, count);
    for (size_t i = 0; i < count; i++) {
        if (!(intervals[i].begin < intervals[i].end)) {
            continue;
        }
        if (kept > 0 && intervals[i].begin <= intervals[kept - 1].end) {
            if (intervals[i].end > intervals[kept - 1].end) {
                intervals[kept - 1].end = intervals[i].end;
            }
        } else {
            intervals[kept++] = intervals[i];
        }
    }
    return kept;
}

size_t air_intervals_gaps(const air_interval *intervals, size_t count, double begin, double end,
                          air_interval *out)
{
    size_t gaps = 0;
    double reached = begin;
    for (size_t i = 0; i < count && reached < end; i++) {
        const double stop = intervals[i].begin < end ? intervals[i].begin : end;
        if (reached < stop) {
            out[gaps++] = (air_interval){reached, stop};
        }
        reached = intervals[i].end > reached ? intervals[i].end : reached;
    }
    if (reached < end) {
        out[gaps++] = (air_interval){reached, end};
    }
    return gaps;
}

size_t air_intervals_intersect(const air_interval *a, size_t a_count, const air_interval *b,
                               size_t b_count, air_interval *out)
{
    size_t count = 0;
    for (size_t i = 0, k = 0; i < a_count && k < b_count;) {
        const double begin = a[i].begin > b[k].begin ? a[i].begin : b[k].begin;
        const double end = a[i].end < b[k].end ? a[i].end : b[k].end;
        if (begin < end) {
            out[count++] = (air_interval){begin, end};
        }
        if (a[i].end < b[k].end) {
            i++;
        } else {
            k++;
        }
    }
    return count;
}
