/* staging_glb.c: the container of glTF's JSON and its binary chunk [glTF2, section 4.4]. */
#include <string.h>

#include "image/staging.h"

enum { FILE_HEADER = 12, CHUNK_HEADER = 8, GLB_VERSION = 2 };

/* Little-endian, whatever the machine. */
static void put_u32(uint8_t bytes[4], size_t value)
{
    for (int i = 0; i < 4; i++) {
        bytes[i] = (uint8_t)(value >> (8 * i));
    }
}

/* Writes a chunk that is filled up to `room` bytes; returns what follows it. */
static uint8_t *put_chunk(uint8_t *out, const char kind[4], const void *data, size_t size,
                          size_t room, int fill)
{
    put_u32(out, room);
    memcpy(out + 4, kind, 4);
    memcpy(out + CHUNK_HEADER, data, size);
    memset(out + CHUNK_HEADER + size, fill, room - size);
    return out + CHUNK_HEADER + room;
}

air_status air_staging_add_glb(air_staging *self, const char *name, const char *text,
                               const void *binary, size_t binary_size)
{
    const size_t text_size = strlen(text), text_room = (text_size + 3) / 4 * 4;
    const size_t binary_room = (binary_size + 3) / 4 * 4;
    const size_t total =
        FILE_HEADER + CHUNK_HEADER + text_room + (binary_room > 0 ? CHUNK_HEADER + binary_room : 0);
    if (total > UINT32_MAX) {
        return air_fail(self->context, AIR_ERROR_UNSUPPORTED,
                        "%s/%s: %zu bytes are too many for a .glb, which has room for 4 GiB",
                        self->folder, name, total);
    }
    uint8_t *file = air_allocate(self->context, total, 1);
    if (file == NULL) {
        return air_fail_memory(self->context, name);
    }
    memcpy(file, "glTF", 4);
    put_u32(file + 4, GLB_VERSION);
    put_u32(file + 8, total);
    uint8_t *next = put_chunk(file + FILE_HEADER, "JSON", text, text_size, text_room, ' ');
    if (binary_room > 0) {
        put_chunk(next, "BIN\0", binary, binary_size, binary_room, 0);
    }
    const air_status status = air_staging_add(self, name, file, total);
    air_free(self->context, file);
    return status;
}
