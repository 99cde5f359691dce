/* mesh.h: meshes: checking, copying, and their form in world space. */
#ifndef AIR_SCENE_MESH_H
#define AIR_SCENE_MESH_H

#include "core/quadric.h"
#include "scene/record.h"
#include "scene/snapshot.h"

/* The shape of a mesh description, and its arrays, in the mesh's own space; quadrics have none. */
typedef struct air_geometry {
    air_record base;
    air_shape shape;
    float *positions; /* one float of padding */
    float *normals, *tangents, *uv[2], *colors;
    size_t vertex_count;
    uint32_t *indices;
    size_t triangle_count;
} air_geometry;

/* What to_world changes of a geometry. Arrays are the geometry's own when to_world is the identity.
 */
typedef struct air_world_mesh {
    air_record base;
    air_geometry *geometry; /* retained */
    float *positions, *normals, *tangents;
    bool borrowed;       /* the arrays are the geometry's */
    bool flip;           /* to_world mirrors; of no matter to quadrics, whose normals point out */
    air_quadric quadric; /* of a geometry that is one */
    float bounds_min[3], bounds_max[3];
} air_world_mesh;

typedef struct air_mesh_record {
    air_record base;
    air_geometry *geometry; /* retained */
    air_world_mesh *world; /* retained; NULL until a commit first needs it, constant from then on */
    float to_world[12];
    air_handle material;
    bool camera_visible, casts_shadow, flip_normals;
    int32_t node, primitive;
} air_mesh_record;

/* What files and messages call shapes, in the order of air_shape. */
enum { AIR_SHAPES = AIR_SHAPE_DISK + 1 };
extern const char *const air_shape_names[AIR_SHAPES];

/* Checks and copies a description; the material handle is not looked at. Arrays that are the same
 * as those of `previous` (may be NULL) are shared with it. */
air_status air_mesh_record_create(air_context *context, const air_mesh_desc *desc,
                                  const air_mesh_record *previous, air_record **out_record);

/* Makes record->world where it is missing. */
air_status air_mesh_record_place(air_mesh_record *record);

/* Have two meshes the same arrays? */
bool air_geometry_equal(const air_geometry *a, const air_geometry *b);
/* The same to_world? */
bool air_mesh_place_equal(const air_mesh_record *a, const air_mesh_record *b);

/* The form that snapshots hold; mask follows from the flags and the material. */
void air_mesh_init(const air_mesh_record *record, uint32_t material_index,
                   const air_material *material, air_mesh *out_mesh);

#endif
