#define IMATH_HALF_NO_LOOKUP_TABLE
#include <Imath/half.h>
#include <inttypes.h>
#include <string.h>

#include "scene/media/grid_bricks.h"

/* Mitsuba's grid volume: "VOL", the version as a byte, then little-endian: encoding, size in x, y
 * and z, channels, the bounding box as 6 floats, the values with x fastest and channels
 * interleaved. */
enum { HEADER_SIZE = 48 };
enum { ENCODING_FLOAT32 = 1, ENCODING_FLOAT16 = 2, ENCODING_UINT8 = 3 };

typedef struct vol_header {
    int32_t encoding;
    int32_t size[3];
    int32_t channels;
    float box[6];
} vol_header;

static size_t value_bytes(int32_t encoding)
{
    return encoding == ENCODING_FLOAT32 ? 4 : encoding == ENCODING_FLOAT16 ? 2 : 1;
}

static air_status read_header(air_context *context, const char *path, const uint8_t *data,
                              size_t size, vol_header *out)
{
    if (size < HEADER_SIZE || memcmp(data, "VOL", 3) != 0) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte 0: expected the %d byte header of a Mitsuba grid volume, "
                        "beginning with \"VOL\"",
                        path, HEADER_SIZE);
    }
    if (data[3] != 3) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED, "%s: byte 3: version %u, expected 3", path,
                        data[3]);
    }
    memcpy(out, data + 4, sizeof *out);
    if (out->encoding < ENCODING_FLOAT32 || out->encoding > ENCODING_UINT8) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: byte 4: encoding %" PRId32
                        ", expected 1 (float32), 2 (float16) or 3 (uint8)",
                        path, out->encoding);
    }
    for (int k = 0; k < 3; k++) {
        if (out->size[k] < 1) {
            return air_fail(context, AIR_ERROR_FORMAT,
                            "%s: byte %d: size %" PRId32 ", expected at least 1", path, 8 + 4 * k,
                            out->size[k]);
        }
        if (!isfinite(out->box[k]) || !isfinite(out->box[k + 3]) ||
            !(out->box[k] < out->box[k + 3])) {
            return air_fail(
                context, AIR_ERROR_FORMAT,
                "%s: byte %d: the bounding box goes from %g to %g, expected finite and increasing",
                path, 24 + 4 * k, (double)out->box[k], (double)out->box[k + 3]);
        }
    }
    if (out->channels != 1 && out->channels != 3) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: byte 20: %" PRId32 " channels, expected 1 or 3", path, out->channels);
    }
    return AIR_OK;
}

static void decode(int32_t encoding, const uint8_t *bytes, size_t count, float *out)
{
    if (encoding == ENCODING_FLOAT32) {
        memcpy(out, bytes, count * sizeof *out);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        if (encoding == ENCODING_FLOAT16) {
            uint16_t half;
            memcpy(&half, bytes + 2 * i, sizeof half);
            out[i] = imath_half_to_float(half);
        } else {
            out[i] = (float)bytes[i] * (1.0f / 255.0f);
        }
    }
}

static air_status make_grid(air_context *context, const char *path, const uint8_t *data,
                            size_t size, air_grid **out_grid)
{
    vol_header header;
    air_status status = read_header(context, path, data, size, &header);
    if (status != AIR_OK) {
        return status;
    }
    air_grid_source source = {.what = path, .channels = (size_t)header.channels};
    for (int k = 0; k < 3; k++) {
        source.size[k] = (size_t)header.size[k];
    }
    status = air_grid_check_size(context, path, source.size, source.channels);
    if (status != AIR_OK) {
        return status;
    }
    const size_t count = source.size[0] * source.size[1] * source.size[2] * source.channels;
    if ((size - HEADER_SIZE) / value_bytes(header.encoding) < count) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: byte %d: expected %zu bytes of values, the file ends after %zu", path,
                        HEADER_SIZE, count * value_bytes(header.encoding), size - HEADER_SIZE);
    }
    air_grid_map_box(source.size, header.box, header.box + 3, source.index_to_local);
    float *values = air_allocate(context, count, sizeof *values);
    if (values == NULL) {
        return air_fail_memory(context, path);
    }
    decode(header.encoding, data + HEADER_SIZE, count, values);
    status = air_grid_make_dense(context, &source, values, out_grid);
    air_free(context, values);
    return status;
}

air_status air_grid_load_vol(air_context *context, const char *path, air_grid **out_grid)
{
    void *data = NULL;
    size_t size = 0;
    air_status status = air_file_read(context, path, &data, &size);
    if (status == AIR_OK) {
        status = make_grid(context, path, data, size, out_grid);
    }
    air_free(context, data);
    return status;
}
