/* scatter_rayleigh.c: Rayleigh's phase function over a polygon, in closed form: by the axial moment
 * of second order [Arvo1995]. */
#include "arealight/polygon.h"
#include "core/vec.h"

/* The integral of (wo.w) along an edge, times (normal.wo) of its great circle: on it w turns by
 * dw/du = normal x w, so w integrates to normal x (from - to). */
static double edge_moment(const double wo[3], const double from[3], const double way[3],
                          const double to[3])
{
    double normal[3], turned[3], difference[3];
    air_cross3(from, way, normal);
    const double length = air_length3(normal);
    if (!(length > 0.0)) {
        return 0.0;
    }
    const double scale_from = 1.0 / air_length3(from), scale_to = 1.0 / air_length3(to);
    for (int i = 0; i < 3; i++) {
        normal[i] /= length;
        /* from - to, of unit length each, by their own difference */
        difference[i] = from[i] * (scale_from - scale_to) - way[i] * scale_to;
    }
    air_cross3(normal, difference, turned);
    return air_dot3(normal, wo) * air_dot3(wo, turned);
}

/* Six times the volume under the polygon: positive if it runs counter-clockwise seen from outside.
 */
static double signed_volume(const air_cone *cone)
{
    double sum = 0.0;
    for (size_t i = 1; i + 1 < cone->count; i++) {
        double normal[3];
        air_cross3(cone->vertices[i], cone->edges[i], normal);
        sum += air_dot3(cone->vertices[0], normal);
    }
    return sum;
}

double air_area_scatter_rayleigh(const double (*polygon)[3], size_t count, const double wo[3])
{
    air_cone cone;
    if (!air_cone_make(polygon, count, &cone)) {
        return 0.0;
    }
    double sum = 0.0;
    for (size_t i = 0; i < cone.count; i++) {
        sum += edge_moment(wo, cone.vertices[i], cone.edges[i],
                           cone.vertices[i + 1 < cone.count ? i + 1 : 0]);
    }
    /* 3 moment = solid angle + sum, for edges in counter-clockwise order */
    const double angle = air_cone_solid_angle(&cone);
    const double moment = (angle + (signed_volume(&cone) < 0.0 ? -sum : sum)) / 3.0;
    return 3.0 / (16.0 * AIR_PI) * (angle + moment);
}
