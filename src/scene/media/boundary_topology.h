/* boundary_topology.h: a triangle mesh as the boundary of a medium: welded, checked to be closed,
 * oriented outwards; and convex ones recognised. */
#ifndef AIR_SCENE_MEDIA_BOUNDARY_TOPOLOGY_H
#define AIR_SCENE_MEDIA_BOUNDARY_TOPOLOGY_H

#include "scene/media/media.h"
#include "scene/subject.h"

/* A closed, consistently oriented mesh. Normals (p1-p0) x (p2-p0) point out of the enclosed volume;
 * components that lie inside another are its cavities, and so on alternately. */
typedef struct air_topology {
    float *positions; /* 3 per vertex and one more float; vertices at the same place are one */
    size_t vertex_count;
    uint32_t *indices; /* 3 per triangle; triangles with two equal vertices are left out */
    size_t triangle_count;
    size_t component_count;
    double volume; /* enclosed, > 0 */
} air_topology;

/* Analyses the boundary mesh of the medium that `subject` names. AIR_ERROR_ARGUMENT: an index out
 * of range, a position that is not finite, open or non-manifold edges (with their number and a
 * place), a surface without an inside, no volume. */
air_status air_topology_make(const air_subject *subject, const float *positions,
                             size_t vertex_count, const uint32_t *indices, size_t triangle_count,
                             air_topology *out);
/* Does every edge belong to two triangles? Says so without a message. */
air_status air_topology_is_closed(air_context *context, const float *positions, size_t vertex_count,
                                  const uint32_t *indices, size_t triangle_count, bool *out_closed);
void air_topology_finish(air_context *context, air_topology *topology);

/* The planes of a convex mesh with at most AIR_MAX_PLANES different faces; *out_count is 0 for any
 * other. */
air_status air_topology_convex_planes(air_context *context, const air_topology *topology,
                                      air_plane out_planes[AIR_MAX_PLANES], size_t *out_count);

#endif
