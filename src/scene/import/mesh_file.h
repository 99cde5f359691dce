/* mesh_file.h: triangle meshes from files of other programs: Wavefront OBJ, PLY, and Mitsuba's
 * .serialized. */
#ifndef AIR_SCENE_IMPORT_MESH_FILE_H
#define AIR_SCENE_IMPORT_MESH_FILE_H

#include "core/host.h"

typedef struct air_mesh_file {
    float *positions; /* 3 per vertex */
    float *normals;   /* 3 per vertex, of any length; NULL: the file has none */
    float *uv;        /* 2 per vertex as in the file (OBJ has v upwards); NULL: it has none */
    float *colors;    /* 4 per vertex, linear; NULL: the file has none */
    size_t vertex_count;
    uint32_t *indices; /* 3 per triangle, below vertex_count */
    size_t triangle_count;
} air_mesh_file;

typedef enum air_mesh_format { AIR_MESH_OBJ, AIR_MESH_PLY, AIR_MESH_SERIALIZED } air_mesh_format;

/* Reads a mesh; shape_index, from 0, says which one of a .serialized file. All numbers are finite.
 * On failure *out is untouched and the message names the file and the line or byte. */
air_status air_mesh_file_read(air_context *context, const char *path, air_mesh_format format,
                              size_t shape_index, air_mesh_file *out);
/* The same from the bytes of the file, which may hold many shapes; path is for messages. */
air_status air_mesh_file_decode(air_context *context, const char *path, air_mesh_format format,
                                size_t shape_index, const void *data, size_t size,
                                air_mesh_file *out);
void air_mesh_file_finish(air_context *context, air_mesh_file *file);

/* Gives a mesh without normals those of its triangles, weighted at each vertex by their angles
 * [Thurmer1998], unit; 0 where no triangle has an area. It is what Mitsuba does unless told to show
 * faces. */
air_status air_mesh_file_smooth(air_context *context, air_mesh_file *file);

#endif
