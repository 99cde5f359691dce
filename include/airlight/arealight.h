/* arealight.h: light of flat polygonal lamps, scattered once in haze of constant density [KT2025].
 *
 * A kernel: plain functions over the caller's arrays, no scene, no files, no threads of its own, no
 * allocation. Doubles unless a name ends in _float.
 *
 * The point at hand is the origin: polygons are given by their vertices less the point, in either
 * order around. wo and wi are unit vectors from the point, to the camera and to the light. The
 * phase function is that of Henyey and Greenstein,
 *     p = (1 - g^2) / (4 pi (1 + g^2 + 2 g wo.wi)^1.5),
 * g > 0 scatters forward. With S the integral of p over the directions to a lamp of radiance L, the
 * radiance scattered towards the camera per unit length is sigma_s L tau S, tau being a mean
 * transmittance of the ways to the lamp. */
#ifndef AIRLIGHT_AREALIGHT_H
#define AIRLIGHT_AREALIGHT_H

#include <stdbool.h>

#include "airlight/context.h"
#include "airlight/interval.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- polygons ---- */

enum { AIR_AREA_MAX_VERTICES = 16 };

/* A lamp: a convex planar polygon in world space. */
typedef struct air_area_lamp {
    size_t vertex_count;
    double vertices[AIR_AREA_MAX_VERTICES][3];
    double normal[3]; /* unit; on the side from which the vertices run counter-clockwise: that to
                         which a one-sided lamp emits */
    double centre[3]; /* of gravity */
    double area;      /* m^2, > 0 */
    bool two_sided;
} air_area_lamp;

/* vertices: 3 doubles each, copied. AIR_ERROR_ARGUMENT (told to context, which may be NULL; the
 * message names the vertex): fewer than 3 or more than AIR_AREA_MAX_VERTICES, not finite, no area,
 * out of plane by more than 1e-4 of its size, not convex or crossing itself. On failure *out is
 * untouched. */
AIR_API air_status air_area_lamp_make(air_context *context, const double (*vertices)[3],
                                      size_t vertex_count, bool two_sided, air_area_lamp *out);

/* The lamp's vertices less the point; false if the lamp is one-sided and the point is not in front
 * of it (then nothing arrives). */
AIR_API bool air_area_lamp_seen_from(const air_area_lamp *lamp, const double point[3],
                                     double (*out)[3]);

/* The solid angle, in [0, 4 pi) (0 for a point in the plane outside of the polygon). */
AIR_API double air_area_solid_angle(const double (*polygon)[3], size_t count);

/* E: the integral of max(normal.wi, 0) / pi, in [0, 1]; normal unit. */
AIR_API double air_area_irradiance(const double (*polygon)[3], size_t count,
                                   const double normal[3]);

/* The distance to the nearest point of the polygon, its inside included. */
AIR_API double air_area_min_distance(const double (*polygon)[3], size_t count);

/* ---- S: the phase function over a polygon ---- */

/* By the polygon's edges: exact but for a quadrature of `nodes` points per edge, in [2, 32]. */
AIR_API double air_area_scatter_edge(const double (*polygon)[3], size_t count, const double wo[3],
                                     double g, int nodes);

/* The number of nodes for a relative error near 1e-3: 4 up to |g| = 0.6, 6 to 0.9, 8 to 0.95, 12
 * beyond. */
AIR_API int air_area_edge_nodes(double g);

/* The phase function as two linearly transformed spherical distributions, one per hemisphere about
 * its peak: each has the half's share of the whole and is, in directions stretched by s along the
 * axis, the density (1 - w) / (2 pi) + w cos / pi. The paper's has w = 1 (clamped cosine) on the
 * near half and w = -1 (inverse) on the far one. */
typedef struct air_area_lobe {
    double g;
    double s_near, w_near; /* half around the peak */
    double s_far, w_far;
} air_area_lobe;

/* From the tables that the library carries, for |g| <= 0.99 (beyond, that of 0.99): LTSD is the
 * paper's model, MIX fits w too and is continuous through g = 0. */
AIR_API air_area_lobe air_area_lobe_ltsd(double g);
AIR_API air_area_lobe air_area_lobe_mix(double g);

/* S by two lobes. Where g = 0 the exact answer, a solid angle over 4 pi. */
AIR_API double air_area_scatter_lobes(const double (*polygon)[3], size_t count, const double wo[3],
                                      const air_area_lobe *lobe);

/* The same for Rayleigh's phase function, 3/(16 pi) (1 + cos^2): exact but for the last digits. */
AIR_API double air_area_scatter_rayleigh(const double (*polygon)[3], size_t count,
                                         const double wo[3]);

/* ---- transmittance ---- */

/* The integral of exp(-sigma_t distance) over the polygon's directions, its quotient by the solid
 * angle being the mean transmittance; exact but for a quadrature of `nodes` per edge, in [2, 48].
 */
AIR_API double air_area_transmitted_solid_angle(const double (*polygon)[3], size_t count,
                                                double sigma_t, int nodes);

enum { AIR_AREA_MAX_CUBATURE = 8, AIR_AREA_MAX_POINTS = 14 * 64 };

/* m x m Gauss points, m in [1, AIR_AREA_MAX_CUBATURE], on a quadrilateral, on a triangle, or on
 * each triangle of a fan: positions (world space) and weights that sum to the area. points and
 * weights have room for AIR_AREA_MAX_POINTS. Returns how many there are. */
AIR_API size_t air_area_lamp_points(const air_area_lamp *lamp, int m, double (*points)[3],
                                    double *weights);

/* ---- along a ray ---- */

typedef enum air_area_rule {
    AIR_AREA_RIEMANN = 0,    /* midpoints of equal steps, the paper's */
    AIR_AREA_GAUSS = 1,      /* Gauss-Legendre over the length */
    AIR_AREA_OPTICAL = 2,    /* Gauss-Legendre over equal optical depth */
    AIR_AREA_EQUIANGULAR = 3 /* Gauss-Legendre over the angle at the lamp, which is regularised by
                                its area; the default */
} air_area_rule;

/* The part of [0, t_max] of origin + t dir (dir unit; t_max may be INFINITY) in front of the lamp;
 * false if there is none. All of it for two-sided lamps. */
AIR_API bool air_area_lit_interval(const air_area_lamp *lamp, const double origin[3],
                                   const double dir[3], double t_max, air_interval *out);

enum { AIR_AREA_MAX_NODES = 512 };

/* count nodes t[i] in the interval, increasing, and weights w[i]: the integral of f is near
 * sum w[i] f(t[i]). sigma_t is that of the medium (AIR_AREA_OPTICAL alone asks for it). An endless
 * interval is legal with AIR_AREA_EQUIANGULAR, and with AIR_AREA_OPTICAL where sigma_t > 0. */
AIR_API void air_area_line_nodes(air_area_rule rule, const air_area_lamp *lamp,
                                 const double origin[3], const double dir[3], air_interval interval,
                                 double sigma_t, size_t count, double *t, double *w);

/* A distance in the interval for the number u in [0, 1) with the density of the regularised angle;
 * its density goes to *out_pdf (1/m). */
AIR_API double air_area_sample_distance(const air_area_lamp *lamp, const double origin[3],
                                        const double dir[3], air_interval interval, double u,
                                        double *out_pdf);

#ifdef __cplusplus
}
#endif
#endif
