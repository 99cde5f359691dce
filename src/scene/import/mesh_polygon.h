/* mesh_polygon.h: faces of many corners as triangles. */
#ifndef AIR_SCENE_IMPORT_MESH_POLYGON_H
#define AIR_SCENE_IMPORT_MESH_POLYGON_H

#include "core/host.h"
#include "scene/lights/polygon.h"

typedef struct air_mesh_polygon {
    float *vertices; /* 3 per corner */
    size_t count;
    uint32_t (*triangles)[3]; /* numbers of corners */
    air_point2 *points;       /* scratch of the triangulation, as all that follows */
    size_t *links;
} air_mesh_polygon;

/* Room for `most` corners. False: out of memory, finish is still due. */
bool air_mesh_polygon_init(air_context *context, size_t most, air_mesh_polygon *out);
void air_mesh_polygon_finish(air_context *context, air_mesh_polygon *polygon);

/* A polygon is added corner by corner. */
static inline void air_mesh_polygon_begin(air_mesh_polygon *polygon) { polygon->count = 0; }
void air_mesh_polygon_add(air_mesh_polygon *polygon, const float position[3]);
/* Unit; +Z if there is no area. */
void air_mesh_polygon_normal(const air_mesh_polygon *polygon, float out[3]);
/* Fills triangles and returns their number, count - 2 at most. Convex polygons become fans, others
 * are cut ear by ear; those that are not simple, or have more than 1024 corners, are taken for
 * convex. */
size_t air_mesh_polygon_triangulate(air_mesh_polygon *polygon);

#endif
