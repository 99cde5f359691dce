/* mesh_serialized.c: Mitsuba's .serialized, versions 3 and 4 [Jakob2014, "serialized"].
 *
 * Each shape begins with the magic number and the version and goes on as a zlib stream: flags, in
 * version 4 a name that ends with a NUL, the numbers of vertices and triangles as 64 bits,
 * positions, normals, texture coordinates, colours, indices. The file ends with where each shape
 * begins, in 32 bits (version 3) or 64 (version 4), and the number of shapes in 32. All
 * little-endian. */
#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <zlib.h>

#include "scene/import/mesh_decode.h"

enum { MAGIC = 0x041c, HEADER_SIZE = 4 };
enum {
    FLAG_NORMALS = 0x0001,
    FLAG_UV = 0x0002,
    FLAG_COLORS = 0x0008,
    FLAG_FACE_NORMALS = 0x0010, /* vertex normals are not to be used */
    FLAG_DOUBLE = 0x2000
};

/* Deflate packs no better than 1 : 1032; counts that would need more are not believed. */
enum { MAX_RATIO = 1100 };

typedef struct serialized_reader {
    air_context *context;
    const char *path;
    size_t shape;    /* for messages */
    uint64_t packed; /* bytes of the file from the shape's stream on */
    z_stream stream;
    uint32_t flags;
    uint64_t vertex_count, triangle_count;
} serialized_reader;

static uint64_t read_unsigned(const uint8_t *bytes, size_t size)
{
    uint64_t value = 0;
    for (size_t i = 0; i < size; ++i)
        value |= (uint64_t)bytes[i] << 8 * i;
    return value;
}

static air_status fail(const serialized_reader *reader, const char *expected)
{
    return air_fail(reader->context, AIR_ERROR_FORMAT, "%s: shape %zu: expected %s", reader->path,
                    reader->shape, expected);
}

/* ---- where a shape is ---- */

static air_status read_header(air_context *context, const char *path, const uint8_t *data,
                              size_t size, uint64_t offset, uint64_t *out_version)
{
    if (size < HEADER_SIZE || offset > size - HEADER_SIZE ||
        read_unsigned(data + offset, 2) != MAGIC)
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte %" PRIu64 ": expected a shape, which begins with 1c 04", path,
                        offset);
    *out_version = read_unsigned(data + offset + 2, 2);
    if (*out_version != 3 && *out_version != 4)
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: byte %" PRIu64 ": version %" PRIu64 ", expected 3 or 4", path,
                        offset + 2, *out_version);
    return AIR_OK;
}

static air_status find_shape(air_context *context, const char *path, const uint8_t *data,
                             size_t size, size_t shape, uint64_t *out_offset)
{
    uint64_t version = 0;
    const air_status status = read_header(context, path, data, size, 0, &version);
    if (status != AIR_OK)
        return status;
    const uint64_t width = version == 3 ? 4 : 8;
    const uint64_t count = size < 8 ? 0 : read_unsigned(data + size - 4, 4);
    if (count == 0 || count > (size - 4) / width)
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte %zu: %" PRIu64 " shapes, expected 1 to %" PRIu64, path, size - 4,
                        count, (uint64_t)(size - 4) / width);
    if (shape >= count)
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: shape %zu is asked for, but the file has %" PRIu64 ", counted from 0",
                        path, shape, count);
    *out_offset = read_unsigned(data + (size - 4 - (count - shape) * width), (size_t)width);
    return AIR_OK;
}

/* ---- the stream ---- */

static void *allocate_packed(void *user, uInt count, uInt size)
{
    return air_allocate(user, count, size);
}

static void free_packed(void *user, void *pointer) { air_free(user, pointer); }

static air_status begin_stream(serialized_reader *reader, const uint8_t *data, size_t size)
{
    z_stream *stream = &reader->stream;
    reader->packed = size;
    *stream = (z_stream){.zalloc = allocate_packed,
                         .zfree = free_packed,
                         .opaque = reader->context,
                         .next_in = (z_const Bytef *)data};
    return inflateInit(stream) == Z_OK ? AIR_OK : air_fail_memory(reader->context, reader->path);
}

/* The next `size` bytes, no more than MAX_CHUNK at a time, for zlib counts in 32 bits. */
static air_status take(serialized_reader *reader, void *out, size_t size, const char *what)
{
    enum { MAX_CHUNK = 1 << 30 };
    z_stream *stream = &reader->stream;
    uint64_t left = reader->packed - stream->total_in;
    for (size_t done = 0; done < size;) {
        const size_t room = size - done < MAX_CHUNK ? size - done : MAX_CHUNK;
        const uint64_t input = left < MAX_CHUNK ? left : MAX_CHUNK;
        stream->next_out = (Bytef *)out + done;
        stream->avail_out = (uInt)room;
        stream->avail_in = (uInt)input;
        const int result = inflate(stream, Z_NO_FLUSH);
        done += room - stream->avail_out;
        left -= input - stream->avail_in;
        if (result == Z_MEM_ERROR)
            return air_fail_memory(reader->context, reader->path);
        if (result != Z_OK && !(result == Z_STREAM_END && done == size))
            return air_fail(
                reader->context, AIR_ERROR_FORMAT, "%s: shape %zu: expected %s, its zlib stream %s",
                reader->path, reader->shape, what,
                result == Z_STREAM_END || result == Z_BUF_ERROR ? "ends before" : "is damaged");
    }
    return AIR_OK;
}

/* ---- arrays ---- */

static air_status read_doubles(serialized_reader *reader, float *out, size_t count,
                               const char *what)
{
    double chunk[512];
    const size_t room = sizeof chunk / sizeof *chunk;
    for (size_t done = 0; done < count;) {
        const size_t next = count - done < room ? count - done : room;
        const air_status status = take(reader, chunk, next * sizeof *chunk, what);
        if (status != AIR_OK)
            return status;
        for (size_t i = 0; i < next; ++i)
            out[done + i] = (float)chunk[i];
        done += next;
    }
    return AIR_OK;
}

/* `width` numbers for each vertex. */
static air_status read_array(serialized_reader *reader, size_t width, const char *what,
                             float **out_array)
{
    const size_t count = (size_t)reader->vertex_count * width;
    float *array = air_allocate(reader->context, count, sizeof *array);
    if (array == NULL)
        return air_fail_memory(reader->context, reader->path);
    *out_array = array;
    const air_status status = (reader->flags & FLAG_DOUBLE) != 0
                                  ? read_doubles(reader, array, count, what)
                                  : take(reader, array, count * sizeof *array, what);
    for (size_t i = 0; status == AIR_OK && i < count; ++i) {
        if (!isfinite(array[i]))
            return air_fail(reader->context, AIR_ERROR_FORMAT,
                            "%s: shape %zu: vertex %zu: expected finite %s", reader->path,
                            reader->shape, i / width, what);
    }
    return status;
}

/* The file has three components. */
static air_status read_colors(serialized_reader *reader, air_mesh_file *out)
{
    float *rgb = NULL;
    air_status status = read_array(reader, 3, "colours", &rgb);
    if (status == AIR_OK) {
        out->colors = air_allocate(reader->context, 4 * out->vertex_count, sizeof *out->colors);
        if (out->colors == NULL)
            status = air_fail_memory(reader->context, reader->path);
    }
    for (size_t i = 0; status == AIR_OK && i < out->vertex_count; ++i) {
        memcpy(out->colors + 4 * i, rgb + 3 * i, 3 * sizeof *rgb);
        out->colors[4 * i + 3] = 1.0f;
    }
    air_free(reader->context, rgb);
    return status;
}

static air_status read_indices(serialized_reader *reader, air_mesh_file *out)
{
    const size_t count = 3 * (size_t)reader->triangle_count;
    out->indices = air_allocate(reader->context, count, sizeof *out->indices);
    if (out->indices == NULL)
        return air_fail_memory(reader->context, reader->path);
    const air_status status = take(reader, out->indices, count * sizeof *out->indices, "indices");
    for (size_t i = 0; status == AIR_OK && i < count; ++i) {
        if (out->indices[i] >= out->vertex_count)
            return air_fail(reader->context, AIR_ERROR_FORMAT,
                            "%s: shape %zu: triangle %zu: index %" PRIu32
                            ", expected one below the %zu vertices",
                            reader->path, reader->shape, i / 3, out->indices[i], out->vertex_count);
    }
    out->triangle_count = (size_t)reader->triangle_count;
    return status;
}

/* ---- a shape ---- */

static air_status skip_name(serialized_reader *reader)
{
    char letter = '\0';
    air_status status;
    do
        status = take(reader, &letter, 1, "a name");
    while (status == AIR_OK && letter != '\0');
    return status;
}

static air_status read_counts(serialized_reader *reader, uint64_t version)
{
    uint8_t bytes[16];
    air_status status = take(reader, bytes, 4, "flags");
    if (status != AIR_OK)
        return status;
    reader->flags = (uint32_t)read_unsigned(bytes, 4);
    if (version == 4)
        status = skip_name(reader);
    if (status == AIR_OK)
        status = take(reader, bytes, 16, "the numbers of vertices and triangles");
    if (status != AIR_OK)
        return status;
    reader->vertex_count = read_unsigned(bytes, 8);
    reader->triangle_count = read_unsigned(bytes + 8, 8);
    const uint64_t most = reader->packed * MAX_RATIO;
    const uint64_t vertex_size = (reader->flags & FLAG_DOUBLE) != 0 ? 24 : 12;
    if (reader->vertex_count == 0 || reader->vertex_count > UINT32_MAX ||
        reader->triangle_count > UINT32_MAX || reader->vertex_count > most / vertex_size ||
        reader->triangle_count > most / 12)
        return fail(reader, "numbers of vertices and triangles that the file has room for");
    return AIR_OK;
}

static air_status read_shape(serialized_reader *reader, uint64_t version, air_mesh_file *out)
{
    air_status status = read_counts(reader, version);
    out->vertex_count = (size_t)reader->vertex_count;
    if (status == AIR_OK)
        status = read_array(reader, 3, "positions", &out->positions);
    if (status == AIR_OK && (reader->flags & FLAG_NORMALS) != 0)
        status = read_array(reader, 3, "normals", &out->normals);
    if (status == AIR_OK && (reader->flags & FLAG_UV) != 0)
        status = read_array(reader, 2, "texture coordinates", &out->uv);
    if (status == AIR_OK && (reader->flags & FLAG_COLORS) != 0)
        status = read_colors(reader, out);
    if (status == AIR_OK)
        status = read_indices(reader, out);
    if ((reader->flags & FLAG_FACE_NORMALS) != 0) {
        air_free(reader->context, out->normals);
        out->normals = NULL;
    }
    return status;
}

air_status air_mesh_serialized_decode(air_context *context, const char *path, const uint8_t *data,
                                      size_t size, size_t shape_index, air_mesh_file *out)
{
    serialized_reader reader = {.context = context, .path = path, .shape = shape_index};
    uint64_t offset = 0, version = 0;
    air_status status = find_shape(context, path, data, size, shape_index, &offset);
    if (status == AIR_OK)
        status = read_header(context, path, data, size, offset, &version);
    if (status != AIR_OK)
        return status;
    const size_t begin = (size_t)offset + HEADER_SIZE;
    status = begin_stream(&reader, data + begin, size - begin);
    if (status != AIR_OK)
        return status;
    status = read_shape(&reader, version, out);
    inflateEnd(&reader.stream);
    return status;
}
