/* ltc_knots.c: tables of transformed cosines: their axes, all fits, and what is between them. */
#include <math.h>

#include "airlight/area_ltc.h"
#include "arealight/ltc_table.h"
#include "core/host.h"
#include "core/vec.h"

static double least_root(void) { return sqrt(1e-3); }

double air_area_ltc_knot_alpha(size_t i)
{
    const double root = least_root() + (double)i / (AIR_LTC_SIDE - 1) * (1.0 - least_root());
    return root * root;
}

double air_area_ltc_knot_cosine(size_t j)
{
    const double root = cos(0.5 * AIR_PI * (double)j / (AIR_LTC_SIDE - 1));
    return root * root;
}

static void fit_row(void *user, size_t i, size_t worker)
{
    air_area_ltc_table *table = user;
    (void)worker;
    for (size_t j = 0; j < AIR_LTC_SIDE; j++) {
        table->knots[i][j] =
            air_area_ltc_fit(air_area_ltc_knot_alpha(i), air_area_ltc_knot_cosine(j));
    }
}

void air_area_ltc_table_fit(air_context *context, air_area_ltc_table *out)
{
    air_parallel_for(context, AIR_LTC_SIDE, fit_row, out);
}

const air_area_ltc_table *air_area_ltc_table_default(void) { return &air_ltc_table; }

/* A number on an even axis of AIR_LTC_SIDE knots from 0 to 1: the knot before it and the rest. */
static size_t place(double x, double *out_rest)
{
    const double at = (x > 0.0 ? fmin(x, 1.0) : 0.0) * (AIR_LTC_SIDE - 1);
    const size_t k = at < AIR_LTC_SIDE - 1 ? (size_t)at : AIR_LTC_SIDE - 2;
    *out_rest = at - (double)k;
    return k;
}

static void add(air_area_ltc *sum, double weight, const air_area_ltc *knot)
{
    sum->xx += weight * knot->xx;
    sum->xz += weight * knot->xz;
    sum->zx += weight * knot->zx;
    sum->zz += weight * knot->zz;
    sum->albedo += weight * knot->albedo;
}

air_area_ltc air_area_ltc_at(const air_area_ltc_table *table, double alpha, double cos_o)
{
    double u, v;
    air_area_ltc sum = {.xx = 0.0};
    const size_t i = place((sqrt(fmax(alpha, 0.0)) - least_root()) / (1.0 - least_root()), &u);
    const size_t j = place(acos(sqrt(fmin(fmax(cos_o, 0.0), 1.0))) * (2.0 / AIR_PI), &v);
    add(&sum, (1.0 - u) * (1.0 - v), &table->knots[i][j]);
    add(&sum, (1.0 - u) * v, &table->knots[i][j + 1]);
    add(&sum, u * (1.0 - v), &table->knots[i + 1][j]);
    add(&sum, u * v, &table->knots[i + 1][j + 1]);
    return sum;
}
