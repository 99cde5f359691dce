/* mesh_decode.h: a mesh from the bytes of a file, one function for each format.
 *
 * On failure what *out has so far is finished by the caller. */
#ifndef AIR_SCENE_IMPORT_MESH_DECODE_H
#define AIR_SCENE_IMPORT_MESH_DECODE_H

#include "scene/import/mesh_file.h"

/* Vertices are numbered as faces first name them, one for each (v, vt, vn). */
air_status air_mesh_obj_decode(air_context *context, const char *path, const char *text,
                               size_t size, air_mesh_file *out);
air_status air_mesh_ply_decode(air_context *context, const char *path, const uint8_t *data,
                               size_t size, air_mesh_file *out);
air_status air_mesh_serialized_decode(air_context *context, const char *path, const uint8_t *data,
                                      size_t size, size_t shape_index, air_mesh_file *out);

#endif
