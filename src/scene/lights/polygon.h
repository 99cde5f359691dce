/* polygon.h: planar polygons: are they sound, their plane, their triangles; and the light that
 * polygons and emissive triangles give. */
#ifndef AIR_SCENE_LIGHTS_POLYGON_H
#define AIR_SCENE_LIGHTS_POLYGON_H

#include <stdint.h>

#include "scene/lights/light_table.h"

enum { AIR_MAX_POLYGON_VERTICES = 4096 };

typedef struct air_point2 {
    double x, y;
} air_point2;

/* The plane that fits a polygon: its normal points to where the vertices run counter-clockwise. */
typedef struct air_polygon_plane {
    double center[3]; /* the mean of the vertices */
    double normal[3], s[3], t[3];
    double area;
    double extent;    /* largest distance of a vertex from the centre */
    double deviation; /* largest distance of a vertex from the plane */
    double magnitude; /* largest coordinate, which bounds what float rounding did */
} air_polygon_plane;

/* vertices: 3 floats each, at least 3 of them. */
air_polygon_plane air_polygon_fit(const float *vertices, size_t count);
/* Its vertices in the frame (s, t) of the plane, relative to the centre. */
void air_polygon_flatten(const air_polygon_plane *plane, const float *vertices, size_t count,
                         air_point2 *out_points);

/* Signed area, positive if the points run counter-clockwise. */
double air_polygon_area(const air_point2 *points, size_t count);
/* Is this area nothing but rounding, for a polygon that reaches so far in coordinates of that
 * magnitude? */
bool air_polygon_is_thin(double area, double extent, double magnitude);
/* The first edge (i, i+1) that crosses a later one, or count. Edges that only touch do not cross.
 */
size_t air_polygon_crossing(const air_point2 *points, size_t count);
/* Ear clipping of a simple polygon that runs counter-clockwise: at most count - 2 triangles as
 * indices. links: 2 * count numbers of scratch. Returns their number, 0 if the polygon is not
 * simple. */
size_t air_polygon_triangulate(const air_point2 *points, size_t count, size_t *links,
                               uint32_t (*out_triangles)[3]);

/* Fills the vertices, triangles, normal and area of a light. The polygon must have been checked. */
air_status air_polygon_build(air_context *context, const float *vertices, size_t count,
                             air_light *light);
void air_polygon_finish(air_context *context, air_light *light);

/* A point on a polygon light or emissive triangle, uniform in area. */
void air_polygon_sample(const air_light *light, float u1, float u2, air_light_point *out);
bool air_polygon_connect(const air_light *light, const air_light_point *light_point, air_vec3 point,
                         air_connection *out);
/* See air_light_hit_pdf. */
float air_polygon_hit_pdf(const air_light *light, air_vec3 dir, float distance);

#endif
