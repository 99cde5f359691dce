/* polygon.h: the cone of directions from the origin to a convex polygon.
 *
 * Only sums over edges and over a fan are taken. Each edge keeps its vector beside its ends: a
 * small lamp far away has ends that are nearly equal, and a difference taken from normalised or
 * transformed ends would have lost the digits that the given vertices still have. */
#ifndef AIR_AREALIGHT_POLYGON_H
#define AIR_AREALIGHT_POLYGON_H

#include "airlight/arealight.h"
#include "core/triple.h"

enum { AIR_CONE_VERTICES = 2 * AIR_AREA_MAX_VERTICES };

/* Vertices around, not normalised, and the ways to the next ones. */
typedef struct air_cone {
    size_t count;
    double vertices[AIR_CONE_VERTICES][3];
    double edges[AIR_CONE_VERTICES][3];
} air_cone;

/* False (and an empty cone) unless count is in [3, AIR_AREA_MAX_VERTICES]. */
bool air_cone_make(const double (*polygon)[3], size_t count, air_cone *out);

/* What of a cone made by air_cone_make lies where axis.v >= 0, by [Sutherland1974]: no vertices or
 * at least 3. */
void air_cone_clip(const air_cone *cone, const double axis[3], air_cone *out);

/* The normal of the whole outline, twice the area long. */
void air_cone_normal(const air_cone *cone, double out[3]);

double air_cone_solid_angle(const air_cone *cone);

/* The integral of max(axis.w, 0)/pi over the cone; axis unit. Clips by itself. */
double air_cone_irradiance(const air_cone *cone, const double axis[3]);

/* A place on an edge: its vertex and the way from there, apart for the sake of small lamps. */
typedef struct air_edge_place {
    double vertex[3], way[3];
} air_edge_place;

/* The places where a polygon's outline passes the plane across an axis, and the arcs in that plane
 * that close what is above. Nothing is assumed of how often it passes: rounding may add pairs. */
typedef struct air_horizon {
    double angle; /* sum of the arcs, counter-clockwise about the axis */
    air_edge_place first_up, last_down;
    bool starts_below, is_below;
} air_horizon;

/* The outline passes at a share of the edge from the vertex, upwards or downwards; to be called in
 * order around the polygon. */
void air_horizon_pass(air_horizon *self, const double axis[3], const double vertex[3],
                      const double edge[3], double share, bool upwards);
/* The sum of all arcs. */
double air_horizon_angle(air_horizon *self, const double axis[3]);

/* The share of an edge, its ends on both sides of the plane, up to where its height is 0. */
static inline double air_horizon_share(double height0, double height1)
{
    return height0 / (height0 - height1);
}

#endif
