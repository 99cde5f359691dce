/* gltf.h: a glTF 2.0 file while it is being read. Section numbers in comments are those of the
 * glTF 2.0 specification. */
#ifndef AIR_SCENE_IMPORT_GLTF_H
#define AIR_SCENE_IMPORT_GLTF_H

#include <stdint.h>

#include "scene/import/import.h"
#include "scene/import/json_place.h"

typedef struct air_gltf_buffer {
    void *data; /* NULL: not loaded yet; owned unless it is the chunk of a GLB file */
    size_t size;
    bool owned;
} air_gltf_buffer;

/* An image as it is sampled; each is decoded once. */
typedef struct air_gltf_texture {
    size_t image;
    air_wrap wrap_u, wrap_v;
    air_filter_kind filter;
    bool srgb;
    air_handle handle;
} air_gltf_texture;

/* KHR_materials_volume: what a material's meshes enclose. */
typedef struct air_gltf_volume {
    bool absorbs;
    float sigma_a[3];
} air_gltf_volume;

/* Things that are said once, at the end, with their number. */
typedef struct air_gltf_tally {
    size_t lines_and_points, partial_triangles, degenerate_triangles, flattened_nodes, zero_normals;
    size_t ranges, strong_emission, texture_sets, skins, morphs, specular_textures, missing_sources;
    size_t open_volumes, crowded_volumes, volumes;
} air_gltf_tally;

typedef struct air_gltf {
    air_context *context;
    air_import *import;
    const char *path;
    char *folder;
    void *file; /* the file's bytes; a GLB chunk points into them */
    const uint8_t *chunk;
    size_t chunk_size;
    air_json_document document;
    json_t *json;
    air_json root, accessors, buffer_views, buffers, materials, meshes, nodes, images, textures,
        samplers, cameras, scenes, animations, extensions, punctual, lights;
    air_gltf_buffer *buffer_store; /* one per buffer */
    air_handle *material_store;    /* one per material; AIR_NONE: not added yet */
    air_gltf_volume *volume_store; /* one per material */
    air_gltf_texture *texture_store;
    size_t texture_count, texture_capacity;
    float light_scale, emission_scale; /* from the file's units to radiometric ones */
    air_gltf_tally tally;
} air_gltf;

/* ---- gltf_container.c ---- */

/* Splits a GLB file or takes the whole as JSON; *out_text points into data. */
air_status air_gltf_split(air_context *context, const char *path, const void *data, size_t size,
                          const char **out_text, size_t *out_text_size, const uint8_t **out_chunk,
                          size_t *out_chunk_size);

/* ---- gltf_extensions.c ---- */

/* Asset version; required extensions are supported; one warning for each that is used but not
 * supported. */
air_status air_gltf_check_asset(air_gltf *gltf);
/* Was the file written by Blender's exporter? */
bool air_gltf_from_blender(const air_gltf *gltf);

/* ---- gltf_buffer.c ---- */

/* The bytes of a buffer view; valid as long as the gltf is. *out_stride: 0 if it states none. */
air_status air_gltf_view(air_gltf *gltf, size_t view, const uint8_t **out_data, size_t *out_size,
                         size_t *out_stride);

/* ---- gltf_accessor.c ---- */

/* Reads the accessor whose index stands at `at` as floats, normalised where it says so: *out_values
 * has width numbers per element (freed with air_free). An accessor of `narrow` components is also
 * accepted (0: none); the missing last ones become 1. Absent: NULL and count 0. Values are finite.
 */
air_status air_gltf_read_floats(air_gltf *gltf, const air_json *at, size_t width, size_t narrow,
                                float **out_values, size_t *out_count);
/* The same for vertex indices, all below vertex_count. */
air_status air_gltf_read_indices(air_gltf *gltf, const air_json *at, size_t vertex_count,
                                 uint32_t **out_values, size_t *out_count);

/* ---- gltf_texture.c ---- */

/* A textureInfo: fills the slot; absent or unusable ones leave it as it is. */
air_status air_gltf_read_texture(air_gltf *gltf, const air_json *info, bool srgb,
                                 air_texture_ref *out_slot);

/* ---- gltf_material.c ---- */

/* The handle of material `index`, added on its first use. */
air_status air_gltf_material(air_gltf *gltf, size_t index, air_handle *out_handle);

/* ---- gltf_volume.c ---- */

/* The transmission and volume of a material's extensions. */
air_status air_gltf_read_transmission(air_gltf *gltf, const air_json *extensions,
                                      air_material_desc *desc, air_gltf_volume *volume);
/* Adds what a mesh encloses, if it is closed. */
air_status air_gltf_add_volume(air_gltf *gltf, const char *name, const air_gltf_volume *volume,
                               const air_boundary *boundary);

/* ---- gltf_mesh.c ---- */

air_status air_gltf_add_mesh(air_gltf *gltf, const air_import_object *object);
/* air_import.append_geometry; user is the air_gltf. */
air_status air_gltf_append_geometry(void *user, const air_import_object *object,
                                    air_import_geometry *geometry);

/* ---- gltf_model.c ---- */

/* What the airlight object in the extras of a material says. */
air_status air_gltf_read_model(air_gltf *gltf, const air_json *material, air_material_desc *desc);

/* ---- gltf_node.c ---- */

/* Walks the chosen scene: collects objects and the sidecars in extras. */
air_status air_gltf_walk(air_gltf *gltf);

/* ---- gltf_light.c ---- */

air_status air_gltf_add_light(air_gltf *gltf, const air_import_object *object);
air_status air_gltf_add_camera(air_gltf *gltf, const air_import_object *object);

/* The name by which users know an object. */
static inline const char *air_gltf_name(const air_import_object *object)
{
    return object->name[0] != '\0' ? object->name : object->data_name;
}

#endif
