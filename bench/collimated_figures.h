/* collimated_figures.h: what the benches of scene A share. */
#ifndef COLLIMATED_FIGURES_H
#define COLLIMATED_FIGURES_H

#include <stdio.h>
#include <time.h>

#include "collimated_scene_a.h"

enum { COLUMNS = 4, NONE = 0 };

static const int column_samples[COLUMNS] = {1, 4, 16, 64};

/* Of this thread only: other programs take their share of the machine, not of this. */
static inline double thread_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* A figure, and what it is off by where one is known. Returns the difference. */
static inline double print_figure(double value, double figure)
{
    if (figure == 0.0) {
        printf("  %6.2f               ", value);
        return 0.0;
    }
    printf("  %6.2f (%6.2f %+5.2f)", value, figure, value - figure);
    return value - figure;
}

#endif
