/* collimated.h: single scattering of light from infinity in homogeneous convex media, in closed
 * form [Velinov2021].
 *
 * A kernel: plain functions over the caller's arrays, no scene, no files, no threads of its own, no
 * allocation per ray. Doubles throughout. A ray is origin + t dir with dir unit, t in metres;
 * to_light is the unit vector from a scattering point towards the light. Along a ray the optical
 * depth camera - point - light is continuous and piecewise affine in t (it may jump where the light
 * runs parallel to a face), so its exponential is integrated, sampled and inverted piece by piece.
 * What is not finite in a ray gives an empty profile: zero, never NaN. */
#ifndef AIRLIGHT_COLLIMATED_H
#define AIRLIGHT_COLLIMATED_H

#include <stdbool.h>

#include "airlight/context.h"
#include "airlight/interval.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- media ---- */

enum { AIR_COLLIMATED_MAX_PLANES = 40 };

/* A convex medium: the points with n.x <= h for all planes (n.x, n.y, n.z, h); n points out and has
 * any length. No plane: all of space. Contradicting planes: nothing, T = 0. */
typedef struct air_collimated_medium {
    size_t plane_count;
    double planes[AIR_COLLIMATED_MAX_PLANES][4];
} air_collimated_medium;

/* AIR_ERROR_ARGUMENT (told to context, which may be NULL): more than AIR_COLLIMATED_MAX_PLANES
 * planes, a normal that is 0, a number that is not finite; the message names the plane. */
AIR_API air_status air_collimated_medium_from_planes(air_context *context,
                                                     const double (*planes)[4], size_t plane_count,
                                                     air_collimated_medium *out);

/* From the 3 x 4 matrix (row-major) that maps the world to box coordinates, in which the box is
 * [-1, 1]^3. AIR_ERROR_ARGUMENT: not finite, or its linear part is singular to within rounding. */
AIR_API air_status air_collimated_medium_from_box(air_context *context,
                                                  const double world_to_box[12],
                                                  air_collimated_medium *out);

/* [a, b]: the stretch of the ray inside the medium, from 0 to t_max (which may be INFINITY). False
 * if there is none. */
AIR_API bool air_collimated_interval(const air_collimated_medium *medium, const double origin[3],
                                     const double dir[3], double t_max, air_interval *out);

/* d_m: the distance from a point inside to the boundary towards the light; INFINITY if no face
 * stops it. 0 for points outside a face that the light crosses. */
AIR_API double air_collimated_boundary_distance(const air_collimated_medium *medium,
                                                const double to_light[3], const double point[3]);

/* ---- profiles: the optical depth along one ray ---- */

/* A stretch on which depths are affine. */
typedef struct air_collimated_piece {
    double t0, t1;           /* t0 < t1 */
    double depth0, depth1;   /* at the ends: camera to point to where the light came in */
    double camera0, camera1; /* the part of it from the camera to the point */
    double weight;           /* factor on the integrand: 1, or sigma_s times phase function */
    double before; /* integral over the pieces before, times exp(least_depth): set with the rest */
} air_collimated_piece;

/* The integrand weight exp(-depth) along a ray. Its integral is exp(-least_depth) * scaled; kept
 * apart, so that sampling still works where the integral itself underflows. */
typedef struct air_collimated_profile {
    air_collimated_piece *pieces; /* the caller's array */
    size_t capacity;              /* its length; set by the caller, like pieces */
    size_t count;                 /* 0: the ray misses, everything is 0 */
    double least_depth;           /* M: the smallest depth at the end of a piece */
    double scaled;                /* Ts */
} air_collimated_profile;

/* Pieces that a profile in one convex medium needs at most. */
enum { AIR_COLLIMATED_MAX_PIECES = AIR_COLLIMATED_MAX_PLANES };

/* The profile of one convex medium of extinction sigma_t (1/m, >= 0), up to the first surface at
 * t_max; weight 1. The capacity must be at least the number of faces towards the light (1 at
 * least). A stretch without end is cut where nothing comes through any more; without extinction it
 * has no integral, and the profile is empty. Fog without end towards the light is dark: empty too.
 */
AIR_API void air_collimated_profile_make(const air_collimated_medium *medium,
                                         const double to_light[3], double sigma_t,
                                         const double origin[3], const double dir[3], double t_max,
                                         air_collimated_profile *profile);

/* One convex cell of a piecewise constant medium. Cells may touch (slabs, convex pieces of a
 * concave medium), nest or overlap: coefficients add. */
typedef struct air_collimated_cell {
    air_collimated_medium medium;
    double sigma_t; /* 1/m, >= 0 */
    double weight;  /* added to the integrand's factor inside the cell: 1, or sigma_s times phase */
} air_collimated_cell;

/* How many pieces any ray through these cells needs at most. */
AIR_API size_t air_collimated_cells_piece_limit(const air_collimated_cell *cells, size_t count);

/* The profile through all cells together. capacity: air_collimated_cells_piece_limit at least.
 * Stretches of weight 0, and those whose way to the light has no end, are left out. Coefficients
 * that are negative or not finite give an empty profile. */
AIR_API void air_collimated_profile_make_cells(const air_collimated_cell *cells, size_t count,
                                               const double to_light[3], const double origin[3],
                                               const double dir[3], double t_max,
                                               air_collimated_profile *profile);

/* The part of a profile inside a list of sorted disjoint intervals (windows of a gobo, lit
 * stretches). out has its own pieces: capacity of profile->count + interval_count at least. */
AIR_API void air_collimated_profile_restrict(const air_collimated_profile *profile,
                                             const air_interval *intervals, size_t interval_count,
                                             air_collimated_profile *out);

/* T = integral of weight exp(-depth), in metres times weight; 0 where it underflows. */
AIR_API double air_collimated_integral(const air_collimated_profile *profile);
/* log T; -INFINITY for an empty profile; no underflow. */
AIR_API double air_collimated_log_integral(const air_collimated_profile *profile);
/* The integral over [begin, end] only. */
AIR_API double air_collimated_partial_integral(const air_collimated_profile *profile, double begin,
                                               double end);
/* weight exp(-depth) at t; 0 outside the pieces. */
AIR_API double air_collimated_integrand(const air_collimated_profile *profile, double t);

/* Whole-volume sampling: t with density integrand/T. u in [0, 1). The profile must not be empty. */
AIR_API double air_collimated_sample(const air_collimated_profile *profile, double u);
AIR_API double air_collimated_sample_pdf(const air_collimated_profile *profile, double t);
AIR_API double air_collimated_sample_cdf(const air_collimated_profile *profile, double t);

/* ---- estimators ---- */

/* How one number u becomes one sample of the light that a profile's ray receives. */
typedef enum air_collimated_estimator {
    AIR_COLLIMATED_RM = 0,   /* t uniform */
    AIR_COLLIMATED_DS = 1,   /* t in proportion to extinction, truncated to the pieces; uniform if
                                none extinguishes (one that does not among others that do is never
                                met: scattering without extinction is not physical) */
    AIR_COLLIMATED_WVDS = 2, /* t by whole-volume sampling: only visibility is left to chance */
    AIR_COLLIMATED_REES = 3, /* ratio estimator over uniform t */
    AIR_COLLIMATED_REDS = 4, /* ratio estimator over t in proportion to extinction */
    AIR_COLLIMATED_ESTIMATOR_COUNT = 5
} air_collimated_estimator;

/* With V the visibility (0 or 1) of the point at t, averages over samples estimate the integral of
 * weight exp(-depth) V: plain estimators by the mean of unoccluded * V; ratio estimators by
 * mean(analytic) * sum(unoccluded * V) / sum(unoccluded), three sums that are never divided per
 * sample. */
typedef struct air_collimated_draw {
    double t;
    double analytic;   /* the integral */
    double unoccluded; /* integrand over density */
} air_collimated_draw;

/* Does the estimator keep three sums? */
AIR_API bool air_collimated_estimator_is_ratio(air_collimated_estimator estimator);

/* One sample for u in [0, 1). An empty profile gives all zeros. */
AIR_API air_collimated_draw air_collimated_estimate(air_collimated_estimator estimator,
                                                    const air_collimated_profile *profile,
                                                    double u);

/* The density with which the estimator draws t; 0 outside the pieces. */
AIR_API double air_collimated_estimate_pdf(air_collimated_estimator estimator,
                                           const air_collimated_profile *profile, double t);

/* ---- many rays at once ---- */

/* Rays as structures of arrays, count doubles each, borrowed. */
typedef struct air_collimated_rays {
    const double *origin[3];
    const double *dir[3];
    const double *t_max; /* NULL: INFINITY */
} air_collimated_rays;

/* T, and log T where out_log is not NULL, of many rays through one medium: as
 * air_collimated_profile_make and air_collimated_integral give them, by the context's instruction
 * set: within 1e-12 relatively, or within a few roundings of t where those count for more (grazing
 * light, a stretch far from the origin or very thin). Thread-safe; the caller splits the work. */
AIR_API void air_collimated_eval(const air_context *context, const air_collimated_medium *medium,
                                 const double to_light[3], double sigma_t,
                                 const air_collimated_rays *rays, size_t count, double *out_t,
                                 double *out_log);

/* ---- windows of a gobo ---- */

/* The stretches of a ray within [begin, end] that pass a window: a simple polygon, convex or
 * concave, swept along the light both ways. window: 2 doubles per vertex, in the plane of the unit
 * vectors axis_s, axis_t perpendicular to the light. At most vertex_count / 2 + 1 intervals. */
AIR_API size_t air_collimated_window(const double *window, size_t vertex_count,
                                     const double axis_s[3], const double axis_t[3],
                                     const double origin[3], const double dir[3], double begin,
                                     double end, air_interval *out);

/* ---- sums, many draws, several lights ---- */

/* Sums over samples, and over the vertices of walks. Plain estimators: occluded / samples. Ratio
 * estimators: analytic / samples * occluded / unoccluded (0 where unoccluded is 0). Sums of frames
 * add up; ratios of frames must not be averaged: at few samples each is biased. */
typedef struct air_collimated_sums {
    double analytic;   /* of the integrals */
    double unoccluded; /* of integrand over density */
    double occluded;   /* the same where the light is visible */
} air_collimated_sums;

/* The host's visibility: sets occluded[i] to 1 if something opaque lies between point i and the
 * light, else 0. points: x, y and z apart. */
typedef void (*air_collimated_occluded)(void *user, const double *const points[3], size_t count,
                                        uint8_t *occluded);

/* Many draws along one ray, from count numbers u in [0, 1) that never fall (u[i] <= u[i+1]), by the
 * context's instruction set (NULL: plain C). out_t is as air_collimated_estimate gives it, within
 * 1e-12 of the distance where the ray leaves; out_unoccluded (may be NULL) within 1e-12 relatively,
 * or 0 beyond optical depths of 700. An empty profile gives zeros. Thread-safe. */
AIR_API void air_collimated_draw_many(const air_context *context,
                                      air_collimated_estimator estimator,
                                      const air_collimated_profile *profile, const double *u,
                                      size_t count, double *out_t, double *out_unoccluded);

/* The sums over count such draws with visibility; asks for up to 256 points at a time. */
AIR_API air_collimated_sums air_collimated_gather(const air_context *context,
                                                  air_collimated_estimator estimator,
                                                  const air_collimated_profile *profile,
                                                  const double origin[3], const double dir[3],
                                                  const double *u, size_t count,
                                                  air_collimated_occluded occluded, void *user);

/* Chooses one of several lights in proportion to what each gives if nothing blocks it: phase times
 * irradiance times integral. Returns its index; *rest is u within its share, a number in [0, 1) for
 * a draw. With whole-volume draws, the sum of all contributions times the mean visibility is the
 * estimate [Velinov2021, sec. 5]. u in [0, 1); count > 0; with nothing positive the index is 0. */
AIR_API size_t air_collimated_choose(const double *contributions, size_t count, double u,
                                     double *rest);

#ifdef __cplusplus
}
#endif
#endif
