/* stb_image.h: what this library takes from stb_image and stb_image_write, behind functions of our
 * own, so that theirs stay private to one file. */
#ifndef AIR_IMAGE_STB_IMAGE_H
#define AIR_IMAGE_STB_IMAGE_H

#include "image/format.h"

/* A decoded picture: rows from the top, channels interleaved; one of the three pointers is set.
 * Belongs to stb: free with air_stb_free. */
typedef struct air_stb_picture {
    size_t width, height, channels;
    uint8_t *bytes;
    uint16_t *words;
    float *floats;
} air_stb_picture;

typedef enum air_stb_kind {
    AIR_STB_BYTES = 0,          /* PNG, JPEG; 16-bit pictures reduced to bytes */
    AIR_STB_BYTES_OR_WORDS = 1, /* PNG, JPEG; 16-bit pictures as words */
    AIR_STB_FLOATS = 2          /* Radiance HDR */
} air_stb_kind;

/* AIR_ERROR_FORMAT: not of that kind, damaged, truncated or beyond the limits of
 * air_format_check_size. */
air_status air_stb_decode(air_context *context, const air_source *source, air_stb_kind kind,
                          air_stb_picture *out_picture);
void air_stb_free(air_stb_picture *picture);

/* Encodes bytes (rows from the top, 1 to 4 channels, together below 2^31) as PNG; false when out of
 * memory. */
bool air_stb_encode_png(air_sink *sink, size_t width, size_t height, size_t channels,
                        const uint8_t *bytes);

#endif
