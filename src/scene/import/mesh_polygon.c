#include "scene/import/mesh_polygon.h"

#include <string.h>

/* Cutting ears takes the cube of the corners at worst. */
enum { AIR_MOST_CONCAVE = 1024 };

bool air_mesh_polygon_init(air_context *context, size_t most, air_mesh_polygon *out)
{
    *out = (air_mesh_polygon){.vertices = air_allocate(context, 3 * most, sizeof *out->vertices),
                              .triangles = air_allocate(context, most, sizeof *out->triangles),
                              .points = air_allocate(context, most, sizeof *out->points),
                              .links = air_allocate(context, 2 * most, sizeof *out->links)};
    return out->vertices != NULL && out->triangles != NULL && out->points != NULL &&
           out->links != NULL;
}

void air_mesh_polygon_finish(air_context *context, air_mesh_polygon *polygon)
{
    air_free(context, polygon->links);
    air_free(context, polygon->points);
    air_free(context, polygon->triangles);
    air_free(context, polygon->vertices);
}

void air_mesh_polygon_add(air_mesh_polygon *polygon, const float position[3])
{
    memcpy(polygon->vertices + 3 * polygon->count++, position, 3 * sizeof *position);
}

void air_mesh_polygon_normal(const air_mesh_polygon *polygon, float out[3])
{
    const air_polygon_plane plane = air_polygon_fit(polygon->vertices, polygon->count);
    for (int k = 0; k < 3; ++k)
        out[k] = (float)plane.normal[k];
}

static size_t fan(air_mesh_polygon *polygon)
{
    for (uint32_t i = 0; i + 2 < polygon->count; ++i) {
        polygon->triangles[i][0] = 0;
        polygon->triangles[i][1] = i + 1;
        polygon->triangles[i][2] = i + 2;
    }
    return polygon->count - 2;
}

/* Does it turn right nowhere? */
static bool is_convex(const air_point2 *points, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const air_point2 corner[3] = {points[i], points[(i + 1) % count], points[(i + 2) % count]};
        if (air_polygon_area(corner, 3) < 0.0)
            return false;
    }
    return true;
}

size_t air_mesh_polygon_triangulate(air_mesh_polygon *polygon)
{
    const size_t count = polygon->count;
    if (count == 3 || count > AIR_MOST_CONCAVE)
        return fan(polygon);
    const air_polygon_plane plane = air_polygon_fit(polygon->vertices, count);
    air_polygon_flatten(&plane, polygon->vertices, count, polygon->points);
    if (is_convex(polygon->points, count))
        return fan(polygon);
    const size_t triangles =
        air_polygon_triangulate(polygon->points, count, polygon->links, polygon->triangles);
    return triangles > 0 ? triangles : fan(polygon);
}
