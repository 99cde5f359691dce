/* arealight_eval.h: S of arealight.h for many points and one lamp at once, in double and in float.
 *
 * The same integrals as air_area_scatter_edge and air_area_scatter_lobes, in vector instructions of
 * the kind that the context has chosen. A point's result depends neither on its neighbours nor on
 * how many there are. No allocation; any number of threads may call at once. Points that a
 * one-sided lamp does not reach, and points or directions that are not finite, give 0. */
#ifndef AIRLIGHT_AREALIGHT_EVAL_H
#define AIRLIGHT_AREALIGHT_EVAL_H

#include "airlight/arealight.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Points in world space and unit vectors from them to the camera, coordinate by coordinate;
 * borrowed. */
typedef struct air_area_shading_points {
    const double *position[3];
    const double *wo[3];
} air_area_shading_points;

typedef struct air_area_shading_points_float {
    const float *position[3];
    const float *wo[3];
} air_area_shading_points_float;

/* S by edges for count points to out_s. |g| above 0.99 counts as 0.99; nodes counts as the nearest
 * in [2, 32], odd numbers cost as much as the next even one. The error depends on nodes as
 * src/arealight/README-eval.md says: 4 give a root mean square of 1e-6 of the mean at |g| = 0.4,
 * 8e-5 at 0.9, 4e-4 at 0.99. */
AIR_API void air_area_eval_edge(const air_context *context, const air_area_lamp *lamp, double g,
                                int nodes, const air_area_shading_points *points, size_t count,
                                double *out_s);
AIR_API void air_area_eval_edge_float(const air_context *context, const air_area_lamp *lamp,
                                      double g, int nodes,
                                      const air_area_shading_points_float *points, size_t count,
                                      float *out_s);

/* S by two lobes, the paper's or mixed ones as lobe says [KT2025]. */
AIR_API void air_area_eval_lobes(const air_context *context, const air_area_lamp *lamp,
                                 const air_area_lobe *lobe, const air_area_shading_points *points,
                                 size_t count, double *out_s);
AIR_API void air_area_eval_lobes_float(const air_context *context, const air_area_lamp *lamp,
                                       const air_area_lobe *lobe,
                                       const air_area_shading_points_float *points, size_t count,
                                       float *out_s);

#ifdef __cplusplus
}
#endif
#endif
