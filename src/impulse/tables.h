/* tables.h: what tables are inside, and where things lie on their axes.
 *
 * Entries are floats, scaled so that they hardly vary: by tau exp(tau) after one event (point,
 * area), by exp(tau) else. */
#ifndef AIR_IMPULSE_TABLES_H
#define AIR_IMPULSE_TABLES_H

#include <math.h>

#include "airlight/impulse.h"
#include "core/vec.h"
#include "impulse/multiple.h"

enum {
    ZONAL_STRIDE = 12,
    AREA_MULTIPLE_STRIDE = 8,
    TABLES_PARTS = 6 /* arrays of numbers, in the order of impulse_tables_part */
};

#define IMPULSE_TAU_LEAST    1e-3
#define IMPULSE_TAU_GREATEST 20.0

typedef struct impulse_plan impulse_plan;

struct air_impulse_tables {
    air_context *context;
    air_impulse_params params;
    size_t angles; /* over a half turn: 3 (params.angles - 1) + 1 */
    size_t area_stride;
    float *point;                /* [g][bin][ZONAL_STRIDE] */
    float *directional;          /* [g][bin][ZONAL_STRIDE] */
    float *area;                 /* [g][bin][angle][area_stride] */
    float *point_multiple;       /* [bin][k - 2][ZONAL_STRIDE] */
    float *directional_multiple; /* [bin][k - 2][ZONAL_STRIDE] */
    float *area_multiple;        /* [bin][angle][k - 2][AREA_MULTIPLE_STRIDE] */
    impulse_plan *plan;          /* while rows are built */
};

/* Checks parameters and gives what has their shape, without arrays. */
air_status impulse_tables_shape(air_context *context, const air_impulse_params *params,
                                air_impulse_tables *out);
/* The same with memory for all arrays, zero. */
air_status impulse_tables_allocate(air_context *context, const air_impulse_params *params,
                                   air_impulse_tables **out);
/* The i-th array and how many floats it has. */
float *impulse_tables_part(const air_impulse_tables *tables, size_t i, size_t *out_count);

/* How many numbers an area entry has, and the order of what it stands for. */
int impulse_form_count(air_impulse_form form);
int impulse_form_order(air_impulse_form form);

/* tau of bin i. */
double impulse_bin_tau(size_t bins, size_t i);

/* A place between two knots: index of the lower one, and the upper one's share. */
typedef struct impulse_between {
    size_t lower;
    double share;
} impulse_between;

/* Below the first bin: the first. */
static inline impulse_between impulse_find_bin(size_t bins, double tau)
{
    const double first = cbrt(IMPULSE_TAU_LEAST / IMPULSE_TAU_GREATEST);
    const double u = cbrt(tau / IMPULSE_TAU_GREATEST);
    const double x = (u - first) / (1.0 - first) * (double)(bins - 1);
    const double inside = x > 0.0 ? x : 0.0, last = (double)(bins - 2);
    const double lower = floor(inside < last ? inside : last);
    return (impulse_between){(size_t)lower, inside - lower < 1.0 ? inside - lower : 1.0};
}

/* theta_s of angle i: behind the patch, where light falls off steeply, steps are half as wide. */
double impulse_angle(size_t angles, size_t i);

static inline impulse_between impulse_find_angle(size_t angles, double cos_s)
{
    const double c = cos_s < -1.0 ? -1.0 : cos_s > 1.0 ? 1.0 : cos_s;
    const double quarter = (double)(angles - 1) / 3.0;
    const double turned = acos(c) * 2.0 / AIR_PI * quarter;
    const double x = turned + (turned > quarter ? turned - quarter : 0.0);
    const double last = (double)(angles - 2), lower = floor(x < last ? x : last);
    return (impulse_between){(size_t)lower, x - lower};
}

/* Beyond the knots: the nearest. */
impulse_between impulse_find_g(const air_impulse_params *params, double g);

/* The fit of an axis (fit.c): tilt from l towards n_s, and the zonal coefficients about it. */
double impulse_fit_axis(air_impulse_form form, const double *sh, double *out_zh);

#endif
