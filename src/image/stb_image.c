/* stb_image.c: the one file that holds stb_image and stb_image_write. */
#include "image/stb_image.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* zlib's compressor: its files are a third smaller than those of the one in stb_image_write. stb
 * frees the result. */
static unsigned char *compress_for_png(unsigned char *data, int size, int *out_size, int level)
{
    uLongf packed_size = compressBound((uLong)size);
    unsigned char *packed = malloc(packed_size);
    if (packed == NULL) {
        return NULL;
    }
    if (compress2(packed, &packed_size, data, (uLong)size, level) != Z_OK ||
        packed_size > INT_MAX) {
        free(packed);
        return NULL;
    }
    *out_size = (int)packed_size;
    return packed;
}

/* Not popped: gcc asks at the end of the file. */
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpragmas"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wcast-qual"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#ifdef __clang__
/* For a PNG with an empty chunk of data stb adds 0 to NULL and copies 0 bytes there, at which the
 * sanitizer would stop. */
#pragma clang attribute push(                                                                      \
    __attribute__((no_sanitize("pointer-overflow", "nonnull-attribute"))), apply_to = function)
#endif
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 65535
/* Zeroed: a JPEG's scan may name a Huffman table that it never gave, which stb reads as it is. */
#define STBI_MALLOC(size)           calloc(1, size)
#define STBI_REALLOC(pointer, size) realloc(pointer, size)
#define STBI_FREE(pointer)          free(pointer)
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#define STBIW_ZLIB_COMPRESS compress_for_png
#include <stb/stb_image_write.h>
#ifdef __clang__
#pragma clang attribute pop
#endif
#pragma GCC diagnostic pop

/* A file in memory as stb's callbacks read it. stb takes the end of data for zeros and may then
 * hand out half a picture or (HDR) wait for ever; as it asks for bytes only when it needs them,
 * asking beyond the end means truncation. */
typedef struct reader {
    const uint8_t *data;
    size_t size, position;
    bool truncated;
    bool pad; /* serve bytes 0xFF behind the end, which end a run of HDR; else nothing, which ends a
                 JPEG */
} reader;

static int reader_read(void *user, char *out, int size)
{
    reader *const r = user;
    const size_t left = r->size - r->position;
    const size_t count = left < (size_t)size ? left : (size_t)size;
    if (count > 0) {
        memcpy(out, r->data + r->position, count);
        r->position += count;
        return (int)count;
    }
    if (size > 0) {
        r->truncated = true;
        if (r->pad) {
            out[0] = (char)0xFF;
            return 1;
        }
    }
    return 0;
}

static void reader_skip(void *user, int count)
{
    reader *const r = user;
    const size_t left = r->size - r->position;
    if (count > 0 && (size_t)count > left) {
        r->truncated = true;
    }
    if (count > 0) {
        r->position += (size_t)count < left ? (size_t)count : left;
    } else {
        const size_t back = (size_t)(-(long long)count);
        r->position -= back < r->position ? back : r->position;
    }
}

static int reader_eof(void *user)
{
    const reader *const r = user;
    return r->position >= r->size;
}

static const stbi_io_callbacks callbacks = {reader_read, reader_skip, reader_eof};

static reader reader_start(const air_source *source, bool pad)
{
    return (reader){.data = source->data, .size = source->size, .pad = pad};
}

/* The payload of a DHT segment: tables of 16 counts, whose sum must not exceed 256, and as many
 * symbols. */
static bool huffman_tables_fit(const uint8_t *payload, size_t size)
{
    while (size > 0) {
        size_t symbols = 0;
        for (size_t i = 1; i <= 16 && size >= 17; i++) {
            symbols += payload[i];
        }
        if (size < 17 || symbols > 256 || symbols > size - 17) {
            return false;
        }
        payload += 17 + symbols;
        size -= 17 + symbols;
    }
    return true;
}

/* stb_image before 2.28 writes beyond its Huffman tables when a JPEG declares too many symbols, so
 * these are looked at first. Walks the segments as stb does, but strictly: false if one does not
 * follow upon the other or is cut off, or if a table is too large. Data that does not start like a
 * JPEG is none of its business. */
static bool jpeg_is_safe(const uint8_t *data, size_t size)
{
    enum { RESTART_FIRST = 0xD0, RESTART_LAST = 0xD7, START_OF_IMAGE = 0xD8, END_OF_IMAGE = 0xD9 };
    enum { START_OF_SCAN = 0xDA, HUFFMAN = 0xC4, FILL = 0xFF };
    if (size < 1 || data[0] != 0xFF) {
        return true;
    }
    size_t at = 0;
    bool in_scan = false;
    while (at + 1 < size) {
        const uint8_t marker = data[at + 1];
        const bool escaped = marker == 0 || (marker >= RESTART_FIRST && marker <= RESTART_LAST);
        if (data[at] != 0xFF && !in_scan) {
            return false;
        }
        if (data[at] != 0xFF || marker == FILL || (in_scan && escaped)) {
            at++;
        } else if (marker == START_OF_IMAGE) {
            at += 2;
        } else if (marker == END_OF_IMAGE || at + 4 > size) {
            return true;
        } else {
            const size_t length = (size_t)data[at + 2] << 8 | data[at + 3];
            if (length < 2 || length > size - at - 2 ||
                (marker == HUFFMAN && !huffman_tables_fit(data + at + 4, length - 2))) {
                return false;
            }
            in_scan = marker == START_OF_SCAN;
            at += 2 + length;
        }
    }
    return true;
}

/* PNG: the size in its first chunk, so that it can be told when stb refuses it without saying why.
 */
static air_status check_png_size(air_context *context, const air_source *source)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
    uint64_t size[2] = {0, 0};
    if (source->size < 24 || memcmp(source->data, signature, sizeof(signature)) != 0) {
        return AIR_OK;
    }
    for (size_t i = 0; i < 8; i++) {
        size[i / 4] = size[i / 4] << 8 | source->data[16 + i];
    }
    return air_format_check_size(context, source->path, size[0], size[1], 1);
}

/* A bound on how well a format can compress, so that a short file that claims to be large is
 * refused before memory and time are spent on it: a run of HDR packs 127 pixels of each channel
 * into 2 bytes; JPEG spends at least one bit on a block of 8 x 8; deflate packs at most 1032 bytes
 * into one, each of 8 pixels of a black and white PNG. */
static uint64_t most_pixels_per_byte(const air_source *source, bool hdr)
{
    const bool jpeg = source->size > 0 && source->data[0] == 0xFF;
    return hdr ? 127 / 8 + 1 : jpeg ? 8 * 64 : 8 * 1032;
}

/* Fails unless the header is of the right kind, the size within limits, and the data could hold
 * that many pixels. */
static air_status check_header(air_context *context, const air_source *source, air_stb_kind kind,
                               bool *out_words)
{
    const bool want_hdr = kind == AIR_STB_FLOATS;
    if (!jpeg_is_safe(source->data, source->size)) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: damaged or truncated JPEG: a segment does not follow upon the one "
                        "before, is cut off, or holds a Huffman table of more than 256 symbols",
                        source->path);
    }
    reader r = reader_start(source, true);
    if ((stbi_is_hdr_from_callbacks(&callbacks, &r) != 0) != want_hdr) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s: byte 0: expected a %s picture",
                        source->path, want_hdr ? "Radiance HDR" : "PNG or JPEG");
    }
    air_status status = check_png_size(context, source);
    if (status != AIR_OK) {
        return status;
    }
    int width = 0;
    int height = 0;
    int channels = 0;
    r = reader_start(source, want_hdr);
    if (stbi_info_from_callbacks(&callbacks, &r, &width, &height, &channels) == 0) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: the header is damaged, truncated or of a picture above the limits, "
                        "expected a %s picture",
                        source->path,
                        want_hdr ? "Radiance HDR (32-bit_rle_rgbe, -Y N +X M)" : "PNG or JPEG");
    }
    r = reader_start(source, false);
    *out_words =
        kind == AIR_STB_BYTES_OR_WORDS && stbi_is_16_bit_from_callbacks(&callbacks, &r) != 0;
    const uint64_t value_bytes = want_hdr ? sizeof(float) : *out_words ? 2 : 1;
    status =
        air_format_check_size(context, source->path, width > 0 ? (uint64_t)width : 0,
                              height > 0 ? (uint64_t)height : 0, value_bytes * (uint64_t)channels);
    if (status == AIR_OK &&
        (uint64_t)width * (uint64_t)height / most_pixels_per_byte(source, want_hdr) >
            source->size) {
        status = air_fail(context, AIR_ERROR_FORMAT,
                          "%s: truncated: %zu bytes cannot hold %d x %d pixels", source->path,
                          source->size, width, height);
    }
    return status;
}

air_status air_stb_decode(air_context *context, const air_source *source, air_stb_kind kind,
                          air_stb_picture *out_picture)
{
    bool words = false;
    const air_status status = check_header(context, source, kind, &words);
    if (status != AIR_OK) {
        return status;
    }
    reader r = reader_start(source, kind == AIR_STB_FLOATS);
    int width = 0;
    int height = 0;
    int channels = 0;
    air_stb_picture picture = {0};
    if (kind == AIR_STB_FLOATS) {
        picture.floats = stbi_loadf_from_callbacks(&callbacks, &r, &width, &height, &channels, 0);
    } else if (words) {
        picture.words = stbi_load_16_from_callbacks(&callbacks, &r, &width, &height, &channels, 0);
    } else {
        picture.bytes = stbi_load_from_callbacks(&callbacks, &r, &width, &height, &channels, 0);
    }
    const bool decoded = picture.floats != NULL || picture.words != NULL || picture.bytes != NULL;
    if (!decoded || r.truncated) {
        air_stb_free(&picture);
        if (r.truncated) {
            return air_fail(context, AIR_ERROR_FORMAT,
                            "%s: truncated: the picture does not end within its %zu bytes",
                            source->path, source->size);
        }
        return air_fail(context, AIR_ERROR_FORMAT, "%s: near byte %zu: damaged picture (%s)",
                        source->path, r.position, stbi_failure_reason());
    }
    picture.width = (size_t)width;
    picture.height = (size_t)height;
    picture.channels = (size_t)channels;
    *out_picture = picture;
    return AIR_OK;
}

void air_stb_free(air_stb_picture *picture)
{
    stbi_image_free(picture->bytes);
    stbi_image_free(picture->words);
    stbi_image_free(picture->floats);
    *picture = (air_stb_picture){0};
}

static void write_to_sink(void *user, void *data, int size)
{
    air_sink *const sink = user;
    (void)air_sink_write(sink, sink->size, data, (size_t)size);
}

bool air_stb_encode_png(air_sink *sink, size_t width, size_t height, size_t channels,
                        const uint8_t *bytes)
{
    const int done = stbi_write_png_to_func(write_to_sink, sink, (int)width, (int)height,
                                            (int)channels, bytes, (int)(width * channels));
    return done != 0 && !sink->failed;
}
