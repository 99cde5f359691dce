/* export.h: one run of air_scene_save: a scene as the JSON of a glTF 2.0 file, its binary chunk,
 * and the files beside it.
 *
 * Order of work: textures come with the materials that use them; then meshes, lights and cameras as
 * nodes; last what glTF cannot say, in the airlight object of the scene. What the file cannot hold
 * either is warned of where it is met. */
#ifndef AIR_SCENE_EXPORT_EXPORT_H
#define AIR_SCENE_EXPORT_EXPORT_H

#include <jansson.h>

#include "image/format.h"
#include "image/staging.h"
#include "scene/camera.h"
#include "scene/grid_record.h"
#include "scene/light_record.h"
#include "scene/material.h"
#include "scene/medium_record.h"
#include "scene/mesh.h"
#include "scene/scene.h"
#include "scene/texture.h"

/* Numbers that accessors are made of. */
typedef struct air_export_array {
    const void *data; /* floats, or uint32_t where they are indices */
    size_t count;     /* of elements */
    size_t components;
    bool indices;
    bool bounds; /* state the least and the greatest of each component */
} air_export_array;

/* Triangles around a full turn of a quadric. */
enum { AIR_EXPORT_TURN = 64 };

/* The arrays of a primitive of a mesh. */
typedef struct air_export_primitive {
    const float *positions, *normals, *tangents, *uv[2], *colors;
    size_t vertex_count;
    const uint32_t *indices;
    size_t triangle_count;
    void *owned[8]; /* arrays made for it */
    size_t owned_count;
} air_export_primitive;

/* An array that is in the file already. */
typedef struct air_export_block {
    uint64_t hash;
    size_t offset, size, components;
    bool indices, bounds;
    size_t accessor;
} air_export_block;

/* A texture that is in the file already: each is once for each way it is read. */
typedef struct air_export_texture {
    air_handle handle;
    air_handle opacity; /* whose red is a factor on alpha, or AIR_NONE; then handle may be that */
    bool srgb;
    float scale; /* what its colours were divided by */
    size_t index;
} air_export_texture;

/* A file beside the GLB that holds a grid or an environment. */
typedef struct air_export_file {
    air_handle handle;
    float box[6]; /* of grids: where they lie in their own space; else 0 */
    char *name;   /* owned */
} air_export_file;

/* What becomes a .vol: a grid, looked up at the places of the file's own voxels. */
typedef struct air_export_grid_source {
    const air_grid *grid;
    size_t size[3];     /* of the file */
    float box[6];       /* which its voxels fill, in its own space: least corner, greatest corner */
    float to_index[12]; /* from the file's indices to the grid's */
} air_export_grid_source;

typedef struct air_export {
    air_context *context;
    const air_scene *scene;
    const char *path; /* of the GLB, for messages */
    char *stem;       /* its name without folder and ending */
    air_staging staging;
    json_t *root;     /* of the glTF file */
    json_t *airlight; /* the airlight object; within root */
    bool failed;      /* the JSON library had no memory */
    air_sink binary;
    air_export_block *blocks; /* a table with open addressing; accessor SIZE_MAX: free */
    size_t block_count, block_capacity;
    air_export_texture *textures;
    size_t texture_count, texture_capacity;
    air_export_file *files;
    size_t file_count, file_capacity;
} air_export;

/* ---- export_json.c: all of these set self->failed where memory is out, and take what they are
 * given ---- */

void air_export_put(air_export *self, json_t *object, const char *key, json_t *value);
void air_export_push(air_export *self, json_t *array, json_t *value);
/* object[key], made as an empty object (array) where it is absent; borrowed. */
json_t *air_export_object(air_export *self, json_t *object, const char *key);
json_t *air_export_list(air_export *self, json_t *object, const char *key);
/* Appends to one of the file's lists; returns the index. */
size_t air_export_append(air_export *self, const char *list, json_t *item);
json_t *air_export_floats(air_export *self, const float *values, size_t count);
/* One number where all three are equal. */
json_t *air_export_color(air_export *self, const float values[3]);
/* Three rows of four. */
json_t *air_export_rows(air_export *self, const float map[12]);
/* Bytes that are not UTF-8 become "?". */
json_t *air_export_string(air_export *self, const char *text);
/* object["name"], unless it is "". */
void air_export_name(air_export *self, json_t *object, const char *name);
/* object["extensions"][name], and the file says that it is used; borrowed. */
json_t *air_export_extension(air_export *self, json_t *object, const char *name);
/* The airlight object in the extras of a node, a scene or a material; borrowed. */
json_t *air_export_node_object(air_export *self, json_t *node);
/* node["matrix"], unless it is the identity. */
void air_export_matrix(air_export *self, json_t *node, const float map[12]);
/* Appends a node to the scene. */
void air_export_node(air_export *self, json_t *node);

bool air_export_is_identity(const float map[12]);

/* ---- export_buffer.c ---- */

/* The accessor of an array; equal arrays share one. */
air_status air_export_accessor(air_export *self, const air_export_array *array, size_t *out_index);
/* Bytes as a buffer view of their own. */
air_status air_export_view(air_export *self, const void *data, size_t size, int target,
                           size_t *out_index);

/* ---- export_split.c ---- */

/* What a reader makes of a factor and a strength. */
typedef float (*air_export_product)(float factor, float strength);

/* Splits a colour into factors in [0, 1] and a strength, both photometric as glTF has them, such
 * that their products are the colour to the last bit. That is always found for emission, whose
 * product rounds once; a light's rounds on the way as well, so that some numbers are never met, and
 * the next one is. */
void air_export_split(const float color[3], air_export_product product, float out_factors[3],
                      float *out_strength);
/* ---- export_primitive.c ---- */

/* The arrays of a mesh in its own space, or in the world's; quadrics as triangles. Fronts are those
 * of the mesh. Finish *out also after a failure. */
air_status air_export_primitive_make(air_export *self, air_mesh_record *record, bool in_world,
                                     air_export_primitive *out);
void air_export_primitive_finish(air_export *self, air_export_primitive *primitive);

/* ---- what is written ---- */

/* The texture as a material refers to it, read in the way that is given (without its handle).
 * Absent where the reference names none. */
air_status air_export_texture_info(air_export *self, const air_texture_ref *reference,
                                   const air_export_texture *way, json_t **out_info);
/* The greatest colour value of a texture that is above 1, else 1. */
float air_export_texture_peak(const air_export *self, air_handle handle);

air_status air_export_materials(air_export *self);
/* The metallic-roughness material that comes nearest to one of another model. */
void air_export_nearest_material(const air_export *self, const air_material_desc *desc,
                                 air_material_desc *out);
/* The airlight object in the extras of a material, where glTF's words do not do. */
air_status air_export_model(air_export *self, const air_material_desc *desc, json_t *material);
air_status air_export_meshes(air_export *self);
/* A node with the boundary of a medium, which other programs do not see; *out_name belongs to the
 * JSON. */
air_status air_export_boundary(air_export *self, const air_medium_desc *medium,
                               const char **out_name);
void air_export_cameras(air_export *self);
/* Those that KHR_lights_punctual knows are nodes, the others in the airlight object. */
air_status air_export_lights(air_export *self);
air_status air_export_media(air_export *self);
/* density.grid, albedo_grid and emission_grid of a medium, and their files. */
air_status air_export_medium_grids(air_export *self, const air_medium_desc *medium, json_t *object);

/* ---- export_file.c: files beside the GLB ---- */

/* An environment's image as .exr. */
air_status air_export_image(air_export *self, air_handle texture, const char *name,
                            const char **out_file);
/* A grid as .vol. */
air_status air_export_grid(air_export *self, air_handle handle, const char *name,
                           const air_export_grid_source *source, const char **out_file);

/* The record of an object of the scene. */
static inline const air_record *air_export_record(const air_export *self, air_object_kind kind,
                                                  air_handle handle)
{
    const air_slot_list *list = &self->scene->lists[kind];
    return list->slots[air_slot_find(list, handle)].record;
}

#endif
