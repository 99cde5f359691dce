/* polynomial.c: bands against a clamped cosine, in powers. */
#include "impulse/polynomial.h"

#include <math.h>

#include "core/harmonics.h"
#include "core/vec.h"
#include "impulse/multiple.h"

/* The sum of A_l c_l P_l(z) in powers of z. */
void impulse_zonal_polynomial(const double *zh, double *out)
{
    double powers[AIR_IMPULSE_ORDER * AIR_IMPULSE_ORDER];
    double lobe[AIR_IMPULSE_ORDER], sum[AIR_IMPULSE_ORDER] = {0.0};
    air_zh_clamped_cosine(AIR_IMPULSE_ORDER, lobe);
    air_legendre_powers(AIR_IMPULSE_ORDER, powers);
    for (int l = 0; l < AIR_IMPULSE_ORDER; l++) {
        for (int n = 0; n <= l; n++) {
            sum[n] += lobe[l] * zh[l] * powers[l * AIR_IMPULSE_ORDER + n];
        }
    }
    for (int i = 0; i < ZONAL_POWERS; i++) {
        out[i] = i < CLAMPED_BANDS ? sum[clamped_band(i)] : 0.0;
    }
}

/* The sum of n_l A_l c_lm y_lm in powers of z and x, with y^2 = 1 - x^2 - z^2. Per band, n_l A_l is
 * pi, 2 pi/3, pi/4, 0 and -pi/24. */
void impulse_area_polynomial(const double *sh, double *out)
{
    const double a0 = AIR_PI, a1 = 2.0 * AIR_PI / 3.0, a2 = AIR_PI / 4.0, a4 = -AIR_PI / 24.0;
    const double k1 = sqrt(3.0 / (4.0 * AIR_PI)), k20 = sqrt(5.0 / (16.0 * AIR_PI));
    const double k21 = sqrt(15.0 / (4.0 * AIR_PI)), k40 = 3.0 / 16.0 / sqrt(AIR_PI);
    const double k41 = 0.75 * sqrt(2.5 / AIR_PI), k42 = 0.375 * sqrt(5.0 / AIR_PI);
    const double k43 = 0.75 * sqrt(17.5 / AIR_PI), k44 = 3.0 / 16.0 * sqrt(35.0 / AIR_PI);
    const double c20 = a2 * k20 * sh[3], c21 = a2 * k21 * sh[4], c22 = 0.5 * a2 * k21 * sh[5];
    const double c40 = a4 * k40 * sh[10], c41 = a4 * k41 * sh[11], c42 = a4 * k42 * sh[12];
    const double c43 = a4 * k43 * sh[13], c44 = a4 * k44 * sh[14];
    out[0] = a0 * sh[0] / sqrt(4.0 * AIR_PI) - c20 - c22 + 3.0 * c40 + c42 + c44;
    out[1] = a1 * k1 * sh[1];
    out[2] = a1 * k1 * sh[2];
    out[3] = 3.0 * c20 + c22 - 30.0 * c40 - 8.0 * c42 - 2.0 * c44;
    out[4] = c21 - 3.0 * c41 - 3.0 * c43;
    out[5] = 2.0 * c22 - 2.0 * c42 - 8.0 * c44;
    out[6] = 35.0 * c40 + 7.0 * c42 + c44;
    out[7] = 7.0 * c41 + 3.0 * c43;
    out[8] = 14.0 * c42 + 8.0 * c44;
    out[9] = 4.0 * c43;
    out[10] = 8.0 * c44;
    out[11] = 0.0;
}

double impulse_area_polynomial_at(const double *polynomial, double z, double x)
{
    const double z2 = z * z, x2 = x * x, xz = x * z;
    const double powers[AREA_POWERS] = {1.0,     z,       x,       z2,      xz,      x2,
                                        z2 * z2, xz * z2, x2 * z2, xz * x2, x2 * x2, 0.0};
    double sum = 0.0;
    for (int i = 0; i < AREA_POWERS; i++) {
        sum += polynomial[i] * powers[i];
    }
    return sum;
}
