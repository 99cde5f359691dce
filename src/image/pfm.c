/* pfm.c: portable float maps: "PF" or "Pf", size, a scale whose sign tells the byte order, then
 * rows from the bottom. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/format.h"

typedef struct pfm_header {
    size_t width, height, channels;
    bool little_endian;
    size_t data_offset;
} pfm_header;

static bool is_space(uint8_t c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/* The next word, at most 31 bytes; *position goes to the byte behind it. False at the end of data.
 */
static bool next_word(const air_source *source, size_t *position, char word[32])
{
    size_t i = *position;
    while (i < source->size && is_space(source->data[i])) {
        i++;
    }
    size_t length = 0;
    while (i < source->size && !is_space(source->data[i]) && length < 31) {
        word[length] = (char)source->data[i];
        length++;
        i++;
    }
    word[length] = '\0';
    *position = i;
    return length > 0;
}

static air_status bad_header(air_context *context, const air_source *source, size_t position,
                             const char *expected)
{
    return air_fail(context, AIR_ERROR_FORMAT, "%s: byte %zu: expected %s", source->path, position,
                    expected);
}

static air_status parse_header(air_context *context, const air_source *source, pfm_header *out)
{
    char word[32];
    size_t position = 0;
    if (source->size < 2 || source->data[0] != 'P' ||
        (source->data[1] != 'F' && source->data[1] != 'f')) {
        return bad_header(context, source, 0, "PF or Pf, the start of a portable float map");
    }
    out->channels = source->data[1] == 'F' ? 3 : 1;
    position = 2;
    unsigned long long size[2] = {0, 0};
    for (size_t i = 0; i < 2; i++) {
        const size_t start = position;
        char *end = word;
        if (next_word(source, &position, word) && word[0] >= '0' && word[0] <= '9') {
            size[i] = strtoull(word, &end, 10);
        }
        if (end == word || *end != '\0') {
            return bad_header(context, source, start, "width and height in pixels");
        }
    }
    const air_status status = air_format_check_size(context, source->path, size[0], size[1],
                                                    out->channels * sizeof(float));
    if (status != AIR_OK) {
        return status;
    }
    /* Only the sign of the scale counts; strtod would depend on the locale. */
    const size_t start = position;
    if (!next_word(source, &position, word) || word[strspn(word, "+-.0123456789eE")] != '\0' ||
        strpbrk(word, "123456789") == NULL || position >= source->size) {
        return bad_header(context, source, start, "a scale other than 0 and a line end");
    }
    out->width = (size_t)size[0];
    out->height = (size_t)size[1];
    out->little_endian = word[0] == '-';
    out->data_offset = position + 1;
    return AIR_OK;
}

static float load_float(const uint8_t bytes[4], bool little_endian)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < 4; i++) {
        bits = bits << 8 | bytes[little_endian ? 3 - i : i];
    }
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

air_status air_pfm_read(air_context *context, const air_source *source, air_image **out_image)
{
    static const char *const colour_names[3] = {"R", "G", "B"};
    static const char *const grey_names[1] = {"Y"};
    pfm_header header = {0};
    air_status status = parse_header(context, source, &header);
    if (status != AIR_OK) {
        return status;
    }
    const size_t needed = header.width * header.height * header.channels * sizeof(float);
    if (source->size - header.data_offset < needed) {
        return air_fail(
            context, AIR_ERROR_FORMAT,
            "%s: truncated: %zu x %zu pixels need %zu bytes from byte %zu, the file has "
            "%zu bytes",
            source->path, header.width, header.height, needed, header.data_offset, source->size);
    }
    air_image *image = NULL;
    status = air_image_create(context, header.width, header.height, header.channels,
                              header.channels == 3 ? colour_names : grey_names, &image);
    if (status != AIR_OK) {
        return status;
    }
    const uint8_t *in = source->data + header.data_offset;
    for (size_t y = header.height; y-- > 0;) {
        for (size_t x = 0; x < header.width; x++) {
            for (size_t c = 0; c < header.channels; c++) {
                air_image_plane(image, c)[y * header.width + x] =
                    load_float(in, header.little_endian);
                in += sizeof(float);
            }
        }
    }
    *out_image = image;
    return AIR_OK;
}

static void store_float(uint8_t bytes[4], float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof(bits));
    for (size_t i = 0; i < 4; i++) {
        bytes[i] = (uint8_t)(bits >> (8 * i));
    }
}

air_status air_pfm_write(air_context *context, const air_image *image, const char *path,
                         const air_image_save_params *params, air_sink *sink)
{
    (void)params;
    const float *planes[3];
    const bool grey = image->channel_count == 1;
    if (grey) {
        planes[0] = air_image_plane_const(image, 0);
    } else if (!air_image_colour(image, planes)) {
        return air_fail(context, AIR_ERROR_ARGUMENT,
                        "%s: a PFM needs the channels R,G,B or one channel only", path);
    }
    const size_t channels = grey ? 1 : 3;
    const size_t row_bytes = image->width * channels * sizeof(float);
    char header[64];
    const int length = snprintf(header, sizeof(header), "%s\n%zu %zu\n-1.0\n", grey ? "Pf" : "PF",
                                image->width, image->height);
    uint8_t *row = air_allocate(context, row_bytes, 1);
    if (row == NULL) {
        return air_fail_memory(context, path);
    }
    bool written = air_sink_write(sink, 0, header, (size_t)length);
    for (size_t y = image->height; y-- > 0;) {
        for (size_t x = 0; x < image->width; x++) {
            for (size_t c = 0; c < channels; c++) {
                store_float(row + (x * channels + c) * sizeof(float),
                            planes[c][y * image->width + x]);
            }
        }
        written = written && air_sink_write(sink, sink->size, row, row_bytes);
    }
    air_free(context, row);
    return written ? AIR_OK : air_fail_memory(context, path);
}
