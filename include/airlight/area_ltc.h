/* area_ltc.h: GGX over a polygon by linearly transformed cosines [Heitz2016].
 *
 * The lobe is f cos = D G2 / (4 cos_o): GGX with height-correlated Smith shadowing, Fresnel term 1.
 * It is near its albedo times a clamped cosine, linearly transformed and cut at the surface: the
 * matrix is fitted to what is left above, brought to 1; the integral over a polygon is that of the
 * cosine over the polygon transformed back. */
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
 * Mead's method on a fixed quadrature; some 15 ms. No allocation. */
AIR_API air_area_ltc air_area_ltc_fit(double alpha, double cos_o);

/* The share of the lobe that lies in the polygon, in [0, 1]: times the albedo it is near the
 * integral of f cos. normal and wo are unit. */
AIR_API double air_area_ltc_share(const air_area_ltc *ltc, const double (*polygon)[3], size_t count,
                                  const double normal[3], const double wo[3]);

/* ---- tables ---- */

enum { AIR_LTC_SIDE = 24 };

/* Fits at alpha i and angle j. */
typedef struct air_area_ltc_table {
    air_area_ltc knots[AIR_LTC_SIDE][AIR_LTC_SIDE];
} air_area_ltc_table;

/* alpha of knots[i], its root even from that of 0.001 to 1; cos_o of knots[][j], acos(sqrt(cos_o))
 * even from 0 to a right angle. */
AIR_API double air_area_ltc_knot_alpha(size_t i);
AIR_API double air_area_ltc_knot_cosine(size_t j);

/* All fits, on the context's threads; some 10 s of processor time. The same for any number of
 * threads. */
AIR_API void air_area_ltc_table_fit(air_context *context, air_area_ltc_table *out);

/* The table that the library carries. Static, never freed. */
AIR_API const air_area_ltc_table *air_area_ltc_table_default(void);

/* Linear between the knots; beyond them the nearest. */
AIR_API air_area_ltc air_area_ltc_at(const air_area_ltc_table *table, double alpha, double cos_o);

/* To and from a file (JSON, docs/table-format.md), as air_area_table_save and _load. */
AIR_API air_status air_area_ltc_table_save(air_context *context, const air_area_ltc_table *table,
                                           const char *path);
AIR_API air_status air_area_ltc_table_load(air_context *context, const char *path,
                                           air_area_ltc_table *out);

/* Does a file say that it is such a table, or one of lobes? Else AIR_ERROR_FORMAT. */
AIR_API air_status air_area_table_is_ltc(air_context *context, const char *path, bool *out_is_ltc);

#ifdef __cplusplus
}
#endif
#endif
