#include "scene/media/nvdb_file.h"

#include <blosc.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

/* Layout of the file, all little-endian: per segment a header, then a description and a name for
 * each of its grids, then the grids' bytes in the same order. Before format 32.6 the magic number
 * was that of a grid. */
#define MAGIC_FILE_OLD UINT64_C(0x304244566f6e614e) /* "NanoVDB0" */
#define MAGIC_FILE     UINT64_C(0x324244566f6e614e) /* "NanoVDB2" */

enum { HEADER_SIZE = 16, DESCRIPTION_SIZE = 176, MAX_NAME = 4096 };
enum { CODEC_NONE = 0, CODEC_ZIP = 1, CODEC_BLOSC = 2 };

/* Blosc packs at most this much into one chunk. */
#define BLOSC_CHUNK ((uint64_t)1 << 30)

/* No codec in use packs better than 1 : 1032 (deflate); a description that says more is not
 * believed. */
enum { MAX_RATIO = 1100 };

typedef struct nvdb_reader {
    air_context *context;
    const char *path;
    const uint8_t *data;
    uint64_t size, offset;
    const char *wanted; /* name, NULL: "density" before others */
    bool (*supported)(uint32_t type);
    int rank; /* of the best grid so far: 0 none, 1 any, 2 the one wanted */
    air_nvdb_entry best;
    char names[256]; /* of the grids passed by, for messages */
} nvdb_reader;

static uint16_t read_u16(const uint8_t *bytes)
{
    uint16_t value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

static uint32_t read_u32(const uint8_t *bytes)
{
    uint32_t value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

static uint64_t read_u64(const uint8_t *bytes)
{
    uint64_t value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

const char *air_nvdb_type_name(uint32_t type)
{
    static const char *const names[] = {"unknown", "float", "double", "int16", "int32",
                                        "int64",   "Vec3f", "Vec3d",  "mask",  "half",
                                        "uint32",  "bool",  "RGBA8",  "Fp4",   "Fp8",
                                        "Fp16",    "FpN",   "Vec4f",  "Vec4d", "index"};
    return type < sizeof names / sizeof names[0] ? names[type] : "unknown";
}

/* The next `count` bytes, or NULL with a message. */
static const uint8_t *take(nvdb_reader *reader, uint64_t count, const char *what)
{
    if (count > reader->size - reader->offset) {
        air_fail(reader->context, AIR_ERROR_FORMAT,
                 "%s: byte %" PRIu64 ": expected %s of %" PRIu64
                 " bytes, the file ends after %" PRIu64,
                 reader->path, reader->offset, what, count, reader->size - reader->offset);
        return NULL;
    }
    const uint8_t *bytes = reader->data + reader->offset;
    reader->offset += count;
    return bytes;
}

static air_status read_header(nvdb_reader *reader, uint16_t *out_grid_count, uint16_t *out_codec)
{
    const uint64_t at = reader->offset;
    const uint8_t *header = take(reader, HEADER_SIZE, "a NanoVDB header");
    if (header == NULL) {
        return AIR_ERROR_FORMAT;
    }
    const uint64_t magic = read_u64(header);
    if (magic != MAGIC_FILE && magic != MAGIC_FILE_OLD) {
        return air_fail(reader->context, AIR_ERROR_FORMAT,
                        "%s: byte %" PRIu64 ": expected the magic number of a NanoVDB file segment",
                        reader->path, at);
    }
    const uint32_t version = read_u32(header + 8);
    if (version >> 21 != AIR_NVDB_MAJOR_VERSION) {
        return air_fail(reader->context, AIR_ERROR_UNSUPPORTED,
                        "%s: NanoVDB format %" PRIu32 ".%" PRIu32 ".%" PRIu32
                        ", expected %d; write the file anew with a newer OpenVDB",
                        reader->path, version >> 21, version >> 10 & 0x7ff, version & 0x3ff,
                        AIR_NVDB_MAJOR_VERSION);
    }
    *out_grid_count = read_u16(header + 12);
    *out_codec = read_u16(header + 14);
    if (*out_codec > CODEC_BLOSC) {
        return air_fail(reader->context, AIR_ERROR_UNSUPPORTED,
                        "%s: byte %" PRIu64 ": codec %u, expected 0 (none), 1 (zip) or 2 (blosc)",
                        reader->path, at + 14, *out_codec);
    }
    return AIR_OK;
}

/* How well a grid answers the question. */
static int rank_grid(const nvdb_reader *reader, const char *name, size_t name_length, uint32_t type)
{
    const char *wanted = reader->wanted != NULL ? reader->wanted : "density";
    if (!reader->supported(type)) {
        return 0;
    }
    if (strlen(wanted) == name_length && memcmp(wanted, name, name_length) == 0) {
        return 2;
    }
    return reader->wanted == NULL ? 1 : 0;
}

/* One description with its name; the offset of the grid's bytes is not known yet. */
static air_status read_description(nvdb_reader *reader, uint16_t codec, air_nvdb_entry *out,
                                   int *out_rank)
{
    const uint8_t *bytes = take(reader, DESCRIPTION_SIZE, "a grid description");
    if (bytes == NULL) {
        return AIR_ERROR_FORMAT;
    }
    const uint32_t name_size = read_u32(bytes + 136);
    if (name_size > MAX_NAME) {
        return air_fail(reader->context, AIR_ERROR_FORMAT,
                        "%s: byte %" PRIu64 ": a grid name of %" PRIu32
                        " bytes, expected at most %d",
                        reader->path, reader->offset - DESCRIPTION_SIZE + 136, name_size, MAX_NAME);
    }
    const char *name = (const char *)take(reader, name_size, "a grid name");
    if (name == NULL) {
        return AIR_ERROR_FORMAT;
    }
    *out = (air_nvdb_entry){.type = read_u32(bytes + 32),
                            .codec = codec,
                            .grid_size = read_u64(bytes),
                            .packed_size = read_u64(bytes + 8)};
    size_t length = 0;
    for (; length < name_size && name[length] != '\0'; length++) {
        if (length + 1 < sizeof out->name) {
            out->name[length] = name[length] >= ' ' && name[length] <= '~' ? name[length] : '?';
        }
    }
    *out_rank = rank_grid(reader, name, length, out->type);
    return AIR_OK;
}

static void note_name(nvdb_reader *reader, const air_nvdb_entry *entry)
{
    const size_t used = strlen(reader->names);
    snprintf(reader->names + used, sizeof reader->names - used, "%s\"%s\" (%s)",
             used > 0 ? ", " : "", entry->name, air_nvdb_type_name(entry->type));
}

/* The descriptions of a segment's grids come before their bytes: they are read twice, so that they
 * need not be kept. */
static air_status read_segment(nvdb_reader *reader)
{
    uint16_t grid_count = 0, codec = 0;
    air_nvdb_entry entry;
    int rank;
    air_status status = read_header(reader, &grid_count, &codec);
    uint64_t description = reader->offset;
    for (uint16_t g = 0; status == AIR_OK && g < grid_count; g++) {
        status = read_description(reader, codec, &entry, &rank);
    }
    for (uint16_t g = 0; status == AIR_OK && g < grid_count; g++) {
        const uint64_t grid = reader->offset;
        reader->offset = description;
        status = read_description(reader, codec, &entry, &rank);
        description = reader->offset;
        reader->offset = entry.offset = grid;
        if (take(reader, entry.packed_size, "a grid") == NULL) {
            return AIR_ERROR_FORMAT;
        }
        note_name(reader, &entry);
        if (rank > reader->rank) {
            reader->rank = rank;
            reader->best = entry;
        }
    }
    return status;
}

air_status air_nvdb_find(air_context *context, const char *path, const uint8_t *data, size_t size,
                         const char *name, bool (*supported)(uint32_t type), air_nvdb_entry *out)
{
    nvdb_reader reader = {.context = context,
                          .path = path,
                          .data = data,
                          .size = size,
                          .wanted = name,
                          .supported = supported};
    do {
        const air_status status = read_segment(&reader);
        if (status != AIR_OK) {
            return status;
        }
    } while (reader.offset < reader.size);
    if (reader.rank == 0) {
        const char *quote = name != NULL ? "\"" : "";
        return air_fail(context, name != NULL ? AIR_ERROR_ARGUMENT : AIR_ERROR_UNSUPPORTED,
                        "%s: no grid %s%s%s with float values; the file holds %s", path, quote,
                        name != NULL ? name : "", quote,
                        reader.names[0] != '\0' ? reader.names : "no grids");
    }
    *out = reader.best;
    return AIR_OK;
}

static air_status fail_packed(air_context *context, const char *path, const air_nvdb_entry *entry,
                              const char *codec)
{
    return air_fail(context, AIR_ERROR_FORMAT,
                    "%s: byte %" PRIu64 ": expected %" PRIu64
                    " bytes of grid \"%s\" packed by %s, the data is damaged",
                    path, entry->offset, entry->grid_size, entry->name, codec);
}

/* Both packed codecs put the length of a chunk before it; NULL if the entry's bytes end before the
 * chunk does. */
static const uint8_t *next_chunk(const uint8_t **cursor, const uint8_t *end, uint64_t *out_size)
{
    if ((uint64_t)(end - *cursor) < sizeof(uint64_t)) {
        return NULL;
    }
    const uint64_t chunk_size = read_u64(*cursor);
    const uint8_t *chunk = *cursor + sizeof(uint64_t);
    if (chunk_size > (uint64_t)(end - chunk)) {
        return NULL;
    }
    *cursor = chunk + chunk_size;
    *out_size = chunk_size;
    return chunk;
}

static bool unpack_zip(const uint8_t *packed, const uint8_t *end, uint8_t *out, uint64_t size)
{
    uint64_t chunk_size = 0;
    const uint8_t *chunk = next_chunk(&packed, end, &chunk_size);
    uLongf unpacked = (uLongf)size;
    return chunk != NULL && uncompress(out, &unpacked, chunk, (uLong)chunk_size) == Z_OK &&
           unpacked == size;
}

static bool unpack_blosc(const uint8_t *packed, const uint8_t *end, uint8_t *out, uint64_t size)
{
    while (size > 0) {
        uint64_t chunk_size = 0;
        size_t unpacked = 0;
        const uint8_t *chunk = next_chunk(&packed, end, &chunk_size);
        const uint64_t expected = size < BLOSC_CHUNK ? size : BLOSC_CHUNK;
        if (chunk == NULL || blosc_cbuffer_validate(chunk, chunk_size, &unpacked) != 0 ||
            unpacked != expected ||
            blosc_decompress_ctx(chunk, out, expected, 1) != (int)expected) {
            return false;
        }
        out += expected;
        size -= expected;
    }
    return true;
}

air_status air_nvdb_unpack(air_context *context, const char *path, const uint8_t *data,
                           const air_nvdb_entry *entry, uint8_t **out_grid)
{
    const uint64_t ratio = entry->codec == CODEC_NONE ? 1 : MAX_RATIO;
    if (entry->grid_size / ratio > entry->packed_size) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte %" PRIu64 ": grid \"%s\" is said to unpack from %" PRIu64
                        " to %" PRIu64 " bytes, which cannot be",
                        path, entry->offset, entry->name, entry->packed_size, entry->grid_size);
    }
    const uint8_t *packed = data + entry->offset, *end = packed + entry->packed_size;
    uint8_t *grid = air_allocate(context, entry->grid_size, 1);
    if (grid == NULL) {
        return air_fail_memory(context, path);
    }
    air_status status = AIR_OK;
    if (entry->codec == CODEC_NONE) {
        memcpy(grid, packed, entry->grid_size);
    } else if (entry->codec == CODEC_ZIP) {
        status = unpack_zip(packed, end, grid, entry->grid_size)
                     ? AIR_OK
                     : fail_packed(context, path, entry, "zip");
    } else {
        status = unpack_blosc(packed, end, grid, entry->grid_size)
                     ? AIR_OK
                     : fail_packed(context, path, entry, "blosc");
    }
    if (status != AIR_OK) {
        air_free(context, grid);
        return status;
    }
    *out_grid = grid;
    return AIR_OK;
}
