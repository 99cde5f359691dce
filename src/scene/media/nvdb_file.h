/* nvdb_file.h: the container of NanoVDB files: segments of grids, each with a description and its
 * bytes, packed by a codec. The bytes of a grid are for PNanoVDB.h to read. */
#ifndef AIR_SCENE_MEDIA_NVDB_FILE_H
#define AIR_SCENE_MEDIA_NVDB_FILE_H

#include "core/host.h"

/* The version of grids that PNanoVDB.h reads; their layout is the same within a major version. */
enum { AIR_NVDB_MAJOR_VERSION = 32 };

typedef struct air_nvdb_entry {
    char name[64]; /* for messages: what fits, unprintable characters as '?' */
    uint32_t type; /* PNANOVDB_GRID_TYPE_... */
    uint16_t codec;
    uint64_t grid_size;           /* unpacked */
    uint64_t offset, packed_size; /* of the packed bytes in the file */
} air_nvdb_entry;

/* Finds a grid whose type `supported` accepts: the one named, or with name NULL the one called
 * "density", else the first. The message of a failure lists the grids there are. path is for
 * messages. */
air_status air_nvdb_find(air_context *context, const char *path, const uint8_t *data, size_t size,
                         const char *name, bool (*supported)(uint32_t type), air_nvdb_entry *out);

/* Unpacks a grid's bytes; *out_grid has entry->grid_size bytes, free it with air_free. */
air_status air_nvdb_unpack(air_context *context, const char *path, const uint8_t *data,
                           const air_nvdb_entry *entry, uint8_t **out_grid);

/* "float" and so on. */
const char *air_nvdb_type_name(uint32_t type);

#endif
