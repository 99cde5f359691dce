/* envelope.h: the minimum of affine functions of t, walked from left to right. */
#ifndef AIR_COLLIMATED_ENVELOPE_H
#define AIR_COLLIMATED_ENVELOPE_H

#include <math.h>
#include <stddef.h>

typedef struct air_line {
    double offset, slope; /* offset + slope t */
} air_line;

static inline double air_line_at(air_line line, double t) { return line.offset + line.slope * t; }

/* The lowest line at t; of equal ones the steepest descent, which is lowest after t. count > 0. */
static inline size_t air_envelope_lowest(const air_line *lines, size_t count, double t)
{
    size_t lowest = 0;
    double least = air_line_at(lines[0], t);
    for (size_t j = 1; j < count; j++) {
        const double value = air_line_at(lines[j], t);
        if (value < least || (value == least && lines[j].slope < lines[lowest].slope)) {
            lowest = j;
            least = value;
        }
    }
    return lowest;
}

/* The line that takes over from `active`, the lowest one at t, and where; count if none does. A
 * crossing that rounding puts before t is moved to t. Slopes fall from one call to the next, so a
 * walk ends. */
static inline size_t air_envelope_next(const air_line *lines, size_t count, size_t active, double t,
                                       double *out_at)
{
    size_t next = count;
    double rise = 0.0, run = 1.0; /* of the first crossing so far: at rise / run */
    for (size_t j = 0; j < count; j++) {
        const double gap = lines[j].offset - lines[active].offset;
        const double gain = lines[active].slope - lines[j].slope;
        if (gain > 0.0 && (next == count || gap * run < rise * gain)) {
            next = j;
            rise = gap;
            run = gain;
        }
    }
    const double at = rise / run;
    *out_at = at > t ? at : t;
    return next;
}

/* The value where two lines cross, by the one that changes less there. */
static inline double air_envelope_kink(air_line a, air_line b, double t)
{
    return air_line_at(fabs(a.slope) < fabs(b.slope) ? a : b, t);
}

#endif
