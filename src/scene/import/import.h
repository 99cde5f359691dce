/* import.h: one run of air_scene_load: the scene being filled, what a sidecar can name in it, and
 * the sidecars.
 *
 * Order of work: the scene file collects its objects and the sidecars it carries; the sidecar files
 * follow; then flags and boundaries are marked on the objects, meshes are added, and last what the
 * sidecars bring. */
#ifndef AIR_SCENE_IMPORT_IMPORT_H
#define AIR_SCENE_IMPORT_IMPORT_H

#include "airlight/scene.h"
#include "scene/import/json_place.h"

/* A node of the scene file that carries a mesh, a light or a camera. */
typedef struct air_import_object {
    const char *name;      /* of the node, "" if it has none; borrowed from the scene file */
    const char *data_name; /* of its mesh, or else light, or else camera */
    float to_world[12];
    size_t mesh, light, camera; /* indices in the scene file, SIZE_MAX: none */
    bool camera_visible, casts_shadow;
    size_t node;                 /* of the file, SIZE_MAX: none */
    bool bounds_medium;          /* bounds a medium and is not itself rendered */
    air_shape shape;             /* in place of the mesh's triangles */
    bool flip_normals;           /* of the shape */
    air_camera_desc camera_rest; /* what the scene file cannot say of the camera; the rest, and
                                    what is not said, as by default */
} air_import_object;

/* Where a sidecar stands. */
typedef enum air_sidecar_place {
    AIR_SIDECAR_WORLD = 0,   /* a file, or the extras of the scene */
    AIR_SIDECAR_NODE = 1,    /* the extras of a node: in its space */
    AIR_SIDECAR_ARGUMENT = 2 /* the JSON is one medium, from the command line */
} air_sidecar_place;

/* The most options one --medium may have. */
enum { AIR_MEDIUM_OPTIONS = 32 };

/* One airlight object. */
typedef struct air_sidecar {
    char *file, *prefix, *folder; /* owned */
    json_t *json;                 /* owned */
    air_json_column columns[AIR_MEDIUM_OPTIONS];
    size_t column_count;
    air_sidecar_place place;
    float to_world[12]; /* of the node it stands on */
    size_t object;      /* index of that node's object, SIZE_MAX: it has none */
    size_t number;      /* arguments: which --medium, from 1 */
} air_sidecar;

/* Triangles in world space. */
typedef struct air_import_geometry {
    float *positions;
    size_t vertex_count;
    uint32_t *indices;
    size_t triangle_count;
} air_import_geometry;

typedef struct air_import {
    air_context *context;
    air_scene *scene;
    const air_load_params *params;
    air_import_object *objects;
    size_t object_count, object_capacity;
    air_sidecar *sidecars;
    size_t sidecar_count, sidecar_capacity;
    /* Appends the triangles of an object's mesh; set by the reader of the scene file. */
    air_status (*append_geometry)(void *user, const air_import_object *object,
                                  air_import_geometry *geometry);
    /* Adds the objects to the scene, once they are marked; set likewise. */
    air_status (*add_objects)(void *user);
    void *user;
} air_import;

/* The readers: each collects its file's objects and calls air_import_fill. */
air_status air_gltf_read(air_import *import, const char *path);
air_status air_mitsuba_read(air_import *import, const char *path);
/* The sidecars, the objects, what the sidecars bring, and --environment. */
air_status air_import_fill(air_import *import, const char *path);

void air_import_finish(air_import *import);

/* Appends an object with no mesh, light and camera, flags true; NULL when memory is out. Pointers
 * to earlier ones move. */
air_import_object *air_import_add_object(air_import *import);

/* printf into a warning of the scene. */
air_status air_import_warn(air_import *import, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The next object from `start` on that a name means, SIZE_MAX if there is none. A name means nodes
 * of that name, or, if there are none, nodes whose mesh or light has it. */
size_t air_import_find(const air_import *import, const char *name, size_t start);
/* AIR_ERROR_FORMAT at the place where an unknown name stands, with the nearest known one. */
air_status air_import_unknown_name(const air_import *import, const air_json *at, const char *name);

/* ---- sidecars ---- */

/* An airlight object inside the scene file: `at` is an object, or a string that holds one as JSON
 * text (Blender writes custom properties as strings). object: that of the node, or SIZE_MAX. */
air_status air_sidecar_add_value(air_import *import, const air_json *at, const float to_world[12],
                                 air_sidecar_place place, size_t object);
/* A file; an optional one may be absent. */
air_status air_sidecar_add_file(air_import *import, const char *path, bool optional);
/* A --medium; number counts them from 1. */
air_status air_sidecar_add_argument(air_import *import, const char *argument, size_t number);

/* The lens, the near plane and mirroring of a camera, as the JSON of a camera or of a node says. */
air_status air_sidecar_read_camera(const air_json *at, air_camera_desc *desc);
/* What the airlight object of a node says of the shape and the camera that the node has. */
air_status air_sidecar_read_node(const air_json *at, air_import_object *object);

/* Checks keys and marks objects: flags, and which meshes are boundaries. */
air_status air_sidecars_mark(air_import *import);
/* Cameras: those of the last sidecar come first, so that it decides what the default is. */
air_status air_sidecars_add_cameras(air_import *import);
/* Media and lights. */
air_status air_sidecars_add(air_import *import);

/* ---- the parts of an airlight object ---- */

/* A sidecar's JSON as a place, the space it is in, and names for what has none. */
typedef struct air_sidecar_part {
    air_import *import;
    const air_json *at;
    const float *to_world;     /* 12 floats */
    size_t object;             /* the node's object, if its mesh bounds the medium; or SIZE_MAX */
    const char *fallback_name; /* if the JSON gives none */
} air_sidecar_part;

air_status air_sidecar_add_medium(const air_sidecar_part *part);
/* Sets bounds_medium on the objects whose meshes bound this medium. */
air_status air_sidecar_mark_boundary(const air_sidecar_part *part);
air_status air_sidecar_add_light(const air_sidecar_part *part);
air_status air_sidecar_add_camera(const air_sidecar_part *part);

/* Fills desc->phase; a mixture is *mixture. */
air_status air_sidecar_read_phase(const air_sidecar_part *part, air_medium_desc *desc,
                                  air_phase_mixture *mixture);
/* Fills desc->density; loads grids. */
air_status air_sidecar_read_density(const air_sidecar_part *part, air_medium_desc *desc);
/* Fills desc->boundary, after the density; what it refers to is in *planes and *geometry, which the
 * caller frees. */
air_status air_sidecar_read_boundary(const air_sidecar_part *part, air_medium_desc *desc,
                                     float **planes, air_import_geometry *geometry);
/* Fills desc->density.detail, after the density and the boundary. */
air_status air_sidecar_read_detail(const air_sidecar_part *part, air_medium_desc *desc);

/* Frees *geometry and zeroes it. */
void air_import_geometry_finish(air_context *context, air_import_geometry *geometry);
/* Room for so many more, which are counted at once. */
air_status air_import_geometry_grow(air_context *context, size_t vertex_count,
                                    size_t triangle_count, air_import_geometry *geometry);

/* A 3x4 map from nested rows: three or four rows of four numbers, the fourth being 0 0 0 1. */
air_status air_sidecar_read_map(const air_json *at, float out[12]);
/* A rotation from a quaternion x, y, z, w of any length but 0; 9 floats, row-major. */
air_status air_sidecar_read_rotation(const air_json *at, float out[9]);
/* A vector that is not 0, normalised. */
air_status air_sidecar_read_direction(const air_json *at, float out[3]);

/* ---- command line ---- */

/* "sigma_s=0.2,g=0.3" or a JSON object: makes the JSON that a sidecar would hold for the medium, a
 * new reference, and where its parts were said (none for JSON). `file` names the argument in
 * messages. */
air_status air_medium_argument_parse(air_context *context, const char *file, const char *argument,
                                     json_t **out_json,
                                     air_json_column out_columns[AIR_MEDIUM_OPTIONS],
                                     size_t *out_column_count);

/* "constant=R,G,B", or the path of an image. */
air_status air_environment_argument_add(air_import *import, const char *argument);
/* A lat-long image as a texture; negative and non-finite pixels become 0, with a warning. */
air_status air_import_environment_texture(air_import *import, const char *path,
                                          air_handle *out_texture);

#endif
