/* receiver.c: coefficients against receivers' lobes. */
#include <math.h>

#include "airlight/impulse.h"
#include "core/harmonics.h"
#include "core/vec.h"

air_impulse_place air_impulse_place_of(const double x[3], const double n[3], const double x_s[3],
                                       const double n_s[3])
{
    double l[3], square = 0.0, n_l = 0.0, s_l = 0.0, n_s_n = 0.0;
    for (int k = 0; k < 3; k++) {
        l[k] = x_s[k] - x[k];
        square += l[k] * l[k];
    }
    const double d = sqrt(square);
    for (int k = 0; k < 3; k++) {
        l[k] /= d;
        n_l += n[k] * l[k];
        s_l += n_s[k] * l[k];
        n_s_n += n_s[k] * n[k];
    }
    /* Near s_l = +-1 the azimuth loses its meaning together with what depends on it. */
    const double across = sqrt(double_max(1e-12, 1.0 - s_l * s_l));
    const double n_x = (n_s_n - s_l * n_l) / across;
    return (air_impulse_place){
        .distance = d, .n_l = n_l, .cos_s = -s_l, .n_x = double_max(-1.0, double_min(1.0, n_x))};
}

void air_impulse_lobe_cosine(int order, double exponent, double *out)
{
    air_zh_cosine_power(order, exponent, out);
}

void air_impulse_lobe_radiance(int order, double *out) { air_zh_evaluate(order, 1.0, out); }

double air_impulse_zonal_receive(int order, const double *zh, const double *lobe, double a_l)
{
    return air_zh_product(order, zh, lobe, a_l);
}

/* The sum of n_l lobe_l c_lm y_lm(a): y_lm is that of the meridian times cos(m phi), by
 * Chebyshev's recurrence in cos(phi) = a_x/sin(theta). */
double air_impulse_mirrored_receive(int order, const double *sh, const double *lobe, double a_l,
                                    double a_x)
{
    air_sh_factors factors;
    double y[AIR_SH_MIRRORED_MAX], sum = 0.0, before = 0.0, cos_m = 1.0;
    const double sine = sqrt(double_max(0.0, 1.0 - a_l * a_l));
    const double cos_phi = sine > 0.0 ? double_max(-1.0, double_min(1.0, a_x / sine)) : 1.0;
    air_sh_factors_init(order, &factors);
    air_sh_meridian(&factors, a_l, sine, y);
    for (int m = 0; m < order; m++) {
        for (int l = m; l < order; l++) {
            const int c = l * (l + 1) / 2 + m;
            sum += air_zh_scale(l) * lobe[l] * sh[c] * y[c] * cos_m;
        }
        const double next = m == 0 ? cos_phi : 2.0 * cos_phi * cos_m - before;
        before = cos_m;
        cos_m = next;
    }
    return sum;
}

double air_impulse_floor_backscatter(double alpha, double radiosity)
{
    return alpha * (2.0 / 3.0) * (1.0 - log(2.0)) * radiosity;
}
