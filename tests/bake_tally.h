/* bake_tally.h: means of bakes over seeds, with their standard errors. */
#ifndef AIR_TESTS_BAKE_TALLY_H
#define AIR_TESTS_BAKE_TALLY_H

#include "bake_fixture.h"

/* The mean of a page's plane over whole texels. */
static inline double tally_page_mean(const air_lightmap *lightmap, const char *name)
{
    double sum = 0.0, weight = 0.0;
    for (size_t p = 0; p < lightmap->page_count; p++) {
        const air_image *page = lightmap->pages[p];
        const float *plane = bake_plane(page, name), *area = bake_plane(page, "coverage.Y");
        for (size_t i = 0; i < air_image_width(page) * air_image_height(page); i++) {
            sum += (double)area[i] * (double)plane[i];
            weight += (double)area[i];
        }
    }
    assert_true(weight > 0.0);
    return sum / weight;
}

/* A number of a bake over seeds: its mean and standard error. */
typedef struct tally {
    double sum, square;
    int count;
} tally;

static inline void tally_add(tally *t, double value)
{
    t->sum += value;
    t->square += value * value;
    t->count++;
}

static inline double tally_mean(const tally *t) { return t->sum / t->count; }

static inline double tally_error(const tally *t)
{
    const double mean = tally_mean(t);
    return sqrt(fmax(t->square / t->count - mean * mean, 0.0) / (t->count - 1));
}

/* Within 5 standard errors of what is expected: Student's t with 9 degrees of freedom is beyond
 * once in 1,400 times; the seeds are fixed. largest: of the error itself, so that it says much. */
static inline void assert_tally(const char *what, const tally *t, double expected, double largest,
                                double slack)
{
    const double error = tally_error(t);
    if (!(error <= largest) || !(fabs(tally_mean(t) - expected) <= 5.0 * error + slack)) {
        fail_msg("%s: %.6g +- %.2g, expected %.6g", what, tally_mean(t), error, expected);
    }
}

enum { TALLY_SEEDS = 10 };

#endif
