/* ktx2.c: KTX 2 into images: one picture in a floating-point format, level 0. */
#define IMATH_HALF_NO_LOOKUP_TABLE
#include "image/ktx2.h"

#include <Imath/half.h>
#include <math.h>
#include <string.h>
#include <zstd.h>

#include "image/format.h"

/* Zstandard's smallest block is 4 bytes that stand for 128 KiB of one value. */
enum { LARGEST_EXPANSION = 32768 };

typedef struct ktx2_header {
    uint32_t vk_format, width, height, depth, layers, faces, levels, scheme;
    uint64_t keys_offset, keys_size;   /* key/value data */
    uint64_t level_offset, level_size; /* of level 0 in the file */
    uint64_t unpacked_size;
    uint64_t pixel_size;
    bool bottom_up;
} ktx2_header;

static uint32_t read_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static uint64_t read_u64(const uint8_t *bytes)
{
    return read_u32(bytes) | (uint64_t)read_u32(bytes + 4) << 32;
}

/* Do bytes offset to offset + size lie in the file? */
static bool inside(const air_source *source, uint64_t offset, uint64_t size)
{
    return offset <= source->size && size <= source->size - offset;
}

static uint64_t pixel_size(uint32_t vk_format)
{
    switch (vk_format) {
    case AIR_VK_R16G16B16A16_SFLOAT:
        return 8;
    case AIR_VK_R32G32B32A32_SFLOAT:
        return 16;
    case AIR_VK_B10G11R11_UFLOAT_PACK32:
    case AIR_VK_E5B9G9R9_UFLOAT_PACK32:
        return 4;
    default:
        return 0;
    }
}

static air_status check_kind(air_context *context, const char *path, const ktx2_header *header)
{
    if (header->pixel_size == 0) {
        return air_fail(
            context, AIR_ERROR_UNSUPPORTED,
            "%s: byte 12: format %lu cannot be read, expected R16G16B16A16_SFLOAT (97), "
            "R32G32B32A32_SFLOAT (109), B10G11R11_UFLOAT (122) or E5B9G9R9_UFLOAT (123)",
            path, (unsigned long)header->vk_format);
    }
    if (header->depth > 0 || header->layers > 1 || header->faces != 1) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: byte 28: depth %lu, %lu layers, %lu faces: expected one flat picture",
                        path, (unsigned long)header->depth, (unsigned long)header->layers,
                        (unsigned long)header->faces);
    }
    if (header->scheme != 0 && header->scheme != AIR_KTX2_ZSTANDARD) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: byte 44: supercompression %lu cannot be read, expected 0 (none) or 2 "
                        "(Zstandard)",
                        path, (unsigned long)header->scheme);
    }
    return air_format_check_size(context, path, header->width, header->height,
                                 header->pixel_size < 12 ? 12 : header->pixel_size);
}

/* Where level 0 lies, and whether its sizes can be true. */
static air_status check_level(air_context *context, const air_source *source, ktx2_header *header)
{
    const uint64_t level_count = header->levels > 1 ? header->levels : 1;
    if (level_count > 16 || source->size < AIR_KTX2_HEADER + level_count * AIR_KTX2_LEVEL) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte 40: %lu levels, expected at most 16 and an entry for each",
                        source->path, (unsigned long)header->levels);
    }
    const uint8_t *entry = source->data + AIR_KTX2_HEADER;
    header->level_offset = read_u64(entry);
    header->level_size = read_u64(entry + 8);
    header->unpacked_size = read_u64(entry + 16);
    const uint64_t expected = (uint64_t)header->width * header->height * header->pixel_size;
    if (header->unpacked_size != expected ||
        (header->scheme == 0 && header->level_size != expected)) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte 80: the picture has %llu bytes, %lu x %lu pixels need %llu",
                        source->path, (unsigned long long)header->unpacked_size,
                        (unsigned long)header->width, (unsigned long)header->height,
                        (unsigned long long)expected);
    }
    if (!inside(source, header->level_offset, header->level_size) ||
        expected / LARGEST_EXPANSION > header->level_size) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: truncated: bytes %llu to %llu of %zu are said to hold the picture",
                        source->path, (unsigned long long)header->level_offset,
                        (unsigned long long)(header->level_offset + header->level_size),
                        source->size);
    }
    return AIR_OK;
}

/* Looks for KTXorientation, "rd" (the default) or "ru". Entries: length, key, NUL, value, padding.
 */
static air_status read_keys(air_context *context, const air_source *source, ktx2_header *header)
{
    static const char key[] = "KTXorientation";
    if (!inside(source, header->keys_offset, header->keys_size)) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s: byte 56: the keys lie outside the file",
                        source->path);
    }
    const uint8_t *at = source->data + header->keys_offset;
    uint64_t left = header->keys_size;
    while (left >= 4) {
        const uint64_t length = read_u32(at);
        const uint64_t whole = 4 + (length + 3) / 4 * 4;
        if (length > left - 4) {
            return air_fail(context, AIR_ERROR_FORMAT,
                            "%s: byte %zu: a key of %llu bytes ends beyond the keys", source->path,
                            (size_t)(at - source->data), (unsigned long long)length);
        }
        if (length >= sizeof key + 2 && memcmp(at + 4, key, sizeof key) == 0) {
            header->bottom_up = at[4 + sizeof key + 1] == 'u';
        }
        if (whole >= left) {
            break;
        }
        at += whole;
        left -= whole;
    }
    return AIR_OK;
}

static air_status read_header(air_context *context, const air_source *source, ktx2_header *out)
{
    const uint8_t *data = source->data;
    if (source->size < AIR_KTX2_HEADER + AIR_KTX2_LEVEL ||
        memcmp(data, air_ktx2_identifier, sizeof air_ktx2_identifier) != 0) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte 0: expected the identifier and the header of a KTX 2 file",
                        source->path);
    }
    *out = (ktx2_header){.vk_format = read_u32(data + 12),
                         .width = read_u32(data + 20),
                         .height = read_u32(data + 24),
                         .depth = read_u32(data + 28),
                         .layers = read_u32(data + 32),
                         .faces = read_u32(data + 36),
                         .levels = read_u32(data + 40),
                         .scheme = read_u32(data + 44),
                         .keys_offset = read_u32(data + 56),
                         .keys_size = read_u32(data + 60)};
    out->pixel_size = pixel_size(out->vk_format);
    air_status status = check_kind(context, source->path, out);
    if (status == AIR_OK) {
        status = check_level(context, source, out);
    }
    return status == AIR_OK ? read_keys(context, source, out) : status;
}

static void decode_pixel(uint32_t vk_format, const uint8_t *bytes, float out[3])
{
    const uint32_t word = read_u32(bytes);
    switch (vk_format) {
    case AIR_VK_B10G11R11_UFLOAT_PACK32:
        /* Halfs without sign whose last bits are cut off. */
        out[0] = imath_half_to_float((uint16_t)((word & 0x7ff) << 4));
        out[1] = imath_half_to_float((uint16_t)((word >> 11 & 0x7ff) << 4));
        out[2] = imath_half_to_float((uint16_t)((word >> 22) << 5));
        break;
    case AIR_VK_E5B9G9R9_UFLOAT_PACK32:
        for (int c = 0; c < 3; c++) {
            out[c] = ldexpf((float)(word >> 9 * c & 0x1ff), (int)(word >> 27) - 24);
        }
        break;
    case AIR_VK_R16G16B16A16_SFLOAT:
        for (int c = 0; c < 3; c++) {
            out[c] = imath_half_to_float((uint16_t)(bytes[2 * c] | bytes[2 * c + 1] << 8));
        }
        break;
    default:
        for (int c = 0; c < 3; c++) {
            const uint32_t bits = read_u32(bytes + 4 * c);
            memcpy(&out[c], &bits, sizeof bits);
        }
        break;
    }
}

/* The bytes of level 0: those of the file, or unpacked into *out_owned. */
static air_status unpack(air_context *context, const air_source *source, const ktx2_header *header,
                         const uint8_t **out_pixels, uint8_t **out_owned)
{
    const uint8_t *level = source->data + header->level_offset;
    *out_pixels = level;
    if (header->scheme == 0) {
        return AIR_OK;
    }
    const size_t size = (size_t)header->unpacked_size;
    *out_owned = air_allocate(context, size, 1);
    *out_pixels = *out_owned;
    if (*out_owned == NULL) {
        return air_fail_memory(context, source->path);
    }
    const size_t got = ZSTD_decompress(*out_owned, size, level, (size_t)header->level_size);
    if (ZSTD_isError(got) || got != size) {
        return air_fail(context, AIR_ERROR_FORMAT, "%s: byte %llu: damaged Zstandard data: %s",
                        source->path, (unsigned long long)header->level_offset,
                        ZSTD_isError(got) ? ZSTD_getErrorName(got) : "too few bytes");
    }
    return AIR_OK;
}

air_status air_ktx2_read(air_context *context, const air_source *source, air_image **out_image)
{
    static const char *const names[3] = {"R", "G", "B"};
    ktx2_header header = {0};
    const uint8_t *pixels = NULL;
    uint8_t *owned = NULL;
    air_image *image = NULL;
    air_status status = read_header(context, source, &header);
    if (status != AIR_OK) {
        return status;
    }
    status = unpack(context, source, &header, &pixels, &owned);
    if (status == AIR_OK) {
        status = air_image_create(context, header.width, header.height, 3, names, &image);
    }
    for (size_t y = 0; y < header.height && status == AIR_OK; y++) {
        const size_t row = header.bottom_up ? header.height - 1 - y : y;
        for (size_t x = 0; x < header.width; x++) {
            float rgb[3];
            decode_pixel(header.vk_format,
                         pixels + (row * header.width + x) * (size_t)header.pixel_size, rgb);
            for (size_t c = 0; c < 3; c++) {
                air_image_plane(image, c)[y * header.width + x] = rgb[c];
            }
        }
    }
    air_free(context, owned);
    *out_image = image;
    return status;
}
