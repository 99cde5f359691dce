/* gltf_mesh.h: meshes of a glTF file for the atlas. */
#ifndef AIR_LIGHTMAP_GLTF_MESH_H
#define AIR_LIGHTMAP_GLTF_MESH_H

#include "lightmap/gltf_show.h"

/* Gives every mesh of the lightmap that is on a page its coordinates and its material; a mesh that
 * several nodes share becomes a copy for each of them. */
air_status air_gltf_mesh_light_all(air_gltf_show *self);

#endif
