/* obj_vertices.h: one number for each different corner of faces. */
#ifndef AIR_SCENE_IMPORT_OBJ_VERTICES_H
#define AIR_SCENE_IMPORT_OBJ_VERTICES_H

#include "core/host.h"

#define AIR_OBJ_NONE UINT32_MAX

/* Indices from 0, or AIR_OBJ_NONE. */
typedef struct air_obj_corner {
    uint32_t v, vt, vn;
} air_obj_corner;

typedef struct air_obj_vertices {
    air_obj_corner *corners; /* the different ones, as they came */
    size_t count;
    uint32_t *slots; /* an open hash table of their numbers, AIR_OBJ_NONE where free */
    size_t mask;     /* slots less one: a power of two less one */
} air_obj_vertices;

/* Room for `most` different corners. False: out of memory, finish is still due. */
bool air_obj_vertices_init(air_context *context, size_t most, air_obj_vertices *out);
void air_obj_vertices_finish(air_context *context, air_obj_vertices *vertices);
/* The number of this corner. */
uint32_t air_obj_vertices_find(air_obj_vertices *vertices, air_obj_corner corner);

#endif
