#include <string.h>

#include "scene/import/gltf.h"

enum {
    AIR_GLB_MAGIC = 0x46546C67,      /* "glTF" */
    AIR_GLB_CHUNK_JSON = 0x4E4F534A, /* "JSON" */
    AIR_GLB_CHUNK_BIN = 0x004E4942,  /* "BIN" */
    AIR_GLB_HEADER = 12,
    AIR_GLB_CHUNK_HEADER = 8
};

static uint32_t read_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/* Does a text begin as a JSON object or array does? */
static bool looks_like_json(const uint8_t *bytes, size_t size)
{
    size_t i = 0;
    if (size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0) /* a byte order mark */
        i = 3;
    while (i < size && strchr(" \t\r\n", bytes[i]) != NULL && bytes[i] != '\0')
        ++i;
    return i < size && (bytes[i] == '{' || bytes[i] == '[');
}

/* [glTF2, section 4.4] */
air_status air_gltf_split(air_context *context, const char *path, const void *data, size_t size,
                          const char **out_text, size_t *out_text_size, const uint8_t **out_chunk,
                          size_t *out_chunk_size)
{
    const uint8_t *bytes = data;
    if (size < 4 || read_u32(bytes) != AIR_GLB_MAGIC) {
        if (!looks_like_json(bytes, size))
            return air_fail(
                context, AIR_ERROR_FORMAT,
                "%s: byte 0: expected a glTF file, which is JSON text or begins with \"glTF\"",
                path);
        *out_text = data;
        *out_text_size = size;
        *out_chunk = NULL;
        *out_chunk_size = 0;
        return AIR_OK;
    }
    if (size < AIR_GLB_HEADER || read_u32(bytes + 4) != 2)
        return air_fail(context, AIR_ERROR_FORMAT, "%s: byte 4: expected a GLB header of version 2",
                        path);
    const size_t length = read_u32(bytes + 8);
    if (length > size || length < AIR_GLB_HEADER)
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte 8: the GLB header states %zu bytes, the file has %zu", path,
                        length, size);
    const uint8_t *text = NULL, *chunk = NULL;
    size_t text_size = 0, chunk_size = 0;
    size_t offset = AIR_GLB_HEADER;
    while (length - offset >= AIR_GLB_CHUNK_HEADER) {
        const size_t chunk_length = read_u32(bytes + offset);
        const uint32_t kind = read_u32(bytes + offset + 4);
        const uint8_t *start = bytes + offset + AIR_GLB_CHUNK_HEADER;
        if (chunk_length > length - offset - AIR_GLB_CHUNK_HEADER)
            return air_fail(
                context, AIR_ERROR_FORMAT,
                "%s: byte %zu: the GLB chunk states %zu bytes, the file ends %zu bytes later", path,
                offset, chunk_length, length - offset - AIR_GLB_CHUNK_HEADER);
        if (kind == AIR_GLB_CHUNK_JSON && text == NULL) {
            text = start;
            text_size = chunk_length;
        } else if (kind == AIR_GLB_CHUNK_BIN && chunk == NULL) {
            chunk = start;
            chunk_size = chunk_length;
        }
        offset += AIR_GLB_CHUNK_HEADER + chunk_length;
    }
    if (text == NULL)
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte 12: expected a JSON chunk in the GLB file", path);
    while (text_size > 0 &&
           text[text_size - 1] == '\0') /* some writers pad with these, not blanks */
        --text_size;
    *out_text = (const char *)text;
    *out_text_size = text_size;
    *out_chunk = chunk;
    *out_chunk_size = chunk_size;
    return AIR_OK;
}
