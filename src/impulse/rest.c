/* rest.c: all orders behind the last one that tables have. */
#include "impulse/rest.h"

#include <math.h>

#include "core/host.h"
#include "core/vec.h"

/* The sum of alpha^k Phi_k for k > after, after >= -1. The closed total less its first orders loses
 * digits where they are nearly all: it is never less than its first term. */
static double fluence_beyond(int after, double albedo, double r)
{
    if (after < 0) {
        return air_impulse_point_fluence(0, r) + air_impulse_point_fluence_rest(0, albedo, r);
    }
    const int next = after + 1 < AIR_IMPULSE_BOUNCES_MAX ? after + 1 : AIR_IMPULSE_BOUNCES_MAX;
    const double first = pow(albedo, next) * air_impulse_point_fluence(next, r);
    return double_max(air_impulse_point_fluence_rest(after, albedo, r),
                      after < AIR_IMPULSE_BOUNCES_MAX ? first : albedo * first);
}

static void make_fluence(void *user, size_t i, size_t worker)
{
    impulse_rest *const self = user;
    const double r = impulse_curve_distance((int)i);
    (void)worker;
    for (int k = 0; k < 2; k++) {
        self->curves.fluence[k][i] =
            log(r * fluence_beyond(self->after - 2 + k, self->albedo, r)) + r;
    }
}

static void make_ratio(void *user, size_t i, size_t worker)
{
    impulse_rest *const self = user;
    (void)worker;
    impulse_curves_ratios(&self->curves, (int)i);
}

impulse_rest *impulse_rest_create(air_context *context, int after, double albedo)
{
    impulse_rest *const self = air_allocate(context, 1, sizeof *self);
    if (self != NULL) {
        self->after = after;
        self->albedo = albedo;
        self->curves.k_max = 1;
        air_parallel_for(context, CURVE_POINTS, make_fluence, self);
        air_parallel_for(context, CURVE_POINTS, make_ratio, self);
    }
    return self;
}

void impulse_rest_destroy(air_context *context, impulse_rest *rest) { air_free(context, rest); }

void impulse_rest_add_zonal(const impulse_rest *self, double tau, double scale, double *out_zh)
{
    const impulse_quality quality = impulse_quality_multiple();
    double c[3 * AIR_IMPULSE_ORDER];
    impulse_point_multiple(&quality, &self->curves, tau, 2, 2, AIR_IMPULSE_ORDER, c,
                           AIR_IMPULSE_ORDER);
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        out_zh[l] += scale * self->albedo * exp(-tau) * c[2 * AIR_IMPULSE_ORDER + l];
    }
}

void impulse_rest_area(const impulse_rest *self, double tau, double scale, const double *theta_s,
                       int count, double *out)
{
    const impulse_quality quality = impulse_quality_multiple();
    double c[3 * TABLES_ANGLES_MAX * MULTIPLE_COUNT];
    impulse_area_multiple(&quality, &self->curves, tau, 2, theta_s, count, c, MULTIPLE_COUNT);
    for (int i = 0; i < count * MULTIPLE_COUNT; i++) {
        out[i] = scale * self->albedo * exp(-tau) * c[2 * count * MULTIPLE_COUNT + i];
    }
}
