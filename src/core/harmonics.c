/* harmonics.c: recurrences of normalised associated Legendre functions. */
#include "core/harmonics.h"

#include <math.h>

#include "core/vec.h"

void air_legendre(int order, double x, double *out)
{
    out[0] = 1.0;
    if (order > 1) {
        out[1] = x;
    }
    for (int l = 2; l < order; l++) {
        out[l] = ((2 * l - 1) * x * out[l - 1] - (l - 1) * out[l - 2]) / l;
    }
}

void air_legendre_powers(int order, double *out)
{
    for (int i = 0; i < order * order; i++) {
        out[i] = i == 0 || i == order + 1 ? 1.0 : 0.0; /* P_0 and P_1 */
    }
    for (int l = 2; l < order; l++) {
        const double *const before = out + (l - 1) * order, *const two_before = before - order;
        for (int n = 0; n <= l; n++) {
            const double up = n > 0 ? before[n - 1] : 0.0;
            out[l * order + n] = ((2 * l - 1) * up - (l - 1) * two_before[n]) / l;
        }
    }
}

void air_zh_evaluate(int order, double cosine, double *out)
{
    air_legendre(order, cosine, out);
    for (int l = 0; l < order; l++) {
        out[l] *= sqrt((2 * l + 1) / (4.0 * AIR_PI));
    }
}

/* With N_l^m = sqrt((2l+1)/(4 pi) (l-m)!/(l+m)!) P_l^m: N_m^m = s sqrt((2m+1)/(2m)) N_(m-1)^(m-1),
 * N_l^m = a (z N_(l-1)^m - b N_(l-2)^m). Stable for rising l. The root of 2 enters at m = 1. */
void air_sh_factors_init(int order, air_sh_factors *out)
{
    out->order = order;
    out->azimuths = order;
    for (int m = 0; m < order; m++) {
        out->zonal[m] = sqrt((2 * m + 1) / (4.0 * AIR_PI));
        out->sectoral[m] =
            m > 0 ? sqrt((2 * m + 1) / (2.0 * m)) * (m == 1 ? sqrt(2.0) : 1.0) : out->zonal[0];
        for (int l = m + 1; l < order; l++) {
            const double k = l - 1, a = sqrt((4.0 * l * l - 1.0) / (l * l - m * m));
            out->a[l * (l + 1) / 2 + m] = a;
            out->b[l * (l + 1) / 2 + m] = a * sqrt((k * k - m * m) / (4.0 * k * k - 1.0));
        }
    }
}

void air_sh_meridian(const air_sh_factors *factors, double cosine, double sine, double *out)
{
    double sectoral = 1.0;
    for (int m = 0; m < factors->azimuths; m++) {
        sectoral *= factors->sectoral[m] * (m > 0 ? sine : 1.0);
        double before = 0.0, value = sectoral;
        out[m * (m + 1) / 2 + m] = value;
        for (int l = m + 1; l < factors->order; l++) {
            const int i = l * (l + 1) / 2 + m;
            const double next = factors->a[i] * cosine * value - factors->b[i] * before;
            before = value;
            value = next;
            out[i] = value;
        }
    }
}

void air_sh_evaluate(int order, const double dir[3], double *out)
{
    air_sh_factors factors;
    double meridian[AIR_SH_MIRRORED_MAX];
    const double sine = hypot(dir[0], dir[1]);
    const double cos_phi = sine > 0.0 ? dir[0] / sine : 1.0;
    const double sin_phi = sine > 0.0 ? dir[1] / sine : 0.0;
    double cos_m = 1.0, sin_m = 0.0;
    air_sh_factors_init(order, &factors);
    air_sh_meridian(&factors, dir[2], sine, meridian);
    for (int m = 0; m < order; m++) {
        for (int l = m; l < order; l++) {
            const double value = meridian[l * (l + 1) / 2 + m];
            out[l * l + l + m] = value * cos_m;
            if (m > 0) {
                out[l * l + l - m] = value * sin_m;
            }
        }
        const double turned = cos_m * cos_phi - sin_m * sin_phi;
        sin_m = sin_m * cos_phi + cos_m * sin_phi;
        cos_m = turned;
    }
}

double air_zh_scale(int l) { return sqrt(4.0 * AIR_PI / (2 * l + 1)); }

/* The moments I_l of P_l against x^n over [0, 1] follow from I_0 = 1/(n+1), I_1 = 1/(n+2) by
 * I_l = (n - l + 2)/(n + l + 1) I_(l-2). */
void air_zh_cosine_power(int order, double exponent, double *out)
{
    for (int l = 0; l < order; l++) {
        out[l] = l < 2 ? 1.0 / (exponent + 1.0 + l)
                       : out[l - 2] * (exponent - l + 2.0) / (exponent + l + 1.0);
    }
    for (int l = 0; l < order; l++) {
        out[l] *= sqrt((2 * l + 1) * AIR_PI);
    }
}

void air_zh_clamped_cosine(int order, double *out) { air_zh_cosine_power(order, 1.0, out); }

void air_zh_rotate(int order, const double *zh, const double axis[3], double *out_sh)
{
    air_sh_evaluate(order, axis, out_sh);
    for (int l = 0; l < order; l++) {
        for (int m = -l; m <= l; m++) {
            out_sh[l * l + l + m] *= air_zh_scale(l) * zh[l];
        }
    }
}

double air_zh_product(int order, const double *g, const double *h, double cosine)
{
    double previous = 0.0, value = 1.0, sum = 0.0;
    for (int l = 0; l < order; l++) {
        sum += g[l] * h[l] * value;
        const double next = ((2 * l + 1) * cosine * value - l * previous) / (l + 1);
        previous = value;
        value = next;
    }
    return sum;
}
