/* area_ltc.h: GGX over a polygon by linearly transformed cosines [Heitz2016].
 *
 * The lobe is f cos = D G2 / (4 cos_o): GGX with height-correlated Smith shadowing, Fresnel term 1.
 * It is near its albedo times a clamped cosine, linearly transformed: the matrix is fitted, the
 * integral over a polygon is that of the cosine over the polygon transformed back. */
#ifndef AIRLIGHT_AREA_LTC_H
#define AIRLIGHT_AREA_LTC_H

#include "airlight/arealight.h"

#ifdef __cplusplus
extern "C" {
#endif

/* In the frame with z along the normal and x along the projection of wo, the transformation back
 * is, up to a factor, ((xx, 0, xz), (0, 1, 0), (zx, 0, zz)). albedo: the integral of f cos. */
typedef struct air_area_ltc {
    double xx, xz, zx, zz;
    double albedo;
} air_area_ltc;

/* The fit for alpha in [0.001, 1] and cos_o in [0, 1] (beyond, that of the nearest), by Nelder and
 * Mead's method on a fixed quadrature; 2 to 20 ms. No allocation. */
AIR_API air_area_ltc air_area_ltc_fit(double alpha, double cos_o);

/* The same from the table that the library carries, linear between its knots. */
AIR_API air_area_ltc air_area_ltc_ggx(double alpha, double cos_o);

/* The share of the lobe that lies in the polygon, in [0, 1]: times the albedo it is near the
 * integral of f cos. What a fit puts below the surface is lost: at grazing angles up to 16 % of
 * the lobe. normal and wo are unit. */
AIR_API double air_area_ltc_share(const air_area_ltc *ltc, const double (*polygon)[3], size_t count,
                                  const double normal[3], const double wo[3]);

#ifdef __cplusplus
}
#endif
#endif
