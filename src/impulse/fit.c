/* fit.c: the axis about which zonal harmonics stand best for mirrored coefficients. */
#include <math.h>

#include "core/vec.h"
#include "impulse/tables.h"

typedef struct fit {
    const air_sh_factors *factors;
    const double *sh;
    double weights[AIR_IMPULSE_ORDER]; /* of squared bands */
} fit;

/* c_l about the axis: n_l times the sum over m of c_lm y_lm(tilt, 0). */
static void turn(const fit *self, double tilt, double *out_zh)
{
    double y[AIR_SH_MIRRORED_MAX];
    /* The meridian continues through the pole: odd m change sign. */
    air_sh_meridian(self->factors, cos(tilt), sin(tilt), y);
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        double sum = 0.0;
        for (int m = 0; m <= l; m++) {
            sum += self->sh[l * (l + 1) / 2 + m] * y[l * (l + 1) / 2 + m];
        }
        out_zh[l] = air_zh_scale(l) * sum;
    }
}

static double energy(const fit *self, double tilt)
{
    double zh[AIR_IMPULSE_ORDER], sum = 0.0;
    turn(self, tilt, zh);
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        sum += self->weights[l] * zh[l] * zh[l];
    }
    return sum;
}

/* A scan and a golden section: the error of the angle is some 1e-8, where a maximum is flat. */
double impulse_fit_axis(air_impulse_form form, const double *sh, double *out_zh)
{
    enum { SCAN = 36, STEPS = 36 };
    const double least = -0.2, largest = 1.6, golden = 0.6180339887498949;
    air_sh_factors factors;
    fit self = {.factors = &factors, .sh = sh};
    double cosine[AIR_IMPULSE_ORDER];
    air_sh_factors_init(AIR_IMPULSE_ORDER, &factors);
    air_zh_clamped_cosine(AIR_IMPULSE_ORDER, cosine);
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        const double seen = cosine[l] * air_zh_scale(l);
        self.weights[l] = form == AIR_IMPULSE_ZH11_ENERGY ? 1.0 : seen * seen;
    }
    int best = 0;
    double most = -1.0;
    for (int i = 0; i <= SCAN; i++) {
        const double value = energy(&self, least + (largest - least) * i / SCAN);
        if (value > most) {
            most = value;
            best = i;
        }
    }
    const double step = (largest - least) / SCAN, middle = least + step * best;
    double a = double_max(least, middle - step), b = double_min(largest, middle + step);
    for (int i = 0; i < STEPS; i++) {
        const double x = b - golden * (b - a), y = a + golden * (b - a);
        if (energy(&self, x) > energy(&self, y)) {
            b = y;
        } else {
            a = x;
        }
    }
    const double tilt = 0.5 * (a + b);
    turn(&self, tilt, out_zh);
    return tilt;
}
