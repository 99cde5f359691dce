/* moment.h: shadows along the rays of one camera in light from infinity, from prefiltered moments
 * of a rectified shadow map [Peters2016, Klehm2014].
 *
 * A kernel: no scene, no files, no allocation per ray. About the axis through the camera towards
 * the light a point has an azimuth, a distance rho from the axis and a height z above the camera,
 * all in metres and radians. All camera rays of one azimuth share a half plane, and each is a
 * straight line z = rho cot(theta) through its corner: a point on it is in shadow iff the first
 * occluder seen from the light at its rho is steeper than the ray. So one row of heights per
 * azimuth, and sums over rho of the moments of their slopes, tell how much of any stretch of any
 * ray is in shadow: in constant time, but only between bounds. Biased: more samples do not help
 * where more than moment_count / 2 depths occlude one ray (thin slats, foliage); for the truth
 * there is shadow.h. */
#ifndef AIRLIGHT_MOMENT_H
#define AIRLIGHT_MOMENT_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct air_moment_params {
    double origin[3];   /* the camera */
    double to_light[3]; /* unit */
    /* Rows: azimuths from begin to end, at most 2 pi apart; with exactly the full circle the last
     * row is the first one's neighbour. */
    double azimuth_begin, azimuth_end;
    double rho_begin, rho_end; /* columns: 0 <= begin < end */
    size_t row_count, column_count;
    uint32_t moment_count; /* 4 or 6 */
    double sigma_t;        /* 1/m, >= 0: weight exp(-sigma_t rho) for all rays of a row */
    double bias;           /* (0, 1]: how far moments are drawn towards those of a spread-out
                              distribution, against rounding */
} air_moment_params;

/* The full circle from rho 0 to 1 about the origin, light from +Y, 1024 rows of 512 columns, no
 * extinction; bias 6e-5 for four moments, 5e-4 for six. */
AIR_API void air_moment_params_default(uint32_t moment_count, air_moment_params *params);

/* Sets azimuths and rho to what the rays from params->origin into the convex hull of some points
 * (the corners of the medium; at least one) need: the full circle if the axis meets the hull. */
AIR_API void air_moment_params_fit(const double (*hull)[3], size_t hull_count,
                                   air_moment_params *params);

/* The host fills the shadow map, row-major, by one ray along -to_light for each row and column:
 * it starts here, at the given height; what it meets first at distance d has height - d for entry.
 * The start must lie above everything. No occluder: -INFINITY. */
AIR_API void air_moment_ray_origin(const air_moment_params *params, size_t row, size_t column,
                                   double height, double out_origin[3]);

typedef struct air_moment_map air_moment_map;

/* Builds the sums over the shadow map, rows in parallel where the context has threads; the same
 * for any number of them. heights: row_count * column_count entries, copied. Holds about
 * 8 (moment_count + 1.5) bytes per entry. AIR_ERROR_ARGUMENT: a parameter out of range, a height
 * that is NaN; AIR_ERROR_MEMORY. On failure *out_map is NULL. */
AIR_API air_status air_moment_map_create(air_context *context, const air_moment_params *params,
                                         const float *heights, air_moment_map **out_map);
AIR_API void air_moment_map_destroy(air_moment_map *map); /* NULL is legal */

/* Which shadow to take between the smallest and the largest that the moments allow. */
typedef struct air_moment_choice {
    /* 0: the lower bound, light may leak; 1: the upper; 0.5: the middle. What lies at the ray's own
     * depth is the difference; for rays through air it holds nothing, so 0 is best. */
    double overestimation;
    /* Blend the sums of the two nearest rows, else take the nearest row. */
    bool blend_rows;
} air_moment_choice;

/* 0, blended. */
AIR_API void air_moment_choice_default(air_moment_choice *choice);

/* The share, in [0, 1], of the light scattered along origin + t dir, t in [begin, end] (0 <= begin
 * < end), that is in shadow: multiply the unoccluded radiance by 1 - share. dir is unit; the ray
 * starts at the map's origin. Beyond the map its border counts. Stretches within one column, those
 * of rays parallel to the light among them, are held against that column's height directly. Never
 * NaN for finite arguments. Thread-safe. */
AIR_API double air_moment_shadow(const air_moment_map *map, const double dir[3], double begin,
                                 double end, const air_moment_choice *choice);

/* The same with the ray's own weight, a function of t >= 0 (exp(-depth) of its profile, say),
 * called for each column of the nearest row that the stretch crosses: shows what the shared weight
 * costs. */
AIR_API double air_moment_shadow_weighted(const air_moment_map *map, const double dir[3],
                                          double begin, double end,
                                          double (*weight)(void *user, double t), void *user,
                                          const air_moment_choice *choice);

#ifdef __cplusplus
}
#endif
#endif
