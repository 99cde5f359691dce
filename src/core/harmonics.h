/* harmonics.h: real spherical harmonics without Condon and Shortley's phase, zonal harmonics.
 *
 * y_lm = sqrt2 K_lm cos(m phi) P_l^m(z) for m > 0, K_l0 P_l(z), sqrt2 K_lm sin(|m| phi) P_l^|m|(z)
 * for m < 0, with P_l^m = (1-z^2)^(m/2) d^m P_l/dz^m and K_lm^2 = (2l+1)/(4 pi) (l-|m|)!/(l+|m|)!.
 * Bands 0..2: 0.282095, 0.488603 (y, z, x), 1.092548 (xy, yz), 0.315392 (3z^2-1), 1.092548 xz,
 * 0.546274 (x^2-y^2). Coefficients of any function: index l*l + l + m; of one that is mirrored in
 * the plane phi = 0, cosines only: l*(l+1)/2 + m. "Order n" is bands 0..n-1. */
#ifndef AIR_CORE_HARMONICS_H
#define AIR_CORE_HARMONICS_H

#include <stddef.h>

enum {
    AIR_SH_ORDER_MAX = 11,
    AIR_SH_COUNT_MAX = AIR_SH_ORDER_MAX * AIR_SH_ORDER_MAX,
    AIR_SH_MIRRORED_MAX = AIR_SH_ORDER_MAX * (AIR_SH_ORDER_MAX + 1) / 2
};

/* P_0 .. P_(order-1) at x in [-1, 1]; order >= 1, of any size. */
void air_legendre(int order, double x, double *out);

/* P_l in powers: out[l * order + n] goes with x^n. order * order numbers. */
void air_legendre_powers(int order, double *out);

/* The zonal y_l = sqrt((2l+1)/(4 pi)) P_l of the cosine to the axis. */
void air_zh_evaluate(int order, double cosine, double *out);

/* Factors of the recurrences, for those who evaluate often. */
typedef struct air_sh_factors {
    int order;
    int azimuths;                      /* m < azimuths are computed; init sets order */
    double zonal[AIR_SH_ORDER_MAX];    /* sqrt((2l+1)/(4 pi)) */
    double sectoral[AIR_SH_ORDER_MAX]; /* y_mm = sectoral sine y_(m-1)(m-1) */
    double a[AIR_SH_MIRRORED_MAX];     /* y_lm = a cosine y_(l-1)m - b y_(l-2)m */
    double b[AIR_SH_MIRRORED_MAX];
} air_sh_factors;

/* 1 <= order <= AIR_SH_ORDER_MAX, here and below. */
void air_sh_factors_init(int order, air_sh_factors *out);

/* y_lm(theta, phi = 0) for 0 <= m <= l, at l*(l+1)/2 + m: y_lm(theta, phi) is cos(m phi) times it.
 * sine >= 0. */
void air_sh_meridian(const air_sh_factors *factors, double cosine, double sine, double *out);

/* All y_lm of a unit direction. */
void air_sh_evaluate(int order, const double dir[3], double *out);

/* Bands 0..2, written out. */
static inline void air_sh_evaluate_3(const float dir[3], float out[9])
{
    const float x = dir[0], y = dir[1], z = dir[2];
    out[0] = 0.28209479f;
    out[1] = 0.48860251f * y;
    out[2] = 0.48860251f * z;
    out[3] = 0.48860251f * x;
    out[4] = 1.09254843f * x * y;
    out[5] = 1.09254843f * y * z;
    out[6] = 0.31539157f * (3.0f * z * z - 1.0f);
    out[7] = 1.09254843f * x * z;
    out[8] = 0.54627422f * (x * x - y * y);
}

/* The band of coefficient i of these nine. */
static inline int air_sh_band_3(int i) { return (i > 0) + (i > 3); }

/* n_l = sqrt(4 pi/(2l+1)). */
double air_zh_scale(int l);

/* Zonal coefficients of max(0, cos): sqrt(pi)/2, sqrt(pi/3), and 0 for odd l >= 3. */
void air_zh_clamped_cosine(int order, double *out);

/* Zonal coefficients of max(0, cos)^exponent, exponent > -1. */
void air_zh_cosine_power(int order, double exponent, double *out);

/* Coefficients of a zonal function turned to a unit axis: n_l zh_l y_lm(axis). */
void air_zh_rotate(int order, const double *zh, const double axis[3], double *out_sh);

/* The integral of the product of two zonal functions whose axes enclose the angle with this
 * cosine: the sum of g_l h_l P_l(cosine). */
double air_zh_product(int order, const double *g, const double *h, double cosine);

#endif
