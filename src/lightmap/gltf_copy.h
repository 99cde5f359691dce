/* gltf_copy.h: a glTF file that is read, changed in places and written again: its JSON as it is,
 * and all buffers in one. Section numbers in comments are those of the glTF 2.0 specification. */
#ifndef AIR_LIGHTMAP_GLTF_COPY_H
#define AIR_LIGHTMAP_GLTF_COPY_H

#include "image/format.h"
#include "lightmap/place.h"

typedef struct air_gltf_copy {
    air_context *context;
    const char *path; /* of the source, for messages */
    char *folder;
    json_t *json;
    air_sink binary; /* all that buffer views point into */
} air_gltf_copy;

/* ---- gltf_copy.c ---- */

/* Reads .gltf or .glb. Afterwards there is one buffer, and images lie in buffer views. Finish *out
 * also after a failure. AIR_ERROR_UNSUPPORTED: compressed buffer views (EXT_meshopt_compression).
 */
air_status air_gltf_copy_read(air_context *context, const char *path, air_gltf_copy *out);
/* Reads its JSON alone, for what can be learned from that. */
air_status air_gltf_copy_read_json(air_context *context, const char *path, air_gltf_copy *out);
void air_gltf_copy_finish(air_gltf_copy *self);

air_place air_gltf_copy_root(const air_gltf_copy *self);
/* root[name], made as an empty array if it is absent; NULL when it is something else or memory is
 * out. */
json_t *air_gltf_copy_list(air_gltf_copy *self, const char *name);
/* Appends (takes) an item to such a list; its index goes to *out_index. */
air_status air_gltf_copy_append(air_gltf_copy *self, const char *name, json_t *item,
                                size_t *out_index);
/* Bytes as a new buffer view; target and stride 0: none. */
air_status air_gltf_copy_add_view(air_gltf_copy *self, const void *data, size_t size, size_t stride,
                                  int target, size_t *out_view);
/* Puts a name into extensionsUsed. */
air_status air_gltf_copy_use_extension(air_gltf_copy *self, const char *name);

/* ---- gltf_array.c ---- */

/* An accessor's elements, packed; sparse ones are resolved. */
typedef struct air_gltf_array {
    size_t count, components, component_size;
    int64_t component; /* 5120 and so on */
    bool normalized;
    json_t *accessor; /* where it came from, borrowed; NULL */
    uint8_t *bytes;
} air_gltf_array;

/* Reads the accessor whose index stands at a place; free bytes with air_free. Matrices are refused.
 */
air_status air_gltf_array_read(const air_gltf_copy *self, const air_place *index,
                               air_gltf_array *out);
/* One component as a number, normalised where the array is. */
double air_gltf_array_number(const air_gltf_array *array, size_t element, size_t component);
/* A new array of the elements `sources`; *out shares nothing with the old one. */
air_status air_gltf_array_gather(const air_gltf_copy *self, const air_gltf_array *array,
                                 const uint32_t *sources, size_t count, air_gltf_array *out);
/* Adds an accessor: of vertices (with bounds: min and max are stated) or of indices. */
air_status air_gltf_array_add(air_gltf_copy *self, const air_gltf_array *array, bool indices,
                              bool bounds, size_t *out_accessor);

#endif
