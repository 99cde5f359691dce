/* polynomial.h: the irradiance of coefficients as a polynomial in the receiver's normal. */
#ifndef AIR_IMPULSE_POLYNOMIAL_H
#define AIR_IMPULSE_POLYNOMIAL_H

enum {
    ZONAL_POWERS = 8, /* 1, z, z^2, z^4, z^6, z^8, z^10, none; z = n.l */
    AREA_POWERS = 12  /* 1, z, x, z^2, xz, x^2, z^4, xz^3, x^2 z^2, x^3 z, x^4, none; x = n.x */
};

/* All bands of zonal coefficients. */
void impulse_zonal_polynomial(const double *zh, double *out);

/* Bands 0..4 of mirrored coefficients, and its value. */
void impulse_area_polynomial(const double *sh, double *out);
double impulse_area_polynomial_at(const double *polynomial, double z, double x);

#endif
