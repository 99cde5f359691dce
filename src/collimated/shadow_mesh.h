/* shadow_mesh.h: triangles in light space and which of them continue each other. */
#ifndef AIR_COLLIMATED_SHADOW_MESH_H
#define AIR_COLLIMATED_SHADOW_MESH_H

#include "collimated/shadow_tree.h"

/* The triangles that can throw shadow on the hull. Edge e of a triangle runs from its corner e to
 * corner (e + 1) % 3; neighbours[3 t + e] is the one triangle that continues t beyond its edge e in
 * the plane perpendicular to the light, or -1. */
typedef struct shadow_mesh {
    shadow_triangle *triangles;
    int32_t *neighbours;
    size_t count;
} shadow_mesh;

/* Triangles outside the frame, below its floor or without projected area are left out. On failure
 * *out is empty. */
air_status air_shadow_mesh_init(air_context *context, const shadow_frame *frame,
                                const air_shadow_mesh *meshes, size_t mesh_count, shadow_mesh *out);
void air_shadow_mesh_finish(air_context *context, shadow_mesh *mesh);

#endif
