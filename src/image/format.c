/* format.c: chooses a format by the file's extension, reads and writes files whole. */
#include "image/format.h"

#include <string.h>

typedef struct format {
    const char *extension; /* lower case */
    air_status (*read)(air_context *context, const air_source *source, air_image **out_image);
    air_status (*write)(air_context *context, const air_image *image, const char *path,
                        const air_image_save_params *params, air_sink *sink);
} format;

static const format formats[] = {
    {".exr", air_exr_read, air_exr_write},
    {".hdr", air_hdr_read, NULL},
    {".png", air_png_read, air_png_write},
    {".jpg", air_png_read, NULL},
    {".jpeg", air_png_read, NULL},
    {".pfm", air_pfm_read, air_pfm_write},
    {".ktx2", air_ktx2_read, air_ktx2_write},
};

enum { FORMAT_COUNT = sizeof(formats) / sizeof(formats[0]) };

static char lower(char c) { return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c; }

static bool ends_with(const char *path, const char *extension)
{
    const size_t length = strlen(path);
    const size_t tail = strlen(extension);
    if (length <= tail) {
        return false;
    }
    for (size_t i = 0; i < tail; i++) {
        if (lower(path[length - tail + i]) != extension[i]) {
            return false;
        }
    }
    return true;
}

static const format *find_format(const char *path)
{
    for (size_t i = 0; i < FORMAT_COUNT; i++) {
        if (ends_with(path, formats[i].extension)) {
            return &formats[i];
        }
    }
    return NULL;
}

air_status air_image_load(air_context *context, const char *path, air_image **out_image)
{
    *out_image = NULL;
    const format *const chosen = find_format(path);
    if (chosen == NULL) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: the extension names no image format that can be read: "
                        ".exr .hdr .png .jpg .jpeg .pfm .ktx2",
                        path);
    }
    void *data = NULL;
    air_source source = {.path = path};
    air_status status = air_file_read(context, path, &data, &source.size);
    if (status == AIR_OK) {
        source.data = data;
        status = chosen->read(context, &source, out_image);
        air_free(context, data);
    }
    return status;
}

void air_image_save_params_default(air_image_save_params *params)
{
    *params = (air_image_save_params){.auto_exposure = true, .view = AIR_VIEW_NEUTRAL};
}

air_status air_image_save(air_context *context, const air_image *image, const char *path,
                          const air_image_save_params *params)
{
    air_image_save_params defaults;
    if (params == NULL) {
        air_image_save_params_default(&defaults);
        params = &defaults;
    }
    const format *const chosen = find_format(path);
    if (chosen == NULL || chosen->write == NULL) {
        return air_fail(context, AIR_ERROR_UNSUPPORTED,
                        "%s: the extension names no image format that can be written: "
                        ".exr .png .pfm .ktx2",
                        path);
    }
    air_sink sink = {.context = context};
    air_status status = chosen->write(context, image, path, params, &sink);
    if (status == AIR_OK) {
        status = air_file_write(context, path, sink.data, sink.size);
    }
    air_free(context, sink.data);
    return status;
}

bool air_sink_write(air_sink *sink, size_t offset, const void *data, size_t size)
{
    if (sink->failed || size > SIZE_MAX / 2 || offset > SIZE_MAX / 2) {
        sink->failed = true;
        return false;
    }
    const size_t end = offset + size;
    if (end > sink->capacity) {
        const size_t doubled = sink->capacity <= SIZE_MAX / 2 ? 2 * sink->capacity : end;
        const size_t capacity = end > doubled ? end : doubled;
        uint8_t *grown = air_reallocate(sink->context, sink->data, capacity, 1);
        if (grown == NULL) {
            sink->failed = true;
            return false;
        }
        sink->data = grown;
        sink->capacity = capacity;
    }
    if (offset > sink->size) {
        memset(sink->data + sink->size, 0, offset - sink->size);
    }
    if (size > 0) {
        memcpy(sink->data + offset, data, size);
    }
    if (end > sink->size) {
        sink->size = end;
    }
    return true;
}

air_status air_format_check_size(air_context *context, const char *path, uint64_t width,
                                 uint64_t height, uint64_t bytes_per_pixel)
{
    const uint64_t max_bytes = (uint64_t)1 << 31;
    if (width < 1 || height < 1 || width > AIR_IMAGE_MAX_SIDE || height > AIR_IMAGE_MAX_SIDE) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: the picture is %llu x %llu, each side must be 1 to %d", path,
                        (unsigned long long)width, (unsigned long long)height, AIR_IMAGE_MAX_SIDE);
    }
    if (width * height > max_bytes / bytes_per_pixel) {
        return air_fail(context, AIR_ERROR_FORMAT,
                        "%s: the picture is %llu x %llu with %llu bytes per pixel, more than the "
                        "limit of 2^31 bytes",
                        path, (unsigned long long)width, (unsigned long long)height,
                        (unsigned long long)bytes_per_pixel);
    }
    return AIR_OK;
}
