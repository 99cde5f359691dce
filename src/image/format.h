/* format.h: the file formats of images. Readers decode from memory, writers encode to memory;
 * format.c does the files. */
#ifndef AIR_IMAGE_FORMAT_H
#define AIR_IMAGE_FORMAT_H

#include "image/image.h"

/* A file as it stands in memory; path names it in messages. */
typedef struct air_source {
    const char *path;
    const uint8_t *data;
    size_t size;
} air_source;

/* A growing block of bytes that an encoder writes; free data with air_free. */
typedef struct air_sink {
    air_context *context;
    uint8_t *data;
    size_t size, capacity;
    bool failed; /* out of memory */
} air_sink;

/* Writes at an offset, growing as needed; false when out of memory. */
bool air_sink_write(air_sink *sink, size_t offset, const void *data, size_t size);

/* AIR_ERROR_FORMAT if a decoded picture would be beyond the limits: a side of 0 or above
 * AIR_IMAGE_MAX_SIDE, or more than 2^31 bytes. */
air_status air_format_check_size(air_context *context, const char *path, uint64_t width,
                                 uint64_t height, uint64_t bytes_per_pixel);

air_status air_exr_read(air_context *context, const air_source *source, air_image **out_image);
air_status air_hdr_read(air_context *context, const air_source *source, air_image **out_image);
air_status air_png_read(air_context *context, const air_source *source,
                        air_image **out_image); /* JPEG too */
air_status air_pfm_read(air_context *context, const air_source *source, air_image **out_image);
air_status air_ktx2_read(air_context *context, const air_source *source, air_image **out_image);

air_status air_exr_write(air_context *context, const air_image *image, const char *path,
                         const air_image_save_params *params, air_sink *sink);
air_status air_png_write(air_context *context, const air_image *image, const char *path,
                         const air_image_save_params *params, air_sink *sink);
air_status air_pfm_write(air_context *context, const air_image *image, const char *path,
                         const air_image_save_params *params, air_sink *sink);
air_status air_ktx2_write(air_context *context, const air_image *image, const char *path,
                          const air_image_save_params *params, air_sink *sink);

#endif
