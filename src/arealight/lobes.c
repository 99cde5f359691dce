/* lobes.c: fits at any g, from tables of fits. */
#include <math.h>

#include "airlight/area_table.h"
#include "arealight/lobe_table.h"

static double between(double a, double b, double x) { return a + x * (b - a); }

/* A stretching by s is a shrinking by 1/s of what is before it: that is what varies evenly. */
static double between_inverses(double a, double b, double x)
{
    return 1.0 / between(1.0 / a, 1.0 / b, x);
}

/* The knots beside |g| and how far it is from the first to the second. */
static size_t place(double g, double *out_share)
{
    const double last = AIR_AREA_KNOTS - 1, at = fmin(fabs(g) * last / 0.99, last);
    const size_t k = at < last ? (size_t)at : AIR_AREA_KNOTS - 2;
    *out_share = at - (double)k;
    return k;
}

static air_area_lobe interpolate(const double a[4], const double b[4], double share, double g)
{
    return (air_area_lobe){.g = g,
                           .s_near = between_inverses(a[0], b[0], share),
                           .w_near = between(a[1], b[1], share),
                           .s_far = between_inverses(a[2], b[2], share),
                           .w_far = between(a[3], b[3], share)};
}

static air_area_lobe from_defaults(const double (*table)[4], double g)
{
    double share;
    const size_t k = place(g, &share);
    return interpolate(table[k], table[k + 1], share, g);
}

air_area_lobe air_area_lobe_ltsd(double g) { return from_defaults(air_ltsd_table, g); }

air_area_lobe air_area_lobe_mix(double g) { return from_defaults(air_mix_table, g); }

air_area_lobe air_area_table_lobe(const air_area_table *table, double g)
{
    double share;
    const size_t k = place(g, &share);
    const air_area_lobe *a = &table->knots[k], *b = &table->knots[k + 1];
    const double first[4] = {a->s_near, a->w_near, a->s_far, a->w_far};
    const double second[4] = {b->s_near, b->w_near, b->s_far, b->w_far};
    return interpolate(first, second, share, g);
}

void air_area_table_default(air_area_source source, air_area_table *out)
{
    const bool mix = source == AIR_AREA_SOURCE_MIX;
    out->source = mix ? AIR_AREA_SOURCE_MIX : AIR_AREA_SOURCE_LTSD;
    out->loss = mix ? AIR_AREA_CDF_L2 : AIR_AREA_KL;
    for (size_t k = 0; k < AIR_AREA_KNOTS; k++) {
        const double *from = mix ? air_mix_table[k] : air_ltsd_table[k];
        out->knots[k] = (air_area_lobe){.g = 0.99 * (double)k / (AIR_AREA_KNOTS - 1),
                                        .s_near = from[0],
                                        .w_near = from[1],
                                        .s_far = from[2],
                                        .w_far = from[3]};
    }
}
