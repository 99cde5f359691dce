/* ktx2_write.c: images into KTX 2: R,G,B and an alpha of 1, as halfs or floats, Zstandard. */
#define IMATH_HALF_NO_LOOKUP_TABLE
#include <Imath/half.h>
#include <math.h>
#include <string.h>
#include <zstd.h>

#include "airlight/version.h"
#include "image/format.h"
#include "image/ktx2.h"

enum {
    DESCRIPTOR = 92, /* bytes: data format descriptor of four samples */
    KEYS_CAPACITY = 128,
    COMPRESSION = 3, /* Zstandard's default level */
    HALF_LARGEST = 65504
};

static void put_u16(uint8_t *bytes, uint32_t value)
{
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

static void put_u32(uint8_t *bytes, uint32_t value)
{
    put_u16(bytes, value);
    put_u16(bytes + 2, value >> 16);
}

static void put_u64(uint8_t *bytes, uint64_t value)
{
    put_u32(bytes, (uint32_t)value);
    put_u32(bytes + 4, (uint32_t)(value >> 32));
}

/* The basic data format descriptor [KTX2, section 3.10]: linear Rec. 709, signed floats. */
static void put_descriptor(uint8_t *out, bool half)
{
    static const uint8_t channels[4] = {0, 1, 2, 15};
    const uint32_t bits = half ? 16 : 32;
    memset(out, 0, DESCRIPTOR);
    put_u32(out, DESCRIPTOR);
    put_u16(out + 8, 2);               /* version */
    put_u16(out + 10, DESCRIPTOR - 4); /* of the block */
    out[12] = 1;                       /* RGBSDA */
    out[13] = 1;                       /* BT.709 */
    out[14] = 1;                       /* linear */
    for (uint32_t c = 0; c < 4; c++) {
        uint8_t *sample = out + 28 + 16 * c;
        put_u16(sample, c * bits);
        sample[2] = (uint8_t)(bits - 1);
        sample[3] = (uint8_t)(0xc0 | channels[c]); /* signed, floating */
        put_u32(sample + 8, 0xbf800000);           /* -1 */
        put_u32(sample + 12, 0x3f800000);          /* 1 */
    }
}

/* One key with its value behind; returns the bytes it takes. */
static size_t put_key(uint8_t *out, const char *key, const char *value)
{
    const size_t key_size = strlen(key) + 1, value_size = strlen(value) + 1;
    put_u32(out, (uint32_t)(key_size + value_size));
    memcpy(out + 4, key, key_size);
    memcpy(out + 4 + key_size, value, value_size);
    return 4 + (key_size + value_size + 3) / 4 * 4;
}

static size_t put_keys(uint8_t out[KEYS_CAPACITY])
{
    char writer[32] = "airlight ";
    memset(out, 0, KEYS_CAPACITY);
    strncat(writer, air_version(), sizeof writer - strlen(writer) - 1);
    const size_t size = put_key(out, "KTXorientation", "rd");
    return size + put_key(out + size, "KTXwriter", writer);
}

/* All pixels, and how many values were beyond half's range. */
static size_t put_pixels(uint8_t *out, const float *const planes[3], size_t count, bool half)
{
    size_t clamped = 0;
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 4; c++) {
            float value = c < 3 ? planes[c][i] : 1.0f;
            uint32_t bits;
            if (half) {
                if (isfinite(value) && fabsf(value) > (float)HALF_LARGEST) {
                    value = copysignf((float)HALF_LARGEST, value);
                    clamped++;
                }
                put_u16(out, imath_float_to_half(value));
                out += 2;
            } else {
                memcpy(&bits, &value, sizeof bits);
                put_u32(out, bits);
                out += 4;
            }
        }
    }
    return clamped;
}

static void put_header(uint8_t *out, const air_image *image, bool half, size_t keys_size,
                       size_t level_size, size_t unpacked_size)
{
    const size_t descriptor = AIR_KTX2_HEADER + AIR_KTX2_LEVEL;
    memcpy(out, air_ktx2_identifier, sizeof air_ktx2_identifier);
    put_u32(out + 12, half ? AIR_VK_R16G16B16A16_SFLOAT : AIR_VK_R32G32B32A32_SFLOAT);
    put_u32(out + 16, half ? 2 : 4); /* typeSize */
    put_u32(out + 20, (uint32_t)image->width);
    put_u32(out + 24, (uint32_t)image->height);
    put_u32(out + 36, 1); /* faces */
    put_u32(out + 40, 1); /* levels */
    put_u32(out + 44, AIR_KTX2_ZSTANDARD);
    put_u32(out + 48, (uint32_t)descriptor);
    put_u32(out + 52, DESCRIPTOR);
    put_u32(out + 56, (uint32_t)descriptor + DESCRIPTOR);
    put_u32(out + 60, (uint32_t)keys_size);
    put_u64(out + 80, descriptor + DESCRIPTOR + keys_size);
    put_u64(out + 88, level_size);
    put_u64(out + 96, unpacked_size);
    put_descriptor(out + descriptor, half);
}

/* Compresses the pixels behind the room that is left for everything before them. */
static air_status pack(air_context *context, const char *path, const air_image *image,
                       const float *const planes[3], bool half, air_sink *sink)
{
    const size_t count = image->width * image->height, size = count * (half ? 8 : 16);
    uint8_t keys[KEYS_CAPACITY];
    const size_t keys_size = put_keys(keys);
    const size_t front = AIR_KTX2_HEADER + AIR_KTX2_LEVEL + DESCRIPTOR + keys_size;
    const size_t capacity = front + ZSTD_compressBound(size);
    uint8_t *pixels = air_allocate(context, size, 1);
    uint8_t *file = air_allocate(context, capacity, 1);
    air_status status = AIR_OK;
    if (pixels == NULL || file == NULL) {
        status = air_fail_memory(context, path);
        goto cleanup;
    }
    const size_t clamped = put_pixels(pixels, planes, count, half);
    const size_t packed = ZSTD_compress(file + front, capacity - front, pixels, size, COMPRESSION);
    if (ZSTD_isError(packed)) {
        status = air_fail(context, AIR_ERROR_INTERNAL, "%s: %s", path, ZSTD_getErrorName(packed));
        goto cleanup;
    }
    put_header(file, image, half, keys_size, packed, size);
    memcpy(file + front - keys_size, keys, keys_size);
    if (!air_sink_write(sink, 0, file, front + packed)) {
        status = air_fail_memory(context, path);
    } else if (clamped > 0) {
        air_warn(context, "%s: %zu values beyond the range of half were clamped to +-%d", path,
                 clamped, HALF_LARGEST);
    }
cleanup:
    air_free(context, file);
    air_free(context, pixels);
    return status;
}

air_status air_ktx2_write(air_context *context, const air_image *image, const char *path,
                          const air_image_save_params *params, air_sink *sink)
{
    const float *planes[3];
    if (!air_image_colour(image, planes)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: a KTX 2 file needs the channels R,G,B or Y, the image has neither",
                        path);
    }
    return pack(context, path, image, planes, params->half, sink);
}
